"""Camera routes inside a scene: straight walks and turns around its centre, clear of surfaces and solids."""

from collections.abc import Iterator
from itertools import zip_longest

import numpy as np
from numpy.typing import NDArray

from supersampling.scenes.gltf.survey import Survey
from supersampling.scenes.scene import Route

Points = NDArray[np.float64]
_POINTS = 25  # per candidate
_FEWEST = 6  # free points in a row that make a route
_MARGIN = 0.02  # clearance that a camera needs, as part of the radius
BEHIND = 0.3  # share of directions that show back faces; a point with more is in a solid or behind a wall
_EYE = 1.6  # metres above the ground


def walks(geometry: Survey, most: int) -> list[Route]:
    """Return up to ``most`` routes, alternating between eye heights, those with most room first."""
    size = geometry.hi - geometry.lo
    levels = [geometry.lo[1] + min(h, 0.9 * size[1]) for h in (_EYE, 0.3 * size[1], 0.55 * size[1])]
    kinds = [_free_lines(geometry, lines) for y in levels for lines in (_straight(geometry, y), _turning(geometry, y))]
    selected: list[Points] = []
    for line in (line for turn in zip_longest(*kinds) for line in turn if line is not None):
        # Keep a distance between routes, so that no two splits see the same.
        apart = 3.0 * _MARGIN * geometry.radius
        if all(np.linalg.norm(line.mean(axis=0) - previous.mean(axis=0)) > apart for previous in selected):
            selected.append(line)
    return [_route(geometry, k, line if k % 2 else line[::-1]) for k, line in enumerate(selected[:most])]


def _straight(geometry: Survey, y: float) -> Iterator[Points]:
    """Yield lines ``(P, 3)`` along both horizontal axes, at several positions across."""
    size = geometry.hi - geometry.lo
    for axis in (0, 2):
        for part in (0.5, 0.3, 0.7, 0.4, 0.6, 0.15, 0.85):
            points = np.full((_POINTS, 3), y)
            points[:, axis] = geometry.lo[axis] + np.linspace(0.1, 0.9, _POINTS) * size[axis]
            points[:, 2 - axis] = geometry.lo[2 - axis] + part * size[2 - axis]
            yield points


def _turning(geometry: Survey, y: float) -> Iterator[Points]:
    """Yield arcs of a hundred degrees, as wide as the scene."""
    half = 0.5 * (geometry.hi - geometry.lo)
    for part in (0.45, 0.7):
        for quarter in range(4):
            angle = 0.5 * np.pi * (quarter + part) + np.linspace(0.0, 1.75, _POINTS)
            x, z = part * half[0] * np.sin(angle), part * half[2] * np.cos(angle)
            yield np.stack([geometry.centre[0] + x, np.full(_POINTS, y), geometry.centre[2] + z], axis=1)


def _free_lines(geometry: Survey, candidates: Iterator[Points]) -> list[Points]:
    """Return the longest free stretch of each candidate, first those that are long and have two metres of room."""
    # Walls between samples go unnoticed below the spacing; a larger limit would leave no walk free among leaves.
    clearance = max(_MARGIN * geometry.radius, min(geometry.spacing, 2.5 * _MARGIN * geometry.radius))
    stretches = []
    for points in candidates:
        room = geometry.clearance(points)
        first, last = _longest((room > clearance) & (geometry.backs_seen(points) < BEHIND))
        if last - first >= _FEWEST:
            line = points[first:last]
            length = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
            stretches.append((length * min(float(room[first:last].min()), 2.0), line))
    return [line for _, line in sorted(stretches, key=lambda stretch: -stretch[0])]


def _longest(free: NDArray[np.bool_]) -> tuple[int, int]:
    """Return the first and last + 1 index of the longest run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], free.astype(int), [0]))))
    runs = [(int(first), int(last)) for first, last in zip(edges[::2], edges[1::2])]
    return max(runs, key=lambda run: run[1] - run[0], default=(0, 0))


def _route(geometry: Survey, k: int, line: Points) -> Route:
    """Return the route: looking ahead on a straight line; towards the centre, at the eye's height, on a turn."""
    points = line.astype(np.float32)
    middle = np.linalg.norm(line[len(line) // 2] - 0.5 * (line[0] + line[-1]))
    if middle < 1e-6 * geometry.radius:
        return Route(f"walk {k}", points)
    centre = np.array((geometry.centre[0], line[0, 1], geometry.centre[2]))
    reach = 0.1 * (geometry.hi - geometry.lo) * (1.0, 0.0, 1.0)
    return Route(f"turn {k}", points, np.stack([centre - reach, centre + reach]).astype(np.float32))
