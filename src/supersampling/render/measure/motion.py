"""Accuracy of motion vectors on a scene: the previous frame, warped by them, against the current one."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, map_coordinates

from supersampling.render.camera import Matrix, Shot
from supersampling.render.measure.probe import FRAME, Mask, Points, Probe, around, backwards, shifted, whole

SAMPLES = 4  # supersampled resolution: 4 x 4 samples per pixel of a 1080p target
MARGIN = 2  # samples next to an edge that are not compared after reprojection
SCALE = 4  # of low-resolution frames
_JUMP = 5e-5  # second difference over inverse depth at an edge; 0 on a plane
APART = 5e-3  # difference over inverse depth from which a nearer surface hides a point


@dataclass(frozen=True)
class Reprojection:
    """Sum of absolute albedo differences and number of samples, of the static world and of moving objects."""

    still: tuple[float, int]
    moving: tuple[float, int]


def edges(ids: NDArray, inverse: Matrix) -> Mask:
    """Return the mask ``(h, w)`` of samples beside another object id or at a jump or crease of the depth.

    The inverse depth of a plane is linear over the image, so its second difference is 0 except at edges.
    """
    mask = np.zeros(ids.shape, dtype=bool)
    for before, after in shifted(ids):
        mask |= (ids != before) | (ids != after)
    for before, after in shifted(inverse):
        mask |= np.abs(before - 2.0 * inverse + after) > _JUMP * inverse
    return mask


def nearest(points: Points, size: tuple[int, int], margin: int) -> tuple[NDArray, NDArray, Mask]:
    """Return the row and column of the sample at each point, and whether it is inside the frame.

    The frame is ``margin`` samples wider than ``size`` on each side.
    """
    width, height = size
    cell = np.floor(points.uv * (width, height) + margin).clip(-1, 1 << 24).astype(np.intp)
    inside = ((cell >= 0) & (cell < (width + 2 * margin, height + 2 * margin))).all(axis=-1)
    inside &= points.inverse >= 0.0
    column, row = np.where(inside[..., None], cell, 0).transpose(2, 0, 1)
    return row, column, inside


def reprojection(probe: Probe, shot: Shot) -> Reprojection:
    """Compare albedo with the previous frame's albedo at ``uv + motion``, one sample per pixel of the shot's window.

    Only samples are compared that were visible in the previous frame (its depth and object id there are the point's)
    and that are more than `MARGIN` samples from an edge (see `edges`) in both frames. Textures are read at the mip
    level of the 1080p target, as for all its samples; the previous frame is interpolated by cubic splines in float64.
    """
    bias, window = float(np.log2(SAMPLES)), shot.window
    now = probe.samples(shot, bias, "albedo", "depth", "motion", "object_id")
    ids, inverse = now["object_id"][..., 0].astype(np.intp), probe.inverse_depth(now["depth"])
    size = (window.width, window.height)
    moved = now["motion"].astype(np.float64) * size
    reach = np.percentile(np.abs(moved), 99)
    margin = int(min(np.ceil(reach) + 2 * MARGIN, window.width))
    earlier = backwards(replace(shot, window=window.grown(margin)))
    previous = probe.samples(earlier, bias, "albedo", "depth", "object_id")
    seen, seen_ids = probe.inverse_depth(previous["depth"]), previous["object_id"][..., 0].astype(np.intp)
    points = probe.previous(shot, size, inverse, ids)
    row, column, inside = nearest(points, size, margin)
    around_edges = np.ones((2 * MARGIN + 1, 2 * MARGIN + 1), dtype=bool)
    clear = ~binary_dilation(edges(ids, inverse), around_edges)
    clear_before = ~binary_dilation(edges(seen_ids, seen), around_edges)
    same = np.abs(seen[row, column] - points.inverse) < APART * points.inverse
    compared = inside & clear & clear_before[row, column] & (seen_ids[row, column] == ids) & same & (ids > 0)
    y, x = np.nonzero(compared)
    source = np.stack((y + moved[y, x, 1] + margin, x + moved[y, x, 0] + margin))
    error = np.zeros(len(y))
    for channel in range(3):
        image = previous["albedo"][..., channel].astype(np.float64)
        read = map_coordinates(image, source, order=3, mode="nearest")
        error += np.abs(read - now["albedo"][y, x, channel]) / 3.0
    moving = probe.moves[ids[y, x]]
    return Reprojection(
        (float(error[~moving].sum()), int((~moving).sum())), (float(error[moving].sum()), int(moving.sum()))
    )


def places(probe: Probe, shot: Shot, side: int) -> list[Shot]:
    """Return shots of up to two windows of a whole frame: its middle, and around most moving objects.

    Windows are ``side`` samples wide, at `SAMPLES` samples per pixel side.
    """
    low = probe.renderer.low(replace(shot, window=whole(1)), 2 * SCALE, (0.0, 0.0), 0.0, frozenset({"object_id"}))
    moving = probe.moves[low["object_id"][..., 0].astype(np.intp)].astype(np.float64)
    centres = [(0.5, 0.5)]
    if moving.any():
        block = max(side * moving.shape[1] // (FRAME[0] * SAMPLES), 1)
        summed = np.pad(moving.cumsum(0).cumsum(1), ((1, 0), (1, 0)))
        inner = summed[block:, block:] - summed[:-block, block:] - summed[block:, :-block] + summed[:-block, :-block]
        top, left = np.unravel_index(int(inner.argmax()), inner.shape)
        centres.append(((left + block / 2) / moving.shape[1], (top + block / 2) / moving.shape[0]))
    return [replace(shot, window=around(x, y, side, SAMPLES)) for x, y in centres]
