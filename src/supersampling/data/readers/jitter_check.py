"""Does a capture's jitter say where each input pixel was sampled? The target, sampled there, has to resemble the inputs."""

from collections.abc import Sequence

import numpy as np
import torch

from supersampling.data.readers.conventions import Convention
from supersampling.data.readers.motion_check import best_convention
from supersampling.data.readers.pairs import Pair
from supersampling.errors import UserError
from supersampling.ops.interpolate import sample_bilinear
from supersampling.ops.warp import sampling_grid

CLEARLY = 0.97  # aliasing leaves a difference that the right jitter cannot remove
NONE = "none"


def mean_errors(pairs: Sequence[Pair], used: Convention) -> dict[str, float]:
    """Mean absolute difference between the inputs and the target sampled at their places, by convention, and for `NONE`."""
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


def check_jitter(where: str, pairs: Sequence[Pair], used: Convention, asked: bool) -> str:
    """One line about the outcome; ``asked`` says that the user chose the convention ``used``.

    Raises:
        UserError: another convention fits clearly better, or, unless the user asked for this one, no jitter at all does.
    """
    if not pairs:
        return f"{where}: clips of one frame, so the jitter (read as {used.name}) was not checked."
    errors = mean_errors(pairs, used)
    ours, best = errors[used.name], best_convention(errors, NONE)
    told = f"mean difference {ours:.4g} with jitter read as {used.name}, {errors[NONE]:.4g} without jitter"
    if errors[best] < CLEARLY * ours and errors[best] < errors[NONE]:
        raise UserError(
            f"{where}: the jitter does not fit: {told}, {errors[best]:.4g} read as {best}; import with jitter_convention={best}."
        )
    if errors[NONE] < CLEARLY * ours and not asked:
        raise UserError(
            f"{where}: the jitter does not fit: {told}; the inputs may be unjittered. Correct the capture, or import with "
            f"jitter_convention={used.name}."
        )
    return f"{where}: {told}."
