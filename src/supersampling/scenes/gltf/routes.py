"""Camera routes of a file: its own perspective cameras, and orbits and dollies laid around or through its geometry."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from supersampling.scenes.gltf.document import Document
from supersampling.scenes.gltf.nodes import Matrix, NodeTransform, SceneNode
from supersampling.scenes.gltf.notes import Notes
from supersampling.scenes.gltf.survey import Survey
from supersampling.scenes.gltf.walks import BEHIND, walks
from supersampling.scenes.scene import Array, Route, Transform

Points = NDArray[np.float64]
_LAID = 18  # routes besides the cameras: three times the cycle in which the splits take them
_PLACE = 4.0  # metres: what is larger is a place to walk in, what is smaller an object to walk around
_OUTSIDE = 6  # of them around a place, where there is room enough for the others within
_GOLDEN = np.pi * (3.0 - 5.0**0.5)  # radians between successive routes, so that no two look from the same side


def camera_routes(document: Document, nodes: Sequence[SceneNode], root: Matrix, notes: Notes) -> list[Route]:
    """One route a perspective camera of the scene's nodes, moving where its node moves."""
    routes = []
    for placed in nodes:
        if placed.node.camera is None:
            continue
        camera = document.item("cameras", placed.node.camera)
        lens = camera.perspective
        if lens is None or not 0.0 < (lens.yfov or 0.0) < np.pi:
            notes.add("cameras that are not perspective are left out")
            continue
        place = placed.place.under(root)
        if abs(np.linalg.det(place.at(0.0)[:3, :3])) < 1e-18:
            notes.add("cameras of no size are left out")
            continue
        name = placed.node.name or camera.name or f"camera {placed.node.camera}"
        routes.append(Route(name, _trace(place), recorded=_recorded(place), fov=float(lens.yfov)))
    return routes


def _recorded(place: NodeTransform) -> Transform:
    """Camera-to-world matrices without the scale of the nodes above, which a camera does not have."""
    if place.moves:
        return lambda seconds: _rigid(place.at(seconds))
    fixed = _rigid(place.at(0.0))
    return lambda seconds: fixed


def _rigid(matrix: Matrix) -> Array:
    out = np.eye(4)
    back = matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
    right = np.cross(matrix[:3, 1], back)
    right /= np.linalg.norm(right)
    out[:3, :3] = np.stack([right, np.cross(back, right), back], axis=1)
    out[:3, 3] = matrix[:3, 3]
    return out.astype(np.float32)


def _trace(place: NodeTransform) -> Array:
    """Where the camera is in its first minute, ``(N, 3)``."""
    moments = np.linspace(0.0, 60.0, 241) if place.moves else (0.0, 0.0)
    return np.stack([place.at(t)[:3, 3] for t in moments]).astype(np.float32)


def laid_routes(found: Survey, place: bool) -> list[Route]:
    """Routes from the bounds: walks through a place where there is room, orbits and dollies around an object or a place."""
    around = [_around(found, k) for k in range(_LAID)]
    if not place:
        return around
    # Of a hall whose walls have no outside, the outside is not meant to be seen, unless there is nothing else.
    hidden = [float(found.backs_seen(route.points[::8].astype(np.float64)).mean()) >= BEHIND for route in around]
    shown = [route for route, behind in zip(around, hidden) if not behind]
    inside = walks(found, _LAID - min(len(shown), _OUTSIDE))
    rest = [route for route, behind in zip(around, hidden) if behind]
    outside = (shown + rest)[: _LAID - len(inside)]
    # Spread evenly among each other, so that each split has both.
    order = [((k + 0.5) / len(kind), route) for kind in (inside, outside) for k, route in enumerate(kind)]
    return [route for _, route in sorted(order, key=lambda one: one[0])]


def is_place(radius: float) -> bool:
    """Whether geometry of this radius in metres is something to walk in."""
    return radius > _PLACE


def _around(found: Survey, k: int) -> Route:
    """Two orbits, then a dolly, and so on; each with its own side, height, distance and focus."""
    centre, reach = found.centre, found.radius
    angle = k * _GOLDEN
    distance = reach * (1.05, 1.35, 1.2, 1.7)[k % 4]
    height = reach * (0.15, 0.55, 0.3, 0.8, -0.1)[k % 5]
    # A floor is not to be looked at from below.
    height = max(height, found.lo[1] - centre[1] + 0.05 * reach)
    if k % 3 < 2:
        turn = angle + np.linspace(0.0, 2.0, 33)
        level = np.sqrt(max(distance**2 - height**2, (0.5 * distance) ** 2))
        points = centre + np.stack([level * np.sin(turn), np.full(33, height), level * np.cos(turn)], axis=1)
        name = f"orbit {k}"
    else:
        side = np.array((np.sin(angle), 0.0, np.cos(angle)))
        along = np.array((side[2], 0.0, -side[0]))
        lead = np.linspace(-0.6, 0.6, 25)[:, None] * reach * along
        points = centre + side * distance * np.linspace(1.15, 0.95, 25)[:, None] + lead + (0.0, height, 0.0)
        name = f"dolly {k}"
    tilt = np.array((np.cos(angle), 0.3, -np.sin(angle))) * 0.15 * reach
    return Route(name, points.astype(np.float32), np.stack([centre - tilt, centre + tilt]).astype(np.float32))


def planes(found: Survey, routes: Sequence[Route]) -> tuple[float, float]:
    """Near and far plane in metres that hold the bounds as seen from every route."""
    eyes = np.concatenate([route.points for route in routes]).astype(np.float64)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    box = found.lo + corners * (found.hi - found.lo)
    farthest = max(float(np.linalg.norm(box - eye, axis=1).max()) for eye in eyes)
    return float(np.clip(0.004 * found.radius, 0.005, 0.2)), 1.1 * farthest
