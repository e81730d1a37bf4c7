"""Camera routes along a track: the driveline of a race track, or walks over an arena's navigation mesh.

The quads of ``quads.xml`` in the order of ``graph.xml``'s main loop give a middle line and a width. The line is cut
into consecutive pieces with gaps, so that routes do not overlap; each has another eye height and position across the
road.
"""

from collections import deque
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError
from supersampling.scenes.scene import Route
from supersampling.scenes.stk.nodes import parse
from supersampling.scenes.stk.numbers import attribute, index
from supersampling.scenes.stk.placement import MIRROR, Triple, triple

Points = NDArray[np.float64]
_FEWEST = 8
_LONGEST = 1e5  # metres of a driveline
_LENGTH = 60.0  # metres of a route if the track is long enough
_GAP = 3.0  # metres between two routes
_STEP = 1.0  # metres between a route's points
_EYES = (1.3, 1.9, 1.6, 2.3)  # metres above the road
_ACROSS = (0.0, 0.35, -0.35, 0.15, -0.15)  # of half the road's width


def read_routes(track: Path) -> list[Route]:
    """Return at least eight routes of a track folder, right-handed lines of points one metre apart.

    Raises:
        UserError: The folder has neither a driveline nor a navigation mesh, or an empty one.
    """
    if (track / "quads.xml").is_file():
        return _cut(*_driveline(track))
    if (track / "navmesh.xml").is_file():
        return _walks(parse(track / "navmesh.xml"))
    raise UserError(f"The track {track.name} has neither quads.xml nor navmesh.xml: use a track with one of them.")


def read_quads(element: Element) -> Points:
    """Return corners ``(N, 4, 3)`` of a driveline's quads in the game's space; ``i:j`` means corner j of quad i."""
    quads: list[list[Triple]] = []
    for node in element.findall("quad"):
        corners: list[Triple] = []
        for name in ("p0", "p1", "p2", "p3"):
            text = node.get(name, "")
            quad, colon, corner = text.partition(":")
            if colon:
                corners.append(quads[index(quad, len(quads), "quad")][index(corner, 4, "corner")])
            else:
                corners.append(triple(text, (0.0, 0.0, 0.0)))
        quads.append(corners)
    return np.array(quads).reshape(-1, 4, 3)


def _driveline(track: Path) -> tuple[Points, Points]:
    """Return the middle line ``(N, 3)`` and the half widths across it ``(N, 3)`` of the main loop, right-handed."""
    quads = read_quads(parse(track / "quads.xml"))
    graph = parse(track / "graph.xml") if (track / "graph.xml").is_file() else None
    loop = graph.find("edge-loop") if graph is not None else None
    if loop is not None:
        first, last = (
            index(loop.get(name, str(k)), len(quads), "quad") for name, k in (("from", 0), ("to", len(quads) - 1))
        )
        quads = quads[first : last + 1]
    if len(quads) < 2:
        raise UserError(
            f"The driveline of the track {track.name} has only {len(quads)} quads: use a track with at least 2."
        )
    # Each quad's starting edge, then the end of the last one.
    left = np.concatenate([quads[:, 0], quads[-1:, 3]]) @ MIRROR[:3, :3]
    right = np.concatenate([quads[:, 1], quads[-1:, 2]]) @ MIRROR[:3, :3]
    return (left + right) / 2.0, (right - left) / 2.0


def _cut(middle: Points, across: Points) -> list[Route]:
    arc = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(middle, axis=0), axis=1))))
    if not 0.0 < arc[-1] < _LONGEST:
        raise UserError(f"The driveline of the track is {arc[-1]:.3g} m long: reinstall the SuperTuxKart data.")
    count = max(_FEWEST, round(arc[-1] / (_LENGTH + _GAP)))
    piece = arc[-1] / count
    routes = []
    for k in range(count):
        length = piece - min(_GAP, 0.1 * piece)
        distance = k * piece + np.linspace(0.0, length, max(2, 1 + round(length / _STEP)))
        line = _sample(arc, middle, distance) + _ACROSS[k % len(_ACROSS)] * _sample(arc, across, distance)
        line[:, 1] += _EYES[k % len(_EYES)]
        routes.append(Route(f"driveline {k}", line.astype(np.float32)))
    return routes


def _sample(arc: Points, values: Points, distance: Points) -> Points:
    """Return ``values`` at arc lengths ``distance``, averaged over two metres so that cameras do not jolt."""
    near = np.clip(distance[:, None] + np.linspace(-1.0, 1.0, 5), 0.0, arc[-1])
    return np.stack([np.interp(near, arc, values[:, k]).mean(axis=1) for k in range(values.shape[1])], axis=1)


def _walks(navmesh: Element) -> list[Route]:
    """Return disjoint walks from face to face, each the longest shortest path among the remaining faces."""
    corners = np.array([[attribute(v, axis, 0.0) for axis in "xyz"] for v in navmesh.iter("vertex")]).reshape(-1, 3)
    mesh = list(navmesh.iter("face"))
    faces = [[index(i, len(corners), "vertex") for i in face.get("indices", "").split()] for face in mesh]
    links = [[index(i, len(mesh), "face") for i in face.get("adjacents", "").split()] for face in mesh]
    if not faces or not all(faces):
        raise UserError(
            "The track's navigation mesh has no faces, or some without vertices: "
            "use a track with a driveline or a navigation mesh."
        )
    middles = np.array([corners[face].mean(axis=0) for face in faces]) @ MIRROR[:3, :3]
    remaining = set(range(len(faces)))
    routes: list[Route] = []
    while len(routes) < 2 * _FEWEST and remaining:
        path = _longest(links, remaining)
        remaining -= set(path)
        if len(path) >= 3:
            routes.extend(_pieces(middles[path], len(routes)))
    if len(routes) < _FEWEST:
        # Too few faces for walks: use eight arcs around the middle, as wide as the mesh allows.
        return _ring(middles)
    return routes


def _pieces(line: Points, first: int) -> list[Route]:
    arc = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))))
    count = max(1, round(arc[-1] / (_LENGTH + _GAP)))
    piece = arc[-1] / count
    routes = []
    for k in range(count):
        length = piece - min(_GAP, 0.1 * piece)
        points = _sample(arc, line, k * piece + np.linspace(0.0, length, max(2, 1 + round(length / _STEP))))
        points[:, 1] += _EYES[(first + k) % len(_EYES)]
        routes.append(Route(f"walk {first + k}", points.astype(np.float32)))
    return routes


def _longest(links: list[list[int]], remaining: set[int]) -> list[int]:
    """Return a path between distant faces: breadth first twice, from the lowest face of the largest component."""
    seen: set[int] = set()
    best: dict[int, int] = {}
    for start in sorted(remaining):
        if start not in seen:
            reached = _breadth_first(links, remaining, start)
            seen |= reached.keys()
            best = reached if len(reached) > len(best) else best
    # Faces are in the order of their distance, so the last one is the farthest.
    before = _breadth_first(links, remaining, next(reversed(best)))
    path = [next(reversed(before))]
    while before[path[-1]] != path[-1]:
        path.append(before[path[-1]])
    return path


def _breadth_first(links: list[list[int]], remaining: set[int], start: int) -> dict[int, int]:
    """Return the predecessor of each reachable face; that of the start is itself."""
    before = {start: start}
    queue = deque([start])
    while queue:
        face = queue.popleft()
        for neighbour in links[face]:
            if neighbour in remaining and neighbour not in before:
                before[neighbour] = face
                queue.append(neighbour)
    return before


def _ring(middles: Points) -> list[Route]:
    centre = middles.mean(axis=0)
    reach = 0.6 * np.abs(middles - centre).max(axis=0)
    routes = []
    for k in range(_FEWEST):
        angle = 2.0 * np.pi * (k + np.linspace(0.0, 0.95, 40)) / _FEWEST
        around = np.stack([np.cos(angle) * reach[0], np.zeros_like(angle), np.sin(angle) * reach[2]], axis=1)
        points = centre + around
        points[:, 1] = middles[:, 1].max() + _EYES[k % len(_EYES)]
        routes.append(Route(f"ring {k}", points.astype(np.float32)))
    return routes
