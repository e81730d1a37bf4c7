"""Does a capture's motion say where each pixel was? Frame ``t - 1``'s target, warped by it, has to resemble frame ``t``'s.

The target is warped rather than the inputs: it is neither jittered nor aliased, and every layout has one. The converted motion
is compared, on what moves, with no motion at all, with the seven other signs and orders of axes, and with half and twice each.
"""

from collections.abc import Mapping, Sequence

import torch

from supersampling.data.readers.conventions import CONVENTIONS, FACTORS, Convention
from supersampling.data.readers.pairs import MOVING, Pair
from supersampling.errors import UserError
from supersampling.ops.interpolate import sample_bilinear
from supersampling.ops.resample import upsample_motion
from supersampling.ops.warp import outside, sampling_grid

CLEARLY = 0.9  # another convention has to leave less than this share of our error
ENOUGH = 0.01  # share of moving pixels below which a capture counts as still
SAMPLES = 100_000  # pixels of a pair that are looked at
STILL = "still"


def mean_errors(
    pairs: Sequence[Pair],
    used: Convention,
    others: Sequence[Convention],
    unit: tuple[float, float] = (1.0, 1.0),
) -> dict[str, float]:
    """Mean absolute difference by convention, and for `STILL`, over moving pixels that come from inside the image.

    ``unit`` is what a stored 1 means in image sizes, for captures that keep to another one.
    """
    total = dict.fromkeys((STILL, *(c.name for c in others)), 0.0)
    count = 0
    for pair in pairs:
        before, now, motion = pair.tensor("target", before=True), pair.tensor("target"), pair.tensor("motion")
        height, width = now.shape[-2:]
        large = upsample_motion(motion * motion.new_tensor(unit).view(1, 2, 1, 1), (height, width))
        length = (large * large.new_tensor((width, height)).view(1, 2, 1, 1)).norm(dim=1, keepdim=True)
        chosen = ((length >= MOVING) & ~outside(large))[0, 0].nonzero()
        if not len(chosen):  # in another unit, perhaps all stands still or comes from outside
            continue
        rows, columns = chosen[:: len(chosen) // SAMPLES + 1].unbind(dim=1)
        vectors = large[0, :, rows, columns].T
        places = sampling_grid(large)[0, rows, columns] - 2.0 * vectors
        there = now[0, :, rows, columns]
        count += len(rows)
        total[STILL] += float((before[0, :, rows, columns] - there).abs().mean(dim=0).sum(dtype=torch.float64))
        stored = used.encode(vectors.numpy())
        for other in others:
            fetched = sample_bilinear(before, (places + 2.0 * torch.from_numpy(other.decode(stored)))[None, None])
            total[other.name] += float((fetched[0, :, 0] - there).abs().mean(dim=0).sum(dtype=torch.float64))
    return {name: value / max(count, 1) for name, value in total.items()}


def best_convention(errors: Mapping[str, float], without: str) -> str:
    """The convention with the least error."""
    return min((name for name in errors if name != without), key=lambda name: errors[name])


def check_motion(where: str, pairs: Sequence[Pair], used: Convention, asked: bool) -> str:
    """One line about the outcome; ``asked`` says that the user chose the convention ``used``.

    Raises:
        UserError: another convention fits clearly better, or, unless the user asked for this one, motion is no better than none.
    """
    moving = [pair for pair in pairs if pair.moving >= ENOUGH]
    if not moving:
        return f"{where}: next to nothing moves, so its motion (read as {used.name}) could not be checked."
    errors = mean_errors(moving, used, [Convention(c.name + factor) for c in CONVENTIONS for factor in FACTORS])
    ours, still, best = errors[used.name], errors[STILL], best_convention(errors, STILL)
    told = f"mean difference {ours:.4g} with motion read as {used.name}, {still:.4g} without motion"
    if errors[best] < CLEARLY * ours and errors[best] < still:
        raise UserError(
            f"{where}: the motion does not fit: {told}, {errors[best]:.4g} read as {best}; import with convention={best}."
        )
    if ours >= still and not asked:
        raise UserError(
            f"{where}: the motion explains nothing: {told}, {errors[best]:.4g} at best, as {best}; {_advice(moving, used)}."
        )
    return f"{where}: {told}."


def _advice(pairs: Sequence[Pair], used: Convention) -> str:
    """What may be wrong where no convention fits: the unit, or all of it."""
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
            return f"in {unit} it would fit (as {best}): write it in fractions of the image's width and height"
    return (
        "it may belong to other frames; if the content only seems to move otherwise (water, shadows), import with "
        f"convention={used.name}"
    )
