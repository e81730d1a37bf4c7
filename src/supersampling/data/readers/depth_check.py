"""Check of the direction of a capture's depth: surfaces that come into view were hidden by something nearer."""

from collections.abc import Sequence

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from supersampling.data.readers.motion_check import ENOUGH
from supersampling.data.readers.pairs import Pair
from supersampling.errors import UserError
from supersampling.ops.warp import outside, sampling_grid

NEAR_PLANE = 0.001  # largest share of pixels exactly on the near plane, where no surface should be
JUMP = 0.1  # in ranks of the frame's depths: a step from one surface to another
REMEDY = "import with reversed_depth=true, or with false if the depth is correct"
EVIDENCE = 40  # pixels that appear or vanish; fewer prove nothing
ONE_SIDED = 4.0  # ratio of the pixels that support one direction to those that support the other


def ranks(values: Tensor, sorted_values: Tensor) -> Tensor:
    """Return the rank of each value among ``sorted_values``, 0 to 1, which does not depend on the depth buffer's
    curve."""
    return torch.searchsorted(sorted_values, values.contiguous()).float() / len(sorted_values)


def uncovered(pairs: Sequence[Pair]) -> tuple[int, int]:
    """Return the numbers of pixels whose previous position held something much nearer, and much farther.

    The first are surfaces that came into view, the second cannot occur. At edges and in thin geometry, samples jump
    between surfaces without motion, so that all of 3x3 pixels have to differ from all of the 3x3 previous pixels.
    """
    nearer = farther = 0
    for pair in pairs:
        before, now, motion = pair.tensor("depth", before=True), pair.tensor("depth"), pair.tensor("motion")
        order = now.flatten().sort().values
        lowest, highest = _range3(ranks(now, order))
        previous_lowest, previous_highest = (_nearest(edge, motion) for edge in _range3(ranks(before, order)))
        inside = ~outside(motion)
        nearer += int(((previous_highest < lowest - JUMP) & inside).sum())
        farther += int(((previous_lowest > highest + JUMP) & inside).sum())
    return nearer, farther


def _range3(values: Tensor) -> tuple[Tensor, Tensor]:
    """Return the minimum and the maximum of the 3x3 pixels around each pixel."""
    return -F.max_pool2d(-values, 3, 1, 1), F.max_pool2d(values, 3, 1, 1)


def _nearest(image: Tensor, motion: Tensor) -> Tensor:
    return F.grid_sample(image, sampling_grid(motion), mode="nearest", padding_mode="border", align_corners=False)


def check_depth(label: str, pairs: Sequence[Pair], overridden: bool) -> str:
    """Return one line about the result; ``overridden`` means that the user set the direction of depth.

    Two signs indicate reversed depth: many pixels exactly on the near plane, where reversed depth puts the sky; and
    surfaces that come into view from behind farther ones. Captures without sky and without parallax have neither.

    Raises:
        UserError: depth decreases with distance, and the user did not set this direction.
    """
    on_plane = float(np.mean([(pair.read("depth") == 0.0).mean() for pair in pairs])) if pairs else 0.0
    nearer, farther = uncovered([pair for pair in pairs if pair.moving >= ENOUGH])
    enough = max(nearer, farther) >= EVIDENCE
    counts = f"{nearer} pixels came into view from behind something nearer, {farther} from behind something farther"
    if not overridden and enough and farther > ONE_SIDED * nearer:
        raise UserError(f"{label}: {counts}, so the depth seems to be reversed (1 near, 0 far): {REMEDY}.")
    if not overridden and on_plane > NEAR_PLANE and not (enough and nearer > ONE_SIDED * farther):
        raise UserError(
            f"{label}: {on_plane:.1%} of the pixels lie exactly on the near plane, so the depth seems to be reversed "
            "(1 near, 0 "
            f"far): {REMEDY}."
        )
    return f"{label}: {counts if enough else 'too few pixels come into view to check the direction of depth'}."
