"""Camera routes of a file: its perspective cameras, and orbits, dollies and walks around or through its geometry."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supersampling.scenes.gltf.document import Document
from supersampling.scenes.gltf.features import Deviation
from supersampling.scenes.gltf.nodes import Matrix, NodeTransform, SceneNode
from supersampling.scenes.gltf.notes import Notes
from supersampling.scenes.gltf.survey import Survey
from supersampling.scenes.gltf.walks import BEHIND, walks
from supersampling.scenes.scene import Array, Route, Transform

Points = NDArray[np.float64]
_LAID = 18  # routes besides the cameras: three times the cycle in which splits get routes
_WALKABLE = 4.0  # metres of the radius: walk inside larger geometry, and around smaller
_OUTSIDE = 6  # of these routes are around a walkable scene if there is room for the others inside
_GOLDEN = np.pi * (3.0 - 5.0**0.5)  # radians between successive routes, so that no two look from the same side


def camera_routes(
    document: Document, nodes: Sequence[SceneNode], geometry: Survey, factor: float, notes: Notes
) -> list[Route]:
    """Return one route per perspective camera of the scene's nodes, moving with its node; the world is scaled."""
    root = np.diag([factor, factor, factor, 1.0])
    routes = []
    for item in nodes:
        if item.node.camera is None:
            continue
        camera = document.item("cameras", item.node.camera)
        lens = camera.perspective
        if lens is None or not 0.0 < (lens.yfov or 0.0) < np.pi:
            notes.add(Deviation.ORTHOGRAPHIC)
            continue
        transform = item.transform.under(root)
        if abs(np.linalg.det(transform.matrix(0.0)[:3, :3])) < 1e-18:
            notes.add(Deviation.FLAT_CAMERAS)
            continue
        _note_lens(lens, _rigid(transform.matrix(0.0)).astype(np.float64), geometry, factor, notes)
        name = item.node.name or camera.name or f"camera {item.node.camera}"
        routes.append(Route(name, _trace(transform), recorded=_recorded(transform), fov=float(lens.yfov)))
    return routes


def _note_lens(lens: Any, place: Matrix, geometry: Survey, factor: float, notes: Notes) -> None:
    """Note an aspect ratio, and near and far planes that would cut geometry in view of a camera in a scaled world."""
    if lens.aspectRatio is not None:
        notes.add(Deviation.ASPECT)
    local = (geometry.surface - place[:3, 3]) @ place[:3, :3] / factor
    depth, slope = -local[:, 2], np.tan(0.5 * lens.yfov)
    seen = (np.abs(local[:, 1]) < slope * depth) & (np.abs(local[:, 0]) < (lens.aspectRatio or 16 / 9) * slope * depth)
    near, far = lens.znear or 0.0, np.inf if lens.zfar is None else lens.zfar
    if (seen & ((depth < near) | (depth > far))).any():
        notes.add(Deviation.PLANES)


def _recorded(transform: NodeTransform) -> Transform:
    """Return camera-to-world matrices without the scale of the nodes above, which cameras ignore."""
    if transform.moves:
        return lambda seconds: _rigid(transform.matrix(seconds))
    fixed = _rigid(transform.matrix(0.0))
    return lambda seconds: fixed


def _rigid(matrix: Matrix) -> Array:
    out = np.eye(4)
    back = matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
    right = np.cross(matrix[:3, 1], back)
    right /= np.linalg.norm(right)
    out[:3, :3] = np.stack([right, np.cross(back, right), back], axis=1)
    out[:3, 3] = matrix[:3, 3]
    return out.astype(np.float32)


def _trace(transform: NodeTransform) -> Array:
    """Return the camera's positions in its first minute, ``(N, 3)``."""
    moments = np.linspace(0.0, 60.0, 241) if transform.moves else (0.0, 0.0)
    return np.stack([transform.matrix(t)[:3, 3] for t in moments]).astype(np.float32)


def geometry_routes(geometry: Survey, walkable: bool) -> list[Route]:
    """Return routes from the geometry: orbits and dollies around it and, if it is walkable, walks through it."""
    around = [_around(geometry, k) for k in range(_LAID)]
    if not walkable:
        return around
    # The outside of a hall whose walls have only inner faces is not meant to be seen: use it only as a last resort.
    hidden = [float(geometry.backs_seen(route.points[::8].astype(np.float64)).mean()) >= BEHIND for route in around]
    shown = [route for route, behind in zip(around, hidden) if not behind]
    inside = walks(geometry, _LAID - min(len(shown), _OUTSIDE))
    rest = [route for route, behind in zip(around, hidden) if behind]
    outside = (shown + rest)[: _LAID - len(inside)]
    # Spread evenly among each other, so that each split has both.
    order = [((k + 0.5) / len(kind), route) for kind in (inside, outside) for k, route in enumerate(kind)]
    return [route for _, route in sorted(order, key=lambda pair: pair[0])]


def is_walkable(radius: float) -> bool:
    """Return whether geometry of this radius in metres is large enough to walk inside."""
    return radius > _WALKABLE


def _around(geometry: Survey, k: int) -> Route:
    """Return route ``k`` of a sequence of two orbits and a dolly, each from another side, height and distance."""
    centre, reach = geometry.centre, geometry.radius
    angle = k * _GOLDEN
    distance = reach * (1.05, 1.35, 1.2, 1.7)[k % 4]
    height = reach * (0.15, 0.55, 0.3, 0.8, -0.1)[k % 5]
    # Floors must not be seen from below.
    height = max(height, geometry.lo[1] - centre[1] + 0.05 * reach)
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


def planes(geometry: Survey, routes: Sequence[Route]) -> tuple[float, float]:
    """Return the near and far plane in metres that contain the bounds as seen from every route."""
    eyes = np.concatenate([route.points for route in routes]).astype(np.float64)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    box = geometry.lo + corners * (geometry.hi - geometry.lo)
    farthest = max(float(np.linalg.norm(box - eye, axis=1).max()) for eye in eyes)
    return float(np.clip(0.004 * geometry.radius, 0.005, 0.2)), 1.1 * farthest
