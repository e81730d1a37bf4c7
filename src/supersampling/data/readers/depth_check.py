"""Is a capture's depth the right way round? What comes into view was hidden by something nearer."""

from collections.abc import Sequence

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from supersampling.data.readers.motion_check import ENOUGH
from supersampling.data.readers.pairs import Pair
from supersampling.errors import UserError
from supersampling.ops.warp import outside, sampling_grid

NEAR_PLANE = 0.001  # share of pixels that may lie exactly on the near plane; nothing should
JUMP = 0.1  # in ranks of the frame's depths: a step from one surface to another
REMEDY = "import with reversed_depth=true, or false if it is right as it is"
EVIDENCE = 40  # pixels that appear or vanish; fewer prove nothing
ONE_SIDED = 4.0  # how many times as many have to speak for one direction as for the other


def ranks(values: Tensor, sorted_values: Tensor) -> Tensor:
    """Where each value stands among ``sorted_values``, 0 to 1: an order that no curve of the depth buffer changes."""
    return torch.searchsorted(sorted_values, values.contiguous()).float() / len(sorted_values)


def uncovered(pairs: Sequence[Pair]) -> tuple[int, int]:
    """How many pixels' previous position held something much nearer, and much farther.

    The first are surfaces that came into view, the second cannot be. At edges and in thin geometry the samples jump from one
    surface to another by themselves, so that all of 3x3 pixels has to differ from all of 3x3 previous ones.
    """
    nearer = farther = 0
    for pair in pairs:
        before, now, motion = pair.tensor("depth", before=True), pair.tensor("depth"), pair.tensor("motion")
        order = now.flatten().sort().values
        least, most = _range3(ranks(now, order))
        was_least, was_most = (_nearest(edge, motion) for edge in _range3(ranks(before, order)))
        inside = ~outside(motion)
        nearer += int(((was_most < least - JUMP) & inside).sum())
        farther += int(((was_least > most + JUMP) & inside).sum())
    return nearer, farther


def _range3(values: Tensor) -> tuple[Tensor, Tensor]:
    """The least and the largest of each pixel's 3x3."""
    return -F.max_pool2d(-values, 3, 1, 1), F.max_pool2d(values, 3, 1, 1)


def _nearest(image: Tensor, motion: Tensor) -> Tensor:
    return F.grid_sample(image, sampling_grid(motion), mode="nearest", padding_mode="border", align_corners=False)


def check_depth(where: str, pairs: Sequence[Pair], asked: bool) -> str:
    """One line about the outcome; ``asked`` says that the user told the depth's direction.

    Two signs tell reversed depth: many pixels exactly on the near plane, which is where reversed depth puts the sky; and
    surfaces that come into view from behind farther ones. Captures without sky and without anything moving apart show neither.

    Raises:
        UserError: depth runs from far to near, unless the user asked for this direction.
    """
    on_plane = float(np.mean([(pair.read("depth") == 0.0).mean() for pair in pairs])) if pairs else 0.0
    nearer, farther = uncovered([pair for pair in pairs if pair.moving >= ENOUGH])
    enough = max(nearer, farther) >= EVIDENCE
    told = f"{nearer} pixels came into view from behind something nearer, {farther} from behind something farther"
    if not asked and enough and farther > ONE_SIDED * nearer:
        raise UserError(f"{where}: {told}, so the depth seems to be reversed (1 near, 0 far): {REMEDY}.")
    if not asked and on_plane > NEAR_PLANE and not (enough and nearer > ONE_SIDED * farther):
        raise UserError(
            f"{where}: {on_plane:.1%} of the pixels lie exactly on the near plane, so the depth seems to be reversed (1 near, 0 "
            f"far): {REMEDY}."
        )
    return f"{where}: {told}." if enough else f"{where}: too little comes into view to check the depth's direction."
