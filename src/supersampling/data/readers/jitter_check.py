"""Check of a capture's jitter: the target, sampled at the jittered positions, has to resemble the inputs."""

from collections.abc import Sequence

import numpy as np
import torch

from supersampling.data.readers.conventions import Convention
from supersampling.data.readers.motion_check import best_convention
from supersampling.data.readers.pairs import Pair
from supersampling.errors import UserError
from supersampling.ops.interpolate import sample_bilinear
from supersampling.ops.warp import sampling_grid

CLEARLY = 0.97  # aliasing leaves a difference that the correct jitter cannot remove
NONE = "none"


def mean_errors(pairs: Sequence[Pair], used: Convention) -> dict[str, float]:
    """Return the mean absolute difference of the inputs and the target at their positions, by convention and for
    `NONE`."""
    total = dict.fromkeys((NONE, *(c.name for c in used.variants())), 0.0)
    for pair in pairs:
        color, target = pair.tensor("color"), pair.tensor("target")
        height, width = color.shape[-2:]
        stored = used.encode(pair.clip.read(pair.t, frozenset({"jitter"}))["jitter"])
        offsets = {c.name: c.decode(stored) for c in used.variants()} | {NONE: np.zeros(2, np.float32)}
        for name, offset in offsets.items():
            shift = torch.from_numpy(offset / np.array((width, height), np.float32)).view(1, 2, 1, 1)
            sampled = sample_bilinear(target, sampling_grid(shift.expand(1, 2, height, width)))
            total[name] += float((sampled - color).abs().mean()) / len(pairs)
    return total


def check_jitter(label: str, pairs: Sequence[Pair], used: Convention, overridden: bool) -> str:
    """Return one line about the result; ``overridden`` means that the user set the convention ``used``.

    Raises:
        UserError: a different convention fits clearly better, or no jitter does and the user did not set the
        convention.
    """
    if not pairs:
        return f"{label}: clips of one frame, so the jitter (read as {used.name}) was not checked."
    errors = mean_errors(pairs, used)
    error, best = errors[used.name], best_convention(errors, NONE)
    result = f"mean difference {error:.4g} with jitter read as {used.name}, {errors[NONE]:.4g} without jitter"
    if errors[best] < CLEARLY * error and errors[best] < errors[NONE]:
        raise UserError(
            f"{label}: the jitter does not fit ({result}, {errors[best]:.4g} read as {best}): import with "
            f"jitter_convention={best}."
        )
    if errors[NONE] < CLEARLY * error and not overridden:
        raise UserError(
            f"{label}: the jitter does not fit ({result}; the inputs may be unjittered): correct the capture, or "
            "import with "
            f"jitter_convention={used.name}."
        )
    return f"{label}: {result}."
