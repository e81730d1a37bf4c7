"""Camera routes within a place: straight walks and turns about its middle that keep clear of its surface and out of solids."""

from collections.abc import Iterator
from itertools import zip_longest

import numpy as np
from numpy.typing import NDArray

from supersampling.scenes.gltf.survey import Survey
from supersampling.scenes.scene import Route

Points = NDArray[np.float64]
_POINTS = 25  # of a candidate
_FEWEST = 6  # of them in a row that are free make a route
_MARGIN = 0.02  # of the radius: room that a camera needs
BEHIND = 0.3  # of the directions: where more of them show back faces, one is in a solid or behind the scenes
_EYE = 1.6  # metres


def walks(found: Survey, most: int) -> list[Route]:
    """Up to ``most`` routes, from each height of the eye by turns the roomiest first; none where there is no room."""
    size = found.hi - found.lo
    levels = [found.lo[1] + min(h, 0.9 * size[1]) for h in (_EYE, 0.3 * size[1], 0.55 * size[1])]
    kinds = [_roomiest(found, lines) for y in levels for lines in (_straight(found, y), _turning(found, y))]
    kept: list[Points] = []
    for line in (line for turn in zip_longest(*kinds) for line in turn if line is not None):
        # Far enough from the others: no two splits see the same.
        apart = 3.0 * _MARGIN * found.radius
        if all(np.linalg.norm(line.mean(axis=0) - other.mean(axis=0)) > apart for other in kept):
            kept.append(line)
    return [_route(found, k, line if k % 2 else line[::-1]) for k, line in enumerate(kept[:most])]


def _straight(found: Survey, y: float) -> Iterator[Points]:
    """Lines ``(P, 3)`` along both horizontal axes, at several places across."""
    size = found.hi - found.lo
    for axis in (0, 2):
        for part in (0.5, 0.3, 0.7, 0.4, 0.6, 0.15, 0.85):
            points = np.full((_POINTS, 3), y)
            points[:, axis] = found.lo[axis] + np.linspace(0.1, 0.9, _POINTS) * size[axis]
            points[:, 2 - axis] = found.lo[2 - axis] + part * size[2 - axis]
            yield points


def _turning(found: Survey, y: float) -> Iterator[Points]:
    """Arcs of a hundred degrees, as wide as the place is."""
    half = 0.5 * (found.hi - found.lo)
    for part in (0.45, 0.7):
        for quarter in range(4):
            angle = 0.5 * np.pi * (quarter + part) + np.linspace(0.0, 1.75, _POINTS)
            x, z = part * half[0] * np.sin(angle), part * half[2] * np.cos(angle)
            yield np.stack([found.centre[0] + x, np.full(_POINTS, y), found.centre[2] + z], axis=1)


def _roomiest(found: Survey, candidates: Iterator[Points]) -> list[Points]:
    """The longest free stretch of each candidate, those first that are long and have two metres of room."""
    # Between two samples a wall is not noticed; in a place full of leaves, though, no walk would be free of them.
    needed = max(_MARGIN * found.radius, min(found.spacing, 2.5 * _MARGIN * found.radius))
    found_free = []
    for points in candidates:
        room = found.clearance(points)
        first, last = _longest((room > needed) & (found.backs_seen(points) < BEHIND))
        if last - first >= _FEWEST:
            line = points[first:last]
            length = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
            found_free.append((length * min(float(room[first:last].min()), 2.0), line))
    return [line for _, line in sorted(found_free, key=lambda one: -one[0])]


def _longest(free: NDArray[np.bool_]) -> tuple[int, int]:
    """First and last + 1 of the longest run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], free.astype(int), [0]))))
    runs = [(int(first), int(last)) for first, last in zip(edges[::2], edges[1::2])]
    return max(runs, key=lambda run: run[1] - run[0], default=(0, 0))


def _route(found: Survey, k: int, line: Points) -> Route:
    """Looking ahead where it is straight, and towards the middle, at the eye's height, where it turns."""
    points = line.astype(np.float32)
    middle = np.linalg.norm(line[len(line) // 2] - 0.5 * (line[0] + line[-1]))
    if middle < 1e-6 * found.radius:
        return Route(f"walk {k}", points)
    centre = np.array((found.centre[0], line[0, 1], found.centre[2]))
    reach = 0.1 * (found.hi - found.lo) * (1.0, 0.0, 1.0)
    return Route(f"turn {k}", points, np.stack([centre - reach, centre + reach]).astype(np.float32))
