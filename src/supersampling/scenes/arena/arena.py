"""The built-in scene ``arena``: walking robots under name plates, and a head-up display before the camera."""

from dataclasses import replace
from typing import Literal

import numpy as np

from supersampling.scenes.arena.figures import HEAD
from supersampling.scenes.arena.gait import biped, crawler
from supersampling.scenes.arena.materials import Materials
from supersampling.scenes.arena.ring import BRAZIERS, crowd, obstacles, ring, trim
from supersampling.scenes.kit.builder import Builder, Part
from supersampling.scenes.kit.course import Course
from supersampling.scenes.kit.motion import chain, shuttle, spin, translation
from supersampling.scenes.kit.routes import walk
from supersampling.scenes.kit.shapes import Shape, quad
from supersampling.scenes.scene import Array, Object, PointLight, Route, Scene, Sky, Sun, Transform

GLASS = 0.5  # metres from the eye to the head-up display
PIXEL = 2 * GLASS * np.tan(1.05 / 2) / 1080  # metres of one pixel of a 1080p frame there
LAYER = 0.002  # metres between the display's layers
WALKERS = (  # lane's radius, speed in m/s (negative: clockwise), start, size; one a figure of `Materials`
    (3.6, 1.0, 0.1, 1.55),
    (9.3, 1.35, 0.05, 1.0),
    (9.3, 1.35, 0.56, 1.0),
    (7.9, -1.2, 0.3, 1.1),
    (4.9, -1.3, 0.62, 0.95),
    (7.9, -1.2, 0.82, 1.05),
    (9.3, 1.35, 0.3, 1.0),
    (4.9, -1.3, 0.12, 1.0),
)
CRAWLERS = 2  # the last figures


class Stage:
    """Adds moving objects to a builder and stores the frame of each."""

    def __init__(self, builder: Builder) -> None:
        self._builder = builder
        self._frames: list[Literal["world", "camera", "billboard"]] = []

    def add(self, parts: list[Part], transform: Transform) -> None:
        self._put(parts, transform, "world")

    def label(self, parts: list[Part], transform: Transform) -> None:
        """Add parts in the camera's axes at a place in the world."""
        self._put(parts, transform, "billboard")

    def glass(self, parts: list[Part], transform: Transform) -> None:
        """Add parts in front of the camera."""
        self._put(parts, transform, "camera")

    def _put(self, parts: list[Part], transform: Transform, frame: Literal["world", "camera", "billboard"]) -> None:
        self._builder.move(parts, transform)
        self._frames.append(frame)

    def with_frames(self, objects: list[Object]) -> list[Object]:
        """Return the builder's objects with their frames: first the static one, then in the order of adding."""
        return [objects[0], *(replace(o, frame=f) for o, f in zip(objects[1:], self._frames, strict=True))]


def _card(width: float, height: float) -> Shape:
    return quad((-width / 2, height / 2, 0), (width, 0, 0), (0, -height, 0))


def _above(ride: Transform, height: float) -> Transform:
    """Return the place ``height`` above a moving object, without its rotation."""

    def pose(seconds: float) -> Array:
        return translation(ride(seconds)[:3, 3] + np.array([0.0, height, 0.0])).astype(np.float32)

    return pose


def _lane(radius: float) -> Course:
    """Return a wavy way around the middle."""
    angle = np.linspace(0, 2 * np.pi, 37)[:-1]
    reach = radius + 0.3 * np.sin(3 * angle)
    return Course(np.stack([reach * np.cos(angle), 0 * angle, -reach * np.sin(angle)], 1))


def _figures(stage: Stage, m: Materials) -> None:
    """Add robots and creatures on their lanes, each under its plate, and two signs that bob."""
    for k, (radius, speed, start, size) in enumerate(WALKERS):
        ride = _lane(radius).ride(speed, start)
        if k < len(WALKERS) - CRAWLERS:
            biped(stage.add, ride, abs(speed), 1.1 * k, m.coats[k % 6], k, size)
            top = HEAD * size
        else:
            crawler(stage.add, ride, abs(speed), 1.3 * k, m.coats[3 - k % 2])
            top = 1.15
        stage.label([(_card(1.5, 0.47), m.plates[k])], _above(ride, top + 0.46))
        if k in (0, 4):
            sign = chain(_above(ride, top + 1.02), shuttle((0, 0, 0), (0, 0.14, 0), 0.7))
            stage.label([(_card(0.42, 0.42), m.marks[k // 4])], sign)


def _still(x: float, y: float, layer: int = 0) -> Transform:
    """Return a fixed place on the display, in pixels of a 1080p frame from its middle (right, up)."""
    matrix = translation((x * PIXEL, y * PIXEL, layer * LAYER - GLASS)).astype(np.float32)

    def pose(seconds: float) -> Array:
        return matrix

    return pose


def _display(stage: Stage, m: Materials) -> None:
    """Add a head-up display: panels, log, map with its needle, cross-hair, a marker that slides along the title."""
    for material, width, height, x, y in (
        (m.vitals, 422, 141, -725, -445),
        (m.title, 614, 77, 0, 482),
        (m.log, 422, 211, 725, -150),
        (m.map, 200, 200, -836, 416),
        (m.aim, 110, 110, 0, 0),
        (m.slots, 480, 96, 696, -468),
    ):
        stage.glass([(_card(width * PIXEL, height * PIXEL), material)], _still(x, y))
    long, wide = 62 * PIXEL, 7 * PIXEL
    needle = Shape(
        np.array([[-wide, -0.25 * long, 0], [wide, -0.25 * long, 0], [0, long, 0]]),
        np.tile([0.0, 0.0, 1.0], (3, 1)),
        np.array([[0.0, 1.0], [1.0, 1.0], [0.5, 0.0]]),
        np.array([[0, 1, 2]]),
    )
    stage.glass([(needle, m.pointer)], chain(_still(-836, 416, 1), spin((0, 0, 0), (0, 0, 1), -0.11)))
    slide = shuttle((-150 * PIXEL, 0, 0), (150 * PIXEL, 0, 0), 0.09)
    stage.glass([(_card(12 * PIXEL, 26 * PIXEL), m.pointer)], chain(_still(0, 430, 1), slide))


def _routes() -> list[Route]:
    """Return arcs of 45 degrees along the wall that look across the ring, and four that look along the lanes."""
    routes = []
    names = (
        "east",
        "north",
        "west",
        "south",
        "north east",
        "north west",
        "south west",
        "south east",
        "sun side",
        "gate",
    )
    for k, name in enumerate(names):
        first = (0, 90, 180, 270, 45, 135, 225, 315, 22, 202)[k]
        angle = np.radians(first + np.linspace(-24, 24, 6))
        eye = np.stack([11.7 * np.cos(angle), np.full(6, 1.62), -11.7 * np.sin(angle)], 1)
        aside = np.radians(first + np.linspace(-24, 24, 6) + (35, -35, 0, 50, -20)[k % 5])
        focus = np.stack([3.0 * np.cos(aside), np.full(6, 1.35), -3.0 * np.sin(aside)], 1)
        routes.append(walk(name, eye, focus))
    return routes


def arena() -> Scene:
    """Build a ring of sand, 28 m across, in which eight machines walk with names and health above them."""
    b = Builder()
    m, stage = Materials(b), Stage(b)
    for part in (ring, crowd, trim, obstacles):
        part(b, m)
    _figures(stage, m)
    _display(stage, m)
    meshes, objects = b.build()
    return Scene(
        name="arena",
        materials=b.materials,
        meshes=meshes,
        objects=stage.with_frames(objects),
        routes=_routes(),
        sun=Sun((0.55, 0.6, 0.38), (4.6, 3.8, 2.7)),
        points=[PointLight((x, y + 0.4, z), (9.0, 4.4, 1.6), 9.0) for x, y, z in BRAZIERS],
        sky=Sky((0.14, 0.3, 0.66), (0.7, 0.72, 0.78), (0.32, 0.26, 0.18), 0.8),
        exposure=0.72,
        near=0.1,
        far=80.0,
        attribution="Code and text: MIT. Gravel: scikit-image's photograph, CC0. Letters: DejaVu fonts, "
        "Bitstream Vera licence.",
    )
