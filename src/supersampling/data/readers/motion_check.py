"""Check of a capture's motion: the target of frame ``t - 1``, warped by it, has to resemble that of frame ``t``.

The target is warped rather than the inputs: it is neither jittered nor aliased, and every layout has one. On moving
pixels, the converted motion is compared with no motion, with the seven other signs and orders of axes, with half and
twice of each, and with the motion of the frames before and after. Where the pictures move otherwise than recorded, or
move without any recorded motion (`picture_motion`), motion is missing.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import torch

from supersampling.data.readers.conventions import CONVENTIONS, FACTORS, Convention
from supersampling.data.readers.pairs import MOVING, SELECTED, Pair, extremes
from supersampling.data.readers.picture_motion import Unexplained, unexplained_motion, zero_axis
from supersampling.errors import UserError
from supersampling.ops.interpolate import sample_bilinear
from supersampling.ops.resample import upsample_motion
from supersampling.ops.warp import outside, sampling_grid, warp

CLEARLY = 0.9  # a better convention has to leave less than this share of the error
BEYOND_DOUBT = 0.5  # the same if the user set the convention
ENOUGH = 0.01  # share of moving pixels; with less motion, a capture counts as still
SAMPLES = 100_000  # pixels per pair that are compared
STILL = "still"
MISSING = 0.2  # share of unexplained blocks, on average, at which motion does not belong to the pictures
MISSING_STILL = 0.05  # the same where no motion is recorded at all
MISSING_ONCE = 0.5  # the same in a single frame
WRONG_FRAME = 0.7  # the motion of another frame has to leave less than this share of the error
NOTED = 0.01  # share of unexplained blocks that is worth a line


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
    return {name: value / count if count else float("nan") for name, value in total.items()}


def best_convention(errors: Mapping[str, float], without: str) -> str:
    """Return the convention with the smallest error, apart from ``without``."""
    return min((name for name in errors if name != without), key=lambda name: errors[name])


def check_motion(label: str, pairs: Sequence[Pair], used: Convention, overridden: bool) -> str:
    """Return a line for each result; ``overridden`` means that the user set the convention ``used``.

    Args:
        label: the beginning of each line.
        pairs: pairs of frames, those with the most motion first.
        used: the convention that the motion was read with.
        overridden: whether the user set it.

    Raises:
        UserError: a different convention fits clearly better, or beyond doubt if the user set the convention; or no
        motion fits as well, the motion is that of another frame or the pictures move otherwise, and the user did not
        set it.
    """
    moving = [pair for pair in pairs[:SELECTED] if pair.moving >= ENOUGH]
    lines = [_check_convention(label, moving, used, overridden)] if moving else []
    if moving and not overridden:
        _check_frame(label, moving)
    lines += _check_pictures(label, extremes(pairs), used, overridden)
    return "\n".join(lines)


def _check_convention(label: str, moving: Sequence[Pair], used: Convention, overridden: bool) -> str:
    errors = mean_errors(moving, used, [Convention(c.name + factor) for c in CONVENTIONS for factor in FACTORS])
    error, still, best = errors[used.name], errors[STILL], best_convention(errors, STILL)
    if math.isnan(error):
        raise UserError(
            f"{label}: by its motion, every pixel comes from outside the image: write motion in fractions of the "
            "image's width and height, and 0 where nothing moves."
        )
    result = f"mean difference {error:.4g} with motion read as {used.name}, {still:.4g} without motion"
    if errors[best] < (BEYOND_DOUBT if overridden else CLEARLY) * error and errors[best] < still:
        raise UserError(
            f"{label}: the motion does not fit ({result}, {errors[best]:.4g} read as {best}): import with "
            f"convention={best}{_empty_axis(moving)}."
        )
    if error >= still and not overridden:
        raise UserError(
            f"{label}: the motion does not fit ({result}, at best {errors[best]:.4g}, read as {best}): "
            f"{_advice(moving, used)}."
        )
    if errors[best] < CLEARLY * error and errors[best] < still:
        result += f", {errors[best]:.4g} read as {best}, which fits better"
    return f"{label}: {result}."


def _empty_axis(pairs: Sequence[Pair]) -> str:
    axis = zero_axis(pairs)
    return f"; or, since the {axis} component of all motion is 0, record both components" if axis else ""


def _check_frame(label: str, moving: Sequence[Pair]) -> None:
    """Raise `UserError` if the motion of the frame before or after fits clearly better where the two differ."""
    for step, name in ((1, "after"), (-1, "before")):
        errors = [_frame_errors(pair, step) for pair in moving if 0 <= pair.t + step < pair.clip.frames]
        current, neighbour = (sum(values) for values in zip(*errors)) if errors else (0.0, 0.0)
        if neighbour < WRONG_FRAME * current:
            raise UserError(
                f"{label}: the motion of the frame {name} fits better (difference {neighbour / current:.2g} times as "
                "large where the two differ): number the motion files as the frames that they belong to."
            )


def _frame_errors(pair: Pair, step: int) -> tuple[float, float]:
    """Return the mean difference with the motion of frame ``t`` and of frame ``t + step``, where they differ; 0 if they
    hardly do."""
    before, now = pair.tensor("target", before=True), pair.tensor("target")
    size = (now.shape[-2], now.shape[-1])
    motions = [upsample_motion(frame.tensor("motion"), size) for frame in (pair, replace(pair, t=pair.t + step))]
    length = (motions[0] - motions[1]).mul(now.new_tensor(size[::-1]).view(1, 2, 1, 1)).norm(dim=1, keepdim=True)
    compared = (length >= MOVING) & ~outside(motions[0]) & ~outside(motions[1])
    if float(compared.float().mean()) < ENOUGH:
        return 0.0, 0.0
    current, neighbour = (
        float(((warp(before, motion) - now).abs() * compared).mean() / compared.float().mean()) for motion in motions
    )
    return current, neighbour


def _check_pictures(label: str, pairs: Sequence[Pair], used: Convention, overridden: bool) -> list[str]:
    """Return lines on what moves otherwise than recorded; see `check_motion` for the arguments and errors."""
    if not pairs:
        return [f"{label}: clips of one frame, so the motion (read as {used.name}) could not be checked."]
    results = [unexplained_motion(pair) for pair in pairs]
    mean = sum(result.share for result in results) / len(results)
    worst, pair = max(zip(results, pairs), key=lambda item: item[0].share)
    still = all(pair.moving < ENOUGH for pair in pairs)
    place = f"{mean:.0%} of the pictures ({worst.share:.0%} in {pair.label})"
    cause = _cause(pairs, worst, pair)
    text = f"{label}: {place} move otherwise than recorded, by about {worst.pixels:.0f} pixels: {cause}"
    if not overridden and (mean > (MISSING_STILL if still else MISSING) or worst.share > MISSING_ONCE):
        raise UserError(
            f"{text}; if only water, shadows or similar content moves differently, import with convention={used.name}."
        )
    lines = [f"{text}."] if mean > NOTED or worst.share > 5.0 * NOTED else []
    if not still and all(np.ptp(pair.read("motion"), axis=(0, 1)).max() == 0.0 for pair in pairs):
        lines.append(f"{label}: every pixel of a frame has the same motion, as if the picture were flat.")
    if still and not lines:
        lines = [
            f"{label}: almost no pixel moves, neither in the motion nor in the pictures, so the convention of motion "
            f"(read as {used.name}) could not be checked."
        ]
    return lines


def _cause(pairs: Sequence[Pair], worst: Unexplained, pair: Pair) -> str:
    """Return what seems to be wrong with the motion; ``pair`` is the pair with the ``worst`` result."""
    axis = zero_axis(pairs)
    if np.array_equal(pair.read("target", before=True), pair.read("target")):
        return "the target equals the one before, so the recorder seems to have dropped a frame"
    if not any(pair.read("motion").any() for pair in pairs):
        return "all motion is 0, so record the motion again"
    if axis:
        return f"the {axis} component of all motion is 0, so record both components"
    if worst.without_motion > 0.5 * worst.share:
        return "motion is 0 there, so record the camera's motion for all pixels, and that of animated objects"
    return "check that motion, pictures and frame numbers belong together"


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
