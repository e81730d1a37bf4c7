"""Accuracy of motion vectors and dual motion vectors on a scene."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, map_coordinates, maximum_filter, minimum_filter

from supersampling.render.camera import Matrix, Shot
from supersampling.render.measure.probe import FRAME, Mask, Points, Probe, around, backwards, shifted, whole
from supersampling.render.renderer import Image

SAMPLES = 4  # supersampled resolution: 4 x 4 samples per pixel of a 1080p target
MARGIN = 2  # samples next to an edge that are not compared after reprojection
SCALE = 4  # of the low-resolution frames whose dual motion is measured
THRESHOLD = 0.1  # low-resolution pixels (NSRD, 3.2)
_JUMP = 5e-5  # second difference over inverse depth at an edge; 0 on a plane
_APART = 5e-3  # difference over inverse depth from which a nearer surface hides a point


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


def _nearest(points: Points, size: tuple[int, int], margin: int) -> tuple[NDArray, NDArray, Mask]:
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
    row, column, inside = _nearest(points, size, margin)
    around_edges = np.ones((2 * MARGIN + 1, 2 * MARGIN + 1), dtype=bool)
    clear = ~binary_dilation(edges(ids, inverse), around_edges)
    clear_before = ~binary_dilation(edges(seen_ids, seen), around_edges)
    same = np.abs(seen[row, column] - points.inverse) < _APART * points.inverse
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


@dataclass(frozen=True, eq=False, kw_only=True)
class Disocclusion:
    """Disocclusion mask of a low-resolution frame's dual motion vectors, and true masks by object ids and by depth.

    ``mask`` is ``|motion_dual - motion| >= 0.1`` pixels on either axis (NSRD 3.2); ``inside`` are pixels whose point
    was in the previous frame's image. A pixel was truly ``hidden`` if the previous frame, at 2 x 2 samples per target
    pixel, shows a nearer surface at the point's position; ``nearly`` hidden if it does so anywhere within half a
    low-resolution pixel of that position, which is the largest distance to the nearest sample of a low-resolution
    frame; ``surely`` hidden if it does so everywhere within that distance.

    Object ids cannot show where an object hides itself. So ``judged`` leaves out pixels that were hidden by the same
    object, either truly or (pixels of ``mask``) in the previous low-resolution frame. ``by_object`` are pixels hidden
    by another object, ``nearly_by_object`` likewise. ``beyond`` are pixels that no such mask can get right: those whose
    point was within a low-resolution pixel of alpha-tested surfaces, which are finer than one sample per pixel can
    show, and hidden ones that move by under 0.1 pixels relative to what hid them, so that the two vectors do not differ
    by the threshold.
    """

    mask: Mask
    inside: Mask
    hidden: Mask
    nearly: Mask
    surely: Mask
    by_object: Mask
    nearly_by_object: Mask
    judged: Mask
    beyond: Mask


def disocclusion(probe: Probe, shot: Shot) -> Disocclusion:
    """Measure the masks of a whole frame."""
    names = frozenset({"motion", "motion_dual", "depth", "object_id"})
    low = probe.renderer.low(shot, SCALE, (0.0, 0.0), 0.0, names)
    ids = low["object_id"][..., 0].astype(np.intp)
    size = (ids.shape[1], ids.shape[0])
    mask = _apart(low, size)
    points = probe.previous(shot, size, probe.inverse_depth(low["depth"]), ids)
    before = backwards(shot)
    ahead = Shot(shot.previous_camera, shot.camera, shot.previous_seconds, shot.seconds, whole(2))
    previous = probe.samples(ahead, 0.0, "depth", "motion", "object_id")
    seen, seen_ids = probe.inverse_depth(previous["depth"]), previous["object_id"][..., 0].astype(np.intp)
    row, column, inside = _nearest(points, (seen.shape[1], seen.shape[0]), 0)
    slope, apart = _slope(seen)[row, column], _APART * points.inverse
    hidden = inside & (seen[row, column] - points.inverse > apart + slope)
    block = seen.shape[0] // size[1]
    most = maximum_filter(seen.astype(np.float32), block + 1)[row, column]
    least = minimum_filter(seen.astype(np.float32), block + 1)[row, column]
    # `slope` is the change within half a sample; the corner of the block is half a block away on both axes.
    nearly = hidden | (inside & (most - points.inverse > apart + (block + 1) * slope))
    surely = hidden & (least - points.inverse > apart)
    foreign = probe.owner[seen_ids[row, column]] != probe.owner[ids]
    seen_low = probe.renderer.low(before, SCALE, (0.0, 0.0), 0.0, frozenset({"object_id"}))["object_id"]
    claimed = probe.owner[seen_low[row // block, column // block, 0].astype(np.intp)] != probe.owner[ids]
    fine = probe.tested[seen_ids].reshape(size[1], block, size[0], block).any(axis=(1, 3))
    sieve = binary_dilation(fine, np.ones((3, 3), dtype=bool))[row // block, column // block]
    return Disocclusion(
        mask=mask,
        inside=inside,
        hidden=hidden,
        nearly=nearly,
        surely=surely,
        by_object=hidden & foreign,
        nearly_by_object=nearly & (foreign | claimed),
        judged=inside & ~(hidden & ~foreign) & ~(mask & ~claimed & ~(hidden & foreign)),
        beyond=sieve,
    )


def _apart(low: dict[str, Image], size: tuple[int, int]) -> Mask:
    difference = np.abs(low["motion_dual"].astype(np.float64) - low["motion"]) * size
    return np.asarray((difference >= THRESHOLD).any(axis=-1), bool)


def _slope(values: Matrix) -> Matrix:
    """Return the change of ``values (h, w)`` within half a sample on the same surface, from the nearer neighbour."""
    steps = [np.minimum(np.abs(values - a), np.abs(values - b)) for a, b in shifted(values)]
    return np.asarray((steps[0] + steps[1]) / 2.0, np.float64)


def agreement(mask: Mask, truth: Mask, judged: Mask) -> NDArray[np.int64]:
    """Return counts ``(4,)`` among the ``judged``: right and all pixels of the mask, found and all of the truth."""
    mask, truth = mask & judged, truth & judged
    correct = (mask & truth).sum()
    return np.array([correct, mask.sum(), correct, truth.sum()])


def near_agreement(mask: Mask, truth: Mask, nearly: Mask, surely: Mask, judged: Mask) -> NDArray[np.int64]:
    """Return the counts of `agreement` with a tolerance of one low-resolution pixel.

    A mask pixel is right if it is ``nearly`` true or beside the truth; only ``surely`` true pixels count as truth, and
    they are found if they are beside the mask.
    """
    block = np.ones((3, 3), dtype=bool)
    right = mask & judged & (nearly | binary_dilation(truth, block))
    sought = truth & surely & judged
    matched = sought & binary_dilation(mask, block)
    return np.array([right.sum(), (mask & judged).sum(), matched.sum(), sought.sum()])
