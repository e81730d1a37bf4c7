"""Check of a capture's motion: the target of frame ``t - 1``, warped by it, has to resemble that of frame ``t``.

The target is warped rather than the inputs: it is neither jittered nor aliased, and every layout has one. On moving
pixels, the converted motion is compared with no motion, with the seven other signs and orders of axes, and with half
and twice of each.
"""

from collections.abc import Mapping, Sequence

import torch

from supersampling.data.readers.conventions import CONVENTIONS, FACTORS, Convention
from supersampling.data.readers.pairs import MOVING, Pair
from supersampling.errors import UserError
from supersampling.ops.interpolate import sample_bilinear
from supersampling.ops.resample import upsample_motion
from supersampling.ops.warp import outside, sampling_grid

CLEARLY = 0.9  # a better convention has to leave less than this share of the error
ENOUGH = 0.01  # share of moving pixels; with less motion, a capture counts as still
SAMPLES = 100_000  # pixels per pair that are compared
STILL = "still"


def mean_errors(
    pairs: Sequence[Pair], used: Convention, candidates: Sequence[Convention], unit: tuple[float, float] = (1.0, 1.0)
) -> dict[str, float]:
    """Return the mean absolute difference by convention and for `STILL`, over moving pixels that come from inside the
    image.

    ``unit`` is the size of a stored 1 in image sizes, for captures with a different unit.
    """
    total = dict.fromkeys((STILL, *(c.name for c in candidates)), 0.0)
    count = 0
    for pair in pairs:
        before, now, motion = pair.tensor("target", before=True), pair.tensor("target"), pair.tensor("motion")
        height, width = now.shape[-2:]
        large = upsample_motion(motion * motion.new_tensor(unit).view(1, 2, 1, 1), (height, width))
        length = (large * large.new_tensor((width, height)).view(1, 2, 1, 1)).norm(dim=1, keepdim=True)
        pixels = ((length >= MOVING) & ~outside(large))[0, 0].nonzero()
        # In a different unit, all pixels may be still or come from outside.
        if not len(pixels):
            continue
        rows, columns = pixels[:: len(pixels) // SAMPLES + 1].unbind(dim=1)
        vectors = large[0, :, rows, columns].T
        places = sampling_grid(large)[0, rows, columns] - 2.0 * vectors
        current = now[0, :, rows, columns]
        count += len(rows)
        total[STILL] += float((before[0, :, rows, columns] - current).abs().mean(dim=0).sum(dtype=torch.float64))
        stored = used.encode(vectors.numpy())
        for candidate in candidates:
            fetched = sample_bilinear(before, (places + 2.0 * torch.from_numpy(candidate.decode(stored)))[None, None])
            total[candidate.name] += float((fetched[0, :, 0] - current).abs().mean(dim=0).sum(dtype=torch.float64))
    return {name: value / max(count, 1) for name, value in total.items()}


def best_convention(errors: Mapping[str, float], without: str) -> str:
    """Return the convention with the smallest error, apart from ``without``."""
    return min((name for name in errors if name != without), key=lambda name: errors[name])


def check_motion(label: str, pairs: Sequence[Pair], used: Convention, overridden: bool) -> str:
    """Return one line about the result; ``overridden`` means that the user set the convention ``used``.

    Raises:
        UserError: a different convention fits clearly better, or no motion fits as well and the user did not set the
        convention.
    """
    moving = [pair for pair in pairs if pair.moving >= ENOUGH]
    if not moving:
        return f"{label}: almost no pixel moves, so the motion (read as {used.name}) could not be checked."
    errors = mean_errors(moving, used, [Convention(c.name + factor) for c in CONVENTIONS for factor in FACTORS])
    error, still, best = errors[used.name], errors[STILL], best_convention(errors, STILL)
    result = f"mean difference {error:.4g} with motion read as {used.name}, {still:.4g} without motion"
    if errors[best] < CLEARLY * error and errors[best] < still:
        raise UserError(
            f"{label}: the motion does not fit ({result}, {errors[best]:.4g} read as {best}): import with "
            f"convention={best}."
        )
    if error >= still and not overridden:
        raise UserError(
            f"{label}: the motion does not fit ({result}, at best {errors[best]:.4g}, read as {best}): "
            f"{_advice(moving, used)}."
        )
    return f"{label}: {result}."


def _advice(pairs: Sequence[Pair], used: Convention) -> str:
    """Return advice if no convention fits: the unit or the frames may be wrong."""
    width, height = pairs[0].clip.size
    rows, columns = pairs[0].read("motion").shape[:2]
    units = {
        "pixels of the inputs": (1.0 / columns, 1.0 / rows),
        "pixels of the target": (1.0 / width, 1.0 / height),
        "percent of the image": (0.01, 0.01),
    }
    for unit, size in units.items():
        errors = mean_errors(pairs, used, used.variants(), size)
        best = best_convention(errors, STILL)
        if errors[best] < CLEARLY * errors[STILL]:
            return f"it would fit in {unit} (read as {best}), so write it in fractions of the image's width and height"
    return (
        "check that it belongs to these frames; if only water, shadows or similar content moves differently, import "
        "with "
        f"convention={used.name}"
    )
