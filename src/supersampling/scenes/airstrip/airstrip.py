"""The built-in scene ``airstrip``: planes, lorries and drones race round an infield before painted walls."""

import numpy as np

from supersampling.scenes.airstrip import vehicles
from supersampling.scenes.airstrip.field import field
from supersampling.scenes.airstrip.materials import Paints
from supersampling.scenes.airstrip.motion import lane
from supersampling.scenes.kit.builder import Builder, Part
from supersampling.scenes.kit.course import Course
from supersampling.scenes.kit.furniture import crate
from supersampling.scenes.kit.motion import chain, rotation, spin, sway
from supersampling.scenes.kit.routes import walk
from supersampling.scenes.kit.shapes import box, join, lathe
from supersampling.scenes.scene import Route, Scene, Sky, Sun

LORRY_SPEED, DRONE_SPEED, TAXI_SPEED, RACER_SPEED, HIGH_SPEED = 12.0, -15.0, 3.5, 31.0, -38.0


def _fly(b: Builder, p: Paints, course: Course, speed: float, start: float, look: int, bank: float) -> None:
    """Add one plane with its turning propeller; ``look`` selects the livery and the kind."""
    ride = course.ride(speed, start, bank)
    body = vehicles.plane(p.liveries[look % 4], p.iron, p.glass, biplane=look % 2 == 1)
    b.move(body, ride)
    b.move(vehicles.airscrew(p.iron), chain(ride, spin(vehicles.NOSE, (1, 0, 0), 2.3 + 0.2 * look)))


def _planes(b: Builder, p: Paints) -> None:
    taxi = lane(25.5, 13.2, vehicles.WHEELS_DOWN, vehicles.WHEELS_DOWN)
    for k in range(2):
        _fly(b, p, taxi, TAXI_SPEED, 0.5 * k + 0.11, k, 0.0)
    low = lane(30.0, 16.2, 4.6, 5.4)
    for k in range(4):
        _fly(b, p, low, RACER_SPEED, (0.0, 0.21, 0.49, 0.77)[k], k + 2, 0.65)
    high = lane(36.3, 21.5, 7.6, 8.4, 3)
    for k in range(2):
        _fly(b, p, high, HIGH_SPEED, 0.45 * k, k, 0.65)


def _lorries(b: Builder, p: Paints) -> None:
    """Add four lorries: tanks and crates in turn; their axles roll."""
    course = lane(17.6, 9.0, 0.0, 0.0)
    boxes = [crate(0.8, 2 + 3 * k).shift(-1.75 + 0.85 * (k % 3), 1.25, -0.45 + 0.9 * (k // 3)) for k in range(6)]
    boxes += [crate(0.7, 7 + k).turn_y(9 * k).shift(-1.4 + 0.9 * k, 2.0, -0.3 + 0.4 * k) for k in range(2)]
    loads: tuple[list[Part], list[Part]] = (vehicles.tank(p.tank, p.iron), [(join(boxes), p.crates)])
    for k in range(4):
        ride = course.ride(LORRY_SPEED, 0.25 * k + 0.03 * (k % 2))
        b.move(vehicles.truck(p.lorries[k % 2], p.iron, p.glass, loads[k % 2]), ride)
        for x in vehicles.AXLES:
            roll = spin((x, vehicles.TYRE, 0), (0, 0, 1), -LORRY_SPEED / (2 * np.pi * vehicles.TYRE))
            b.move(vehicles.axle(p.iron), chain(ride, roll))


def _drones(b: Builder, p: Paints) -> None:
    course = lane(21.0, 11.6, 3.0, 3.9, 3)
    for k in range(3):
        ride = course.ride(DRONE_SPEED, 0.31 * k, 0.5)
        b.move(vehicles.drone((p.cone, p.white, p.cone)[k], p.iron), ride)
        for j, arm in enumerate(vehicles.ARMS):
            b.move(vehicles.rotor(p.iron), chain(ride, spin(arm, (0, 1, 0), 5.3 * (1 - 2 * (j in (1, 2))), 0.7 * j)))


def _windsock(b: Builder, p: Paints) -> None:
    """Add a striped sleeve on the mast that swings in the wind."""
    sleeve = lathe([(0.4, 0.0), (0.36, -0.9), (0.22, -2.3)], 20)
    inner = lathe([(0.2, -2.3), (0.35, -0.9), (0.39, 0.0)], 20)
    cone = join([sleeve, inner]).transform(rotation((0, 0, 1), np.radians(78))).map_uv((1.0, 0.45))
    arm = box((0.5, 0.04, 0.04), (0.0, 0.0, 0.0))
    motion = chain(sway((8.0, 5.8, 0.0), (0, 1, 0), 24, 0.11), sway((0.12, 0, 0), (0, 0, 1), 7, 0.37, 1.0))
    b.move([(cone, p.cone), (arm, p.iron)], motion)


def _routes() -> list[Route]:
    return [
        walk("hangars", [(-7.0, 1.6, -3.6), (3.0, 1.65, -3.8)], [(-6.0, 3.4, -25), (4.0, 3.4, -25)]),
        walk("terminal", [(7.0, 1.6, 3.6), (-2.0, 1.6, 3.8)], [(8.0, 3.3, 27), (-8.0, 3.5, 27)]),
        walk("grandstand", [(4.6, 1.65, 3.9), (10.2, 1.6, 1.6)], [(36.0, 3.4, 2.0), (40.0, 3.4, -4.0)]),
        walk("north east", [(9.8, 1.6, -2.2), (1.8, 1.65, -3.9)], [(24.0, 3.4, -24), (15.0, 3.4, -26)]),
        walk("containers", [(-5.0, 1.6, 3.6), (-10.3, 1.65, 1.8)], [(-38.0, 3.2, -2.0), (-40.0, 3.6, 4.0)]),
        walk("north west", [(-9.8, 1.6, -2.4), (-2.0, 1.65, -3.6)], [(-26.0, 3.3, -25), (-14.0, 3.4, -26)]),
        walk("south west", [(-9.4, 1.65, 2.6), (-1.8, 1.6, 3.8)], [(-24.0, 3.4, 26), (-10.0, 3.4, 27)]),
        walk("east bend", [(10.4, 1.6, -2.6), (9.8, 1.6, 2.6)], [(38.0, 3.2, -12.0), (38.0, 3.4, 12.0)]),
        walk("south east", [(9.6, 1.65, 2.4), (2.6, 1.6, 3.8)], [(26.0, 3.3, 26), (10.0, 3.4, 27)]),
        walk("north line", [(5.0, 1.65, -3.6), (-5.0, 1.6, -3.9)], [(2.0, 3.2, -25), (-20.0, 3.4, -25)]),
    ]


def airstrip() -> Scene:
    """Build a race day on a small airfield.

    Planes at 31 and 38 m/s, drones and lorries circle the camera in both directions.
    """
    b = Builder()
    p = Paints(b)
    for part in (field, _planes, _lorries, _drones, _windsock):
        part(b, p)
    meshes, objects = b.build()
    return Scene(
        name="airstrip",
        materials=b.materials,
        meshes=meshes,
        objects=objects,
        routes=_routes(),
        sun=Sun((-0.5, 0.62, 0.42), (4.4, 3.8, 2.9)),
        sky=Sky((0.16, 0.34, 0.72), (0.62, 0.74, 0.9), (0.26, 0.25, 0.18), 0.8),
        exposure=0.8,
        near=0.1,
        far=160.0,
        attribution="Code and text: MIT. Grass and gravel: scikit-image's photographs, CC0. Letters: DejaVu fonts, "
        "Bitstream Vera licence.",
    )
