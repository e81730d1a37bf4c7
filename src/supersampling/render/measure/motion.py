"""How true motion vectors and dual motion vectors are, measured on a scene."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, map_coordinates, maximum_filter, minimum_filter

from supersampling.render.camera import Matrix, Shot, Window
from supersampling.render.measure.probe import FRAME, Mask, Points, Probe, around, backwards, shifted, whole
from supersampling.render.renderer import Image

SAMPLES = 4  # supersampled resolution: the samples of a 1080p target, 4 x 4 a pixel
MARGIN = 2  # samples next to an edge that reprojection does not judge
SCALE = 4  # of the low-resolution frames whose dual motion is judged
THRESHOLD = 0.1  # low-resolution pixels (NSRD, 3.2)
_JUMP = 5e-5  # of the inverse depth: second difference at an edge; on a plane it is 0
_APART = 5e-3  # of the inverse depth: what is nearer than that hides


@dataclass(frozen=True)
class Reprojection:
    """Sum of absolute albedo differences and number of samples, of the standing world and of moving objects."""

    still: tuple[float, int]
    moving: tuple[float, int]


def edges(ids: NDArray, inverse: Matrix) -> Mask:
    """``(h, w)``: samples beside another object id, or at a jump or crease of the depth.

    Inverse depth is linear over the image on a plane, so its second difference is 0 but at edges.
    """
    found = np.zeros(ids.shape, dtype=bool)
    for before, after in shifted(ids):
        found |= (ids != before) | (ids != after)
    for before, after in shifted(inverse):
        found |= np.abs(before - 2.0 * inverse + after) > _JUMP * inverse
    return found


def _nearest(points: Points, size: tuple[int, int], margin: int) -> tuple[NDArray, NDArray, Mask]:
    """Row and column of the sample next to each point in a frame that is ``margin`` wider on each side; and whether inside."""
    width, height = size
    place = np.floor(points.uv * (width, height) + margin).clip(-1, 1 << 24).astype(np.intp)
    inside = ((place >= 0) & (place < (width + 2 * margin, height + 2 * margin))).all(axis=-1)
    inside &= points.inverse >= 0.0
    column, row = np.where(inside[..., None], place, 0).transpose(2, 0, 1)
    return row, column, inside


def _grown(window: Window, margin: int) -> Window:
    return replace(
        window, x=window.x - margin, y=window.y - margin,
        width=window.width + 2 * margin, height=window.height + 2 * margin,
    )  # fmt: skip


def reprojection(probe: Probe, shot: Shot) -> Reprojection:
    """Albedo now against albedo of the previous frame at ``uv + motion``, one sample a pixel of the shot's window.

    Compared are samples that were visible in the previous frame (the depth there is the point's own, the object id too) and
    that are more than `MARGIN` samples from an edge (see `edges`) in both frames. Textures are read at the mip level of the
    1080p target, as all its samples are; the previous frame is read by cubic splines in float64.
    """
    bias, window = float(np.log2(SAMPLES)), shot.window
    now = probe.samples(shot, bias, "albedo", "depth", "motion", "object_id")
    ids, inverse = now["object_id"][..., 0].astype(np.intp), probe.inverse_depth(now["depth"])
    size = (window.width, window.height)
    moved = now["motion"].astype(np.float64) * size
    reach = np.percentile(np.abs(moved), 99)
    margin = int(min(np.ceil(reach) + 2 * MARGIN, window.width))
    then = probe.samples(backwards(replace(shot, window=_grown(window, margin))), bias, "albedo", "depth", "object_id")
    seen, seen_ids = probe.inverse_depth(then["depth"]), then["object_id"][..., 0].astype(np.intp)
    points = probe.previous(shot, size, inverse, ids)
    row, column, inside = _nearest(points, size, margin)
    around_edges = np.ones((2 * MARGIN + 1, 2 * MARGIN + 1), dtype=bool)
    clear = ~binary_dilation(edges(ids, inverse), around_edges)
    clear_then = ~binary_dilation(edges(seen_ids, seen), around_edges)
    same = np.abs(seen[row, column] - points.inverse) < _APART * points.inverse
    judged = inside & clear & clear_then[row, column] & (seen_ids[row, column] == ids) & same & (ids > 0)
    y, x = np.nonzero(judged)
    source = np.stack((y + moved[y, x, 1] + margin, x + moved[y, x, 0] + margin))
    error = np.zeros(len(y))
    for channel in range(3):
        image = then["albedo"][..., channel].astype(np.float64)
        read = map_coordinates(image, source, order=3, mode="nearest")
        error += np.abs(read - now["albedo"][y, x, channel]) / 3.0
    moving = probe.moves[ids[y, x]]
    return Reprojection(
        (float(error[~moving].sum()), int((~moving).sum())), (float(error[moving].sum()), int(moving.sum()))
    )


def places(probe: Probe, shot: Shot, side: int) -> list[Shot]:
    """Two windows of a whole frame, ``side`` samples wide, at `SAMPLES`: its middle, and about most of what moves."""
    low = probe.renderer.low(replace(shot, window=whole(1)), 2 * SCALE, (0.0, 0.0), 0.0, frozenset({"object_id"}))
    moving = probe.moves[low["object_id"][..., 0].astype(np.intp)].astype(np.float64)
    chosen = [(0.5, 0.5)]
    if moving.any():
        block = max(side * moving.shape[1] // (FRAME[0] * SAMPLES), 1)
        summed = np.pad(moving.cumsum(0).cumsum(1), ((1, 0), (1, 0)))
        inner = summed[block:, block:] - summed[:-block, block:] - summed[block:, :-block] + summed[:-block, :-block]
        top, left = np.unravel_index(int(inner.argmax()), inner.shape)
        chosen.append(((left + block / 2) / moving.shape[1], (top + block / 2) / moving.shape[0]))
    return [replace(shot, window=around(x, y, side, SAMPLES)) for x, y in chosen]


@dataclass(frozen=True, eq=False)
class Disocclusion:
    """A low-resolution frame: the mask of its dual motion vectors, and what was hidden in truth, by object ids and by depth.

    ``mask`` is ``|motion_dual - motion| >= 0.1`` pixels on either axis (NSRD 3.2); ``inside`` are pixels whose point was in the
    previous frame's image. In truth a pixel was ``hidden`` where the previous frame, at 2 x 2 samples a target pixel, shows at
    the point's place something nearer than the point was; ``nearly`` hidden where it does so anywhere within half a
    low-resolution pixel of that place, as far as the nearest sample of a low-resolution frame may be, ``surely`` hidden where
    it does so everywhere within it.

    Object ids cannot tell what an object hides of itself. So ``judged`` by them leaves out what was hidden by its own object,
    in truth or (``mask`` pixels) in the previous low-resolution frame. ``other`` is what another object hid, ``nearly_other``
    likewise. ``beyond`` are pixels that no such mask can get right: those whose point was within a low-resolution pixel of
    alpha-tested surfaces, finer than one sample a pixel can show, and hidden ones that move by under 0.1 pixels against what
    hid them, so that the two vectors do not differ by the threshold.
    """

    mask: Mask
    inside: Mask
    hidden: Mask
    nearly: Mask
    surely: Mask
    other: Mask
    nearly_other: Mask
    judged: Mask
    beyond: Mask


def disocclusion(probe: Probe, shot: Shot) -> Disocclusion:
    """Mask and truth of a whole frame."""
    names = frozenset({"motion", "motion_dual", "depth", "object_id"})
    low = probe.renderer.low(shot, SCALE, (0.0, 0.0), 0.0, names)
    ids = low["object_id"][..., 0].astype(np.intp)
    size = (ids.shape[1], ids.shape[0])
    mask = _apart(low, size)
    points = probe.previous(shot, size, probe.inverse_depth(low["depth"]), ids)
    before = backwards(shot)
    ahead = Shot(shot.previous_camera, shot.camera, shot.previous_seconds, shot.seconds, whole(2))
    then = probe.samples(ahead, 0.0, "depth", "motion", "object_id")
    seen, seen_ids = probe.inverse_depth(then["depth"]), then["object_id"][..., 0].astype(np.intp)
    row, column, inside = _nearest(points, (seen.shape[1], seen.shape[0]), 0)
    slope, apart = _slope(seen)[row, column], _APART * points.inverse
    hidden = inside & (seen[row, column] - points.inverse > apart + slope)
    block = seen.shape[0] // size[1]
    most = maximum_filter(seen.astype(np.float32), block + 1)[row, column]
    least = minimum_filter(seen.astype(np.float32), block + 1)[row, column]
    # `slope` is the change within half a sample; the block's corner is half a block away on both axes.
    nearly = hidden | (inside & (most - points.inverse > apart + (block + 1) * slope))
    surely = hidden & (least - points.inverse > apart)
    other = probe.owner[seen_ids[row, column]] != probe.owner[ids]
    seen_low = probe.renderer.low(before, SCALE, (0.0, 0.0), 0.0, frozenset({"object_id"}))["object_id"]
    claimed = probe.owner[seen_low[row // block, column // block, 0].astype(np.intp)] != probe.owner[ids]
    fine = probe.tested[seen_ids].reshape(size[1], block, size[0], block).any(axis=(1, 3))
    sieve = binary_dilation(fine, np.ones((3, 3), dtype=bool))[row // block, column // block]
    judged = inside & ~(hidden & ~other) & ~(mask & ~claimed & ~(hidden & other))
    return Disocclusion(mask, inside, hidden, nearly, surely, hidden & other, nearly & (other | claimed), judged, sieve)


def _apart(low: dict[str, Image], size: tuple[int, int]) -> Mask:
    difference = np.abs(low["motion_dual"].astype(np.float64) - low["motion"]) * size
    return np.asarray((difference >= THRESHOLD).any(axis=-1), bool)


def _slope(values: Matrix) -> Matrix:
    """Change of ``values (h, w)`` within half a sample on its own surface: of two neighbours the nearer one counts."""
    steps = [np.minimum(np.abs(values - a), np.abs(values - b)) for a, b in shifted(values)]
    return np.asarray((steps[0] + steps[1]) / 2.0, np.float64)


def agreement(mask: Mask, truth: Mask, judged: Mask) -> NDArray[np.int64]:
    """Counts ``(4,)`` among the ``judged``: right and all of the mask, found and all of the truth."""
    mask, truth = mask & judged, truth & judged
    both = (mask & truth).sum()
    return np.array([both, mask.sum(), both, truth.sum()])


def near_agreement(mask: Mask, truth: Mask, nearly: Mask, surely: Mask, judged: Mask) -> NDArray[np.int64]:
    """The same with the tolerance of a low-resolution pixel: a mask pixel is right beside the truth or where ``nearly`` is; of
    the truth only what is ``surely`` so counts, and it is found beside the mask."""
    block = np.ones((3, 3), dtype=bool)
    right = mask & judged & (nearly | binary_dilation(truth, block))
    sought = truth & surely & judged
    found = sought & binary_dilation(mask, block)
    return np.array([right.sum(), (mask & judged).sum(), found.sum(), sought.sum()])
