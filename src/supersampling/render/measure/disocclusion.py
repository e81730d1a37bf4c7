"""Accuracy of the mask of dual motion vectors on a scene, and the causes of what it misses."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, maximum_filter, minimum_filter

from supersampling.ops.motion_mask import THRESHOLD
from supersampling.render.camera import Matrix, Shot
from supersampling.render.jitter import mip_bias
from supersampling.render.measure.motion import APART, SCALE, nearest
from supersampling.render.measure.probe import Ids, Mask, Points, Probe, shifted, whole
from supersampling.render.renderer import Image

DETAIL = 2  # the truth has DETAIL x DETAIL samples per target pixel
MIP_BIAS = mip_bias("matched", SCALE)  # of the low-resolution frames: the default of data sets
_STILL = 0.01  # low-resolution pixels; a tenth of the threshold
_BLOCK = np.ones((3, 3), dtype=bool)  # a pixel and its neighbours

CAUSES = {
    "marked": "in the mask",
    "beside": "beside the mask, within a low-resolution pixel",
    "together": "moves with what hid it, by under 0.01 pixels: the alpha test differs between the frames",
    "parallel": "moves by under 0.1 low-resolution pixels relative to what hid it",
    "depth": "what hid it is not nearer by more than the tolerance of dual motion",
    "sample": "the previous low-resolution frame has no sample on what hid it there",
}


@dataclass(frozen=True, eq=False, kw_only=True)
class Disocclusion:
    """Disocclusion mask of a low-resolution frame's dual motion vectors, and true masks by object ids and by depth.

    ``mask`` is ``|motion_dual - motion| >= 0.1`` pixels on either axis (NSRD 3.2); ``inside`` are pixels whose point
    was in the previous frame's image. A pixel was truly ``hidden`` if the previous frame, drawn with `DETAIL` x
    `DETAIL` samples per target pixel, shows a nearer surface at its point's position, and not all four samples around
    the pixel's centre in the current frame, drawn likewise, do. ``nearly`` hidden pixels are hidden anywhere within
    half a low-resolution pixel of that position, which is the largest distance to the nearest sample of a
    low-resolution frame; ``surely`` hidden ones everywhere within it.

    ``certain`` are the hidden pixels for which all four samples around the position show nearer surfaces: the others
    are closer to an edge than the truth can tell. ``veiled`` pixels would be certain if they were visible now.
    ``cause`` is 1 + the index in `CAUSES` at certain pixels, else 0.

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
    certain: Mask
    veiled: Mask
    nearly: Mask
    surely: Mask
    by_object: Mask
    nearly_by_object: Mask
    judged: Mask
    beyond: Mask
    cause: NDArray[np.uint8]


def disocclusion(probe: Probe, shot: Shot, bias: float = MIP_BIAS, finer: float = 0.0) -> Disocclusion:
    """Measure the masks of a whole frame.

    Alpha-tested surfaces change with the texture level, so frames that are compared must share it: the truth is drawn
    at the level of the low-resolution frames, whose mip bias is ``bias``, or ``finer`` levels below.
    """
    low = probe.renderer.low(shot, SCALE, (0.0, 0.0), bias, frozenset({"motion", "motion_dual", "depth", "object_id"}))
    ids, inverse = _ids(low), probe.inverse_depth(low["depth"])
    size = (ids.shape[1], ids.shape[0])
    mask = _moved((low["motion_dual"].astype(np.float64) - low["motion"]) * size)
    points = probe.previous(shot, size, inverse, ids)
    level = bias + float(np.log2(SCALE * DETAIL)) - finer
    ahead = Shot(shot.previous_camera, shot.camera, shot.previous_seconds, shot.seconds, whole(DETAIL))
    previous = probe.samples(ahead, level, "depth", "motion", "object_id")
    seen, seen_ids = probe.inverse_depth(previous["depth"]), _ids(previous)
    row, column, inside = nearest(points, (seen.shape[1], seen.shape[0]), 0)
    slope, apart = _slope(seen)[row, column], APART * points.inverse
    before = inside & (seen[row, column] - points.inverse > apart + slope)
    visible = _visible(probe, shot, inverse, level)
    hidden = before & visible
    # Samples around a position are up to one sample away on each axis, and `slope` is the change within half of one.
    amid = before & (_around(seen, points.uv).min(axis=0) - points.inverse > apart + 2.0 * slope)
    block = seen.shape[0] // size[1]
    most = maximum_filter(seen.astype(np.float32), block + 1)[row, column]
    least = minimum_filter(seen.astype(np.float32), block + 1)[row, column]
    # The corner of the block is half a block away on both axes.
    nearly = hidden | (inside & (most - points.inverse > apart + (block + 1) * slope))
    foreign = probe.owner[seen_ids[row, column]] != probe.owner[ids]
    relative = points.uv * size + previous["motion"][row, column].astype(np.float64) * size - _centres(size)
    parallel = hidden & ~_moved(relative)
    sampled = _sampled(probe, ahead, bias, points, size)
    claimed = probe.owner[sampled.ids] != probe.owner[ids]
    shown = (sampled.inverse - points.inverse > apart) & _moved(points.uv * size + sampled.motion - _centres(size))
    beside = binary_dilation(mask, _BLOCK)
    fine = probe.tested[seen_ids].reshape(size[1], block, size[0], block).any(axis=(1, 3))
    sieve = binary_dilation(fine, _BLOCK)[row // block, column // block]
    return Disocclusion(
        mask=mask,
        inside=inside,
        hidden=hidden,
        certain=amid & visible,
        veiled=amid & ~visible,
        nearly=nearly,
        surely=hidden & (least - points.inverse > apart),
        by_object=hidden & foreign,
        nearly_by_object=nearly & (foreign | claimed),
        judged=inside & ~(hidden & ~foreign) & ~(mask & ~claimed & ~(hidden & foreign)),
        beyond=sieve | parallel,
        cause=_causes(amid & visible, (mask, beside, ~_moved(relative, _STILL), parallel, shown)),
    )


def _ids(frame: dict[str, Image]) -> Ids:
    return frame["object_id"][..., 0].astype(np.intp)


def _moved(difference: Matrix, threshold: float = THRESHOLD) -> Mask:
    """Return whether differences ``(h, w, 2)`` of motions, low-resolution pixels, reach the threshold on an axis."""
    return np.asarray((np.abs(difference) >= threshold).any(axis=-1), bool)


def _centres(size: tuple[int, int]) -> Matrix:
    """Return the positions ``(h, w, 2)`` of the centres of all pixels, in pixels."""
    y, x = np.mgrid[0 : size[1], 0 : size[0]] + 0.5
    return np.stack((x, y), axis=-1)


def _around(values: Matrix, uv: Matrix) -> Matrix:
    """Return the values ``(4, h, w)`` of the four samples around positions ``uv (h, w, 2)``, in units of the image."""
    height, width = values.shape
    first = np.floor((uv * (width, height) - 0.5).clip(-1, 1 << 24)).astype(np.intp)
    corners = [(first + step).clip(0, (width - 1, height - 1)) for step in ((0, 0), (1, 0), (0, 1), (1, 1))]
    return np.stack([values[corner[..., 1], corner[..., 0]] for corner in corners])


def _visible(probe: Probe, shot: Shot, inverse: Matrix, level: float) -> Mask:
    """Return whether not all of the truth's samples around each pixel's centre show a nearer surface than the pixel.

    ``inverse (h, w)`` is the inverse depth of the pixels.
    """
    now = Shot(shot.camera, shot.camera, shot.seconds, shot.seconds, whole(DETAIL))
    seen = probe.inverse_depth(probe.samples(now, level, "depth")["depth"])
    size = (inverse.shape[1], inverse.shape[0])
    uv = _centres(size) / size
    slope = _around(_slope(seen), uv).min(axis=0)
    return np.asarray(_around(seen, uv).min(axis=0) - inverse <= APART * inverse + 2.0 * slope, bool)


@dataclass(frozen=True, eq=False)
class _Sampled:
    """Surface of the previous low-resolution frame in the pixel that contains each point's previous position.

    ``motion (h, w, 2)`` is its motion to the current frame in pixels.
    """

    ids: Ids
    inverse: Matrix
    motion: Matrix


def _sampled(probe: Probe, ahead: Shot, bias: float, points: Points, size: tuple[int, int]) -> _Sampled:
    shot = Shot(ahead.camera, ahead.previous_camera, ahead.seconds, ahead.previous_seconds, whole(1))
    low = probe.renderer.low(shot, SCALE, (0.0, 0.0), bias, frozenset({"depth", "motion", "object_id"}))
    row, column, _ = nearest(points, size, 0)
    motion = low["motion"][row, column].astype(np.float64) * size
    return _Sampled(_ids(low)[row, column], probe.inverse_depth(low["depth"])[row, column], motion)


def _causes(certain: Mask, tests: Sequence[Mask]) -> NDArray[np.uint8]:
    """Return 1 + the index of the first of `CAUSES` that holds for each certain pixel; the last one needs no test."""
    cause = np.full(certain.shape, len(CAUSES), np.uint8)
    for k in reversed(range(len(tests))):
        cause[tests[k]] = k + 1
    cause[~certain] = 0
    return cause


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
    right = mask & judged & (nearly | binary_dilation(truth, _BLOCK))
    sought = truth & surely & judged
    matched = sought & binary_dilation(mask, _BLOCK)
    return np.array([right.sum(), (mask & judged).sum(), matched.sum(), sought.sum()])
