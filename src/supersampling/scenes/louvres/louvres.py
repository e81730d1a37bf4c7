"""The built-in scene ``louvres``: a street of louvres, fins, slats, meshes and stripes in clear daylight, all matt."""

import numpy as np

from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.routes import walk
from supersampling.scenes.kit.shapes import Point
from supersampling.scenes.louvres import facades, street
from supersampling.scenes.louvres.materials import Palette
from supersampling.scenes.scene import Array, Route, Scene, Sky, Sun, look_at


def _routes() -> list[Route]:
    """Return walks along and towards the regular structures, 4 to 10 m away from most."""
    return [
        walk("along the pavilion", [(-12.5, 1.6, -2.6), (2.5, 1.6, -2.6)], [(-9.0, 2.3, -7), (6.5, 2.3, -7)]),
        walk("along the shops", [(11.5, 1.6, 2.7), (-4.0, 1.6, 2.7)], [(8.0, 2.1, 7), (-8.0, 2.1, 7)]),
        walk("balcony from across", [(10.0, 1.6, 3.0), (-5.0, 1.6, 2.9)], [(6.5, 3.4, -7), (-8.5, 3.4, -7)]),
        walk("shops from across", [(-11.5, 1.7, -2.6), (0.0, 1.7, -2.7)], [(-8.0, 2.4, 7), (4.0, 2.4, 7)]),
        walk("to the hall", [(-1.0, 1.6, -2.8), (11.5, 1.6, -2.8)], [(12.0, 2.0, -2.0), (17.0, 2.4, 1.0)]),
        walk("to the tower", [(2.0, 1.6, 2.8), (-11.5, 1.6, 2.8)], [(-10.0, 2.2, 1.0), (-15.4, 2.6, -1.0)]),
        walk("through the pergola", [(3.2, 1.6, 0.0), (12.8, 1.6, 0.0)], [(9.0, 1.8, -0.3), (17.0, 2.0, -0.6)]),
        walk("round the cage", [(-7.6, 1.65, 2.6), (-2.0, 1.65, 2.7)], [(-4.6, 1.6, 0.0), (-4.4, 1.6, -0.6)]),
        walk("out of the pergola", [(12.8, 1.6, 0.1), (3.4, 1.6, 0.1)], [(4.0, 1.7, 0.6), (-4.6, 1.7, 0.2)]),
        walk("fence", [(13.2, 1.6, -4.0), (13.2, 1.6, 3.6)], [(17.0, 2.2, -2.0), (17.0, 2.2, 1.8)]),
        walk("trellis", [(-11.6, 1.6, 3.4), (-11.8, 1.6, -3.6)], [(-15.4, 2.2, 2.2), (-15.4, 2.4, -1.4)]),
        walk("past the cage", [(-1.0, 1.6, -2.7), (-11.0, 1.6, -2.7)], [(-4.6, 1.6, 0.4), (-9.2, 1.5, 1.4)]),
        _tripod("tripod before the cage", (-6.6, 1.6, 3.2), (-3.6, 1.9, -4.0)),
        _tripod("tripod before the shops", (7.5, 1.6, -3.2), (3.0, 2.2, 7.0)),
        _tripod("tripod under the pergola", (3.4, 1.6, 0.2), (12.0, 2.2, -0.6)),
        _tripod("tripod before the pavilion", (-12.5, 1.6, 3.0), (-7.0, 2.4, -7.0)),
    ]


def _tripod(name: str, eye: Point, focus: Point) -> Route:
    """Return the route of a camera that stands, to show what the jitter does to aliased structure.

    Not the kit's `tripod`: the inverse differs from it in the last bits, and data sets of this scene exist.
    """
    place = np.asarray(eye, float)
    pose = np.linalg.inv(look_at(place, np.asarray(focus, float) - place)).astype(np.float32)

    def recorded(_: float) -> Array:
        return pose

    return Route(name, np.array([eye, eye], np.float32), None, recorded)


def louvres() -> Scene:
    """Build a street of 32 x 14 m whose structures have periods of 4 to 12 cm.

    They beat against the pixels as the camera walks by.
    """
    b = Builder()
    p = Palette(b)
    for part in (facades.ground, facades.pavilion, facades.shops, facades.hall, facades.lattice, facades.towers):
        part(b, p)
    for part in (street.pergola, street.furniture, street.screens, street.movers):
        part(b, p)
    meshes, objects = b.build()
    return Scene(
        "louvres",
        b.materials,
        meshes,
        objects,
        _routes(),
        sun=Sun((-0.42, 0.72, 0.5), (4.0, 3.5, 2.8)),
        sky=Sky((0.2, 0.4, 0.85), (0.75, 0.83, 0.92), (0.3, 0.27, 0.23), 0.8),
        exposure=0.8,
        near=0.1,
        far=90.0,
        attribution="Code: MIT. Grass: scikit-image's photograph, CC0.",
    )
