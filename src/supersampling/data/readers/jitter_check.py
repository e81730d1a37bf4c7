"""Check of a capture's jitter: the target, sampled at the jittered positions, has to resemble the inputs.

The recorded jitter is compared with none, with the other signs and orders of axes, and with offsets on a grid: jitter
that is 0, in another unit or of another frame fits none of the conventions.
"""

from collections.abc import Sequence
from itertools import product

import numpy as np
import torch
from numpy.typing import NDArray

from supersampling.data.readers.conventions import Convention
from supersampling.data.readers.motion_check import BEYOND_DOUBT, best_convention
from supersampling.data.readers.pairs import Pair
from supersampling.errors import UserError
from supersampling.ops.interpolate import sample_bilinear
from supersampling.ops.warp import sampling_grid

CLEARLY = 0.97  # aliasing leaves a difference that the correct jitter cannot remove
NONE = "none"
STEPS = (-0.5, -0.25, 0.0, 0.25, 0.5)  # pixels
ELSEWHERE = 0.8  # an offset of the grid has to leave less than this share of the difference
DISTANCE = 0.2  # pixels between that offset and the recorded one, on average: the grid is no finer


def mean_errors(pairs: Sequence[Pair], used: Convention) -> dict[str, float]:
    """Return the mean absolute difference of the inputs and the target at their positions, by convention and for
    `NONE`."""
    total = dict.fromkeys((NONE, *(c.name for c in used.variants())), 0.0)
    for pair in pairs:
        stored = used.encode(pair.clip.read(pair.t, frozenset({"jitter"}))["jitter"])
        offsets = {c.name: c.decode(stored) for c in used.variants()} | {NONE: np.zeros(2, np.float32)}
        differences = _differences(pair, np.stack(list(offsets.values())))
        for name, difference in zip(offsets, differences):
            total[name] += difference / len(pairs)
    return total


def _differences(pair: Pair, offsets: NDArray[np.float32]) -> list[float]:
    """Return the mean absolute difference of the inputs and the target at the pixels' centres plus each of ``offsets``
    ``(n, 2)`` in low-resolution pixels."""
    color, target = pair.tensor("color"), pair.tensor("target")
    height, width = color.shape[-2:]
    shifts = torch.from_numpy(offsets / np.array((width, height), np.float32)).view(-1, 1, 2, 1, 1)
    sampled = (sample_bilinear(target, sampling_grid(shift.expand(1, 2, height, width))) for shift in shifts)
    return [float((image - color).abs().mean()) for image in sampled]


def _check_elsewhere(label: str, pairs: Sequence[Pair], used: Convention, best: float) -> None:
    """Raise `UserError` if other offsets fit clearly better than the recorded ones, and than the convention that fits
    best, which leaves the mean difference ``best``."""
    grid = np.array(list(product(STEPS, STEPS)), dtype=np.float32)
    total, least, distance, example = 0.0, 0.0, 0.0, ""
    for pair in pairs:
        recorded = pair.read("jitter")
        error, *errors = _differences(pair, np.concatenate((recorded[None], grid)))
        place = grid[int(np.argmin(errors))]
        total, least = total + error, least + min(errors)
        distance += float(np.abs(place - recorded).max()) / len(pairs)
        example = f"about ({place[0]:g}, {place[1]:g}), not ({recorded[0]:.3g}, {recorded[1]:.3g}), in {pair.label}"
    if least < ELSEWHERE * min(total, best * len(pairs)) and distance > DISTANCE:
        raise UserError(
            f"{label}: the inputs were sampled elsewhere than their jitter says ({example}; mean difference "
            f"{least / len(pairs):.4g} rather than {total / len(pairs):.4g}): record the jitter of these frames, in "
            f"low-resolution pixels from the pixel's centre, or import with jitter_convention={used.name}."
        )


def check_jitter(label: str, pairs: Sequence[Pair], used: Convention, overridden: bool) -> str:
    """Return one line about the result; ``overridden`` means that the user set the convention ``used``.

    Raises:
        UserError: a different convention fits clearly better, or beyond doubt if the user set the convention; or no
        jitter, or other offsets, do and the user did not set it.
    """
    if not pairs:
        return f"{label}: clips of one frame, so the jitter (read as {used.name}) was not checked."
    errors = mean_errors(pairs, used)
    error, best = errors[used.name], best_convention(errors, NONE)
    result = f"mean difference {error:.4g} with jitter read as {used.name}, {errors[NONE]:.4g} without jitter"
    if not overridden:
        _check_elsewhere(label, pairs, used, min(errors.values()))
    if errors[best] < (BEYOND_DOUBT if overridden else CLEARLY) * error and errors[best] < errors[NONE]:
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
    if errors[best] < CLEARLY * error and errors[best] < errors[NONE]:
        result += f", {errors[best]:.4g} read as {best}, which fits better"
    return f"{label}: {result}."
