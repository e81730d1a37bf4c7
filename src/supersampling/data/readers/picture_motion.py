"""Motion that is seen in the pictures themselves: blocks that a shift explains far better than the recorded motion."""

from collections.abc import Sequence
from typing import NamedTuple

import torch
import torch.nn.functional as F
from torch import Tensor

from supersampling.data.readers.pairs import Pair
from supersampling.ops.resample import upsample_motion
from supersampling.ops.warp import outside, warp

REACH = 4  # pixels of a level in which a block is searched
BLOCK = 8  # pixels of a level per side of a block
SMALLEST = 32  # pixels per side of the coarsest level
EXPLAINED = 0.5  # a shift has to leave less than this share of a block's difference
VISIBLE = 0.01  # mean difference of a block, and mean detail, that count; 8 bits alone leave 0.002
NO_MOTION = 0.05  # target pixels; below, the recorded motion is none


class Unexplained(NamedTuple):
    """Pictures that move otherwise than recorded: as shares of the blocks that show detail."""

    share: float
    without_motion: float
    """Share of blocks that move although their recorded motion is 0."""
    pixels: float
    """Median length of the missing motion, in target pixels."""


def unexplained_motion(pair: Pair) -> Unexplained:
    """Return how much of the target of frame ``t`` a shift of frame ``t - 1``, warped by the motion, explains better.

    Only detail is compared, without its local mean, so that lights that change are not taken for motion; a block that
    shows something new resembles no shift either.
    """
    now = pair.tensor("target").mean(dim=1, keepdim=True)
    size = now.shape[-2:]
    motion = upsample_motion(pair.tensor("motion"), (size[0], size[1]))
    warped = warp(pair.tensor("target", before=True).mean(dim=1, keepdim=True), motion)
    length = (motion * motion.new_tensor((size[1], size[0])).view(1, 2, 1, 1)).norm(dim=1, keepdim=True)
    largest, factor = Unexplained(0.0, 0.0, 0.0), 1
    while min(size) >= (SMALLEST * factor if factor > 1 else BLOCK + 2 * REACH):
        planes = (warped, now, outside(motion).float(), (length < NO_MOTION).float())
        largest = max(largest, _level(*(F.avg_pool2d(plane, factor) for plane in planes), factor=factor))
        factor *= 2
    return largest


def _level(warped: Tensor, now: Tensor, left: Tensor, still: Tensor, *, factor: int) -> Unexplained:
    """Return the result on images that are smaller by ``factor``; ``left`` and ``still`` are shares of each pixel that
    come from outside the image and that have no motion."""
    before, now = (image - F.avg_pool2d(image, 7, 1, 3, count_include_pad=False) for image in (warped, now))
    height, width = now.shape[-2:]
    inner = slice(REACH, height - REACH), slice(REACH, width - REACH)
    centre = now[..., *inner]
    shifts = [(dx, dy) for dy in range(-REACH, REACH + 1) for dx in range(-REACH, REACH + 1)]
    errors = torch.stack(
        [
            F.avg_pool2d(
                (before[..., REACH + dy : height - REACH + dy, REACH + dx : width - REACH + dx] - centre).abs(), BLOCK
            )
            for dx, dy in shifts
        ]
    )
    without = errors[shifts.index((0, 0))]
    best = errors.min(dim=0)
    judged = (F.avg_pool2d(centre.abs(), BLOCK) > VISIBLE) & (F.max_pool2d(left[..., *inner], BLOCK) == 0.0)
    moves = judged & (without > VISIBLE) & (best.values < EXPLAINED * without)
    if not moves.any():
        return Unexplained(0.0, 0.0, 0.0)
    none = moves & (F.avg_pool2d(still[..., *inner], BLOCK) > 0.5)
    lengths = torch.tensor(shifts, dtype=torch.float32).norm(dim=1)[best.indices[moves]]
    count = max(int(judged.sum()), 1)
    return Unexplained(int(moves.sum()) / count, int(none.sum()) / count, float(lengths.median()) * factor)


def zero_axis(pairs: Sequence[Pair]) -> str | None:
    """Return ``x`` or ``y`` if this component of all motion is exactly 0 while the other is not."""
    moves = [any(bool(pair.read("motion")[..., axis].any()) for pair in pairs) for axis in (0, 1)]
    return {(False, True): "x", (True, False): "y"}.get((moves[0], moves[1]))
