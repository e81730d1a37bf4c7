"""Alpha-tested leaves in front of a wall, and what a camera sees of them in closed form, without any texture lookup.

A leaf is a square cell of a random pattern, and covers whole texels. At the mip level of a low-resolution pixel several
cells fall into a texel, whose mean alpha is below the cutoff: there the leaves dissolve, as those of distant trees do.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from analytic_scenes import Points, eye, rays, scene, wall

from supersampling.render.camera import Camera, Window
from supersampling.scenes.scene import Material, Scene

CELLS = 128  # leaves and gaps per side of a layer
_TEXELS = 8  # per side of a cell
COVERAGE = 0.3  # share of cells that are leaves


@dataclass(frozen=True, eq=False)
class Layer:
    """Leaves ``(CELLS, CELLS)`` bool, top row first, on a square of ``half`` side at ``depth`` metres ahead."""

    depth: float
    half: float
    leaves: np.ndarray


def layer(depth: float, half: float, seed: int) -> Layer:
    return Layer(depth, half, np.random.default_rng(seed).random((CELLS, CELLS)) < COVERAGE)


def foliage(layers: Sequence[Layer], back: float) -> Scene:
    """Return the scene: object 1 is the wall at ``back`` metres, object 2 the first layer, and so on."""
    materials = [Material("wall")]
    meshes = [wall(-4 * back, 4 * back, -4 * back, 4 * back, -back)]
    for k, item in enumerate(layers, start=1):
        alpha = np.kron(item.leaves, np.ones((_TEXELS, _TEXELS))) * 255
        texture = np.dstack([np.full_like(alpha, 128)] * 3 + [alpha]).astype(np.uint8)
        materials.append(Material(f"leaves {k}", texture, alpha="test", double_sided=True))
        meshes.append(wall(-item.half, item.half, -item.half, item.half, -item.depth, k))
    return scene(materials, meshes)


def seen(layers: Sequence[Layer], back: float, view: Camera, window: Window, points: Points) -> tuple[Points, Points]:
    """Return object ids ``(h, w)`` and world points ``(h, w, 3)`` at frame pixel positions ``points (h, w, 2)``.

    ``layers`` are sorted, nearest first. The camera does not turn.
    """
    ray = rays(view, window, points)
    place = eye(view) + ray * (back + eye(view)[2])
    ids = np.ones(points.shape[:2], int)
    for k, item in reversed(list(enumerate(layers, start=2))):
        hit = eye(view) + ray * (item.depth + eye(view)[2])
        leaf = covered(item, hit)
        ids, place = np.where(leaf, k, ids), np.where(leaf[..., None], hit, place)
    return ids, place


def covered(item: Layer, place: Points) -> np.ndarray:
    """Return whether each point ``(h, w, 3)`` of the layer's plane is on a leaf."""
    column = np.floor((place[..., 0] / item.half + 1.0) / 2.0 * CELLS).astype(int)
    row = np.floor((1.0 - place[..., 1] / item.half) / 2.0 * CELLS).astype(int)
    inside = (column >= 0) & (column < CELLS) & (row >= 0) & (row < CELLS)
    return inside & item.leaves[np.where(inside, row, 0), np.where(inside, column, 0)]
