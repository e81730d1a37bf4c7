"""Check of a capture's pictures: each buffer holds something, and the inputs show what the targets show."""

from collections.abc import Sequence

import torch
import torch.nn.functional as F
from torch import Tensor

from supersampling.data.readers.pairs import MOVING, Pair
from supersampling.errors import UserError
from supersampling.ops.display import linear_to_srgb

SHOWN = frozenset({"color", "radiance", "depth", "normal", "target", "target_radiance", "high_material"})
"""Buffers that no scene leaves empty."""
BRIGHT = 1.1  # ratio of the brightness of inputs and targets that is worth a line
ALIKE = 0.5  # correlation of inputs and targets below which a line is due; aliasing leaves more
DISAGREE = 0.2  # share of pixels with different motion in two buffers
NOTED = 0.005  # the same, away from edges, that is worth a line
ENLARGED = 0.5 / 255.0  # mean difference between a target and its enlarged input
DETAIL = 0.01  # mean difference between neighbouring pixels, without which enlarging changes nothing


def check_pictures(label: str, pairs: Sequence[Pair], buffers: frozenset[str], depth_overridden: bool) -> str:
    """Return lines about buffers that look wrong, and one with the range of each buffer.

    Args:
        label: the beginning of each line.
        pairs: pairs of frames, of which the later ones are looked at.
        buffers: names of the buffers.
        depth_overridden: whether the user set the direction of depth, and so accepts depth without any.

    Raises:
        UserError: a buffer has a single value in all these frames, or inputs are negatives of the targets.
    """
    lines = [_check_ranges(label, pairs, buffers - ({"depth"} if depth_overridden else set()))]
    low_name = "color" if "color" in buffers else "radiance"
    if "color" in buffers or "high_material" in buffers:
        lines += _check_inputs(label, pairs, low_name)
    if "color" in buffers:
        lines += _check_enlarged(label, pairs)
    if "high_motion" in buffers:
        lines += _check_high_motion(label, pairs)
    if "motion_dual" in buffers:
        lines += _check_dual_motion(label, pairs)
    if "color" not in buffers and "target_radiance" in buffers:
        lines += _check_remodulation(label, pairs)
    if "color" in buffers and "radiance" in buffers:
        lines += _check_linear(label, pairs)
    return "\n".join(lines)


def _check_ranges(label: str, pairs: Sequence[Pair], buffers: frozenset[str]) -> str:
    ranges = []
    for name in sorted(buffers - {"jitter", "material", "emission"}):
        images = [pair.read(name) for pair in pairs]
        lowest, highest = min(float(i.min()) for i in images), max(float(i.max()) for i in images)
        if lowest == highest and name in SHOWN and (name != "normal" or lowest == 0.0):
            raise UserError(
                f"{label}: {name} is {lowest:.4g} in every pixel of the {len(images)} frames that were looked at: the "
                "recorder wrote nothing, export it again."
            )
        ranges.append(f"{name} {lowest + 0.0:.3g} to {highest + 0.0:.3g}")
    return f"{label}: as read, {', '.join(ranges)}."


def _check_inputs(label: str, pairs: Sequence[Pair], low_name: str) -> list[str]:
    """Compare brightness and content of inputs with those of the targets, reduced to the same size."""
    ratios, likeness = [], []
    for pair in pairs:
        low, high, mask = _compared(pair, low_name)
        if not float(mask.sum()):
            continue
        low, high = low[mask], high[mask]
        ratios.append((float(low.mean()) + 1e-4) / (float(high.mean()) + 1e-4))
        likeness.append(
            (float(torch.corrcoef(torch.stack((low, high)))[0, 1]) if low.std() * high.std() else 1.0, pair)
        )
    if not ratios:
        return []
    lines = []
    mean, (least, pair) = sum(value for value, _ in likeness) / len(likeness), min(likeness, key=lambda item: item[0])
    if mean < -ALIKE:
        raise UserError(
            f"{label}: the inputs show the opposite of the targets (correlation {mean:.2f}): check that {low_name} and "
            "targets belong to the same frames, and that neither is inverted."
        )
    if least < ALIKE:
        lines.append(
            f"{label}: the inputs hardly show what the targets show (correlation {mean:.2f}, {least:.2f} in "
            f"{pair.label}): check that they belong to the same frames."
        )
    worst = max(ratios, key=lambda ratio: max(ratio, 1.0 / ratio))
    if max(worst, 1.0 / worst) > BRIGHT:
        lines.append(
            f"{label}: the inputs are {sum(ratios) / len(ratios):.3g} times as bright as the targets (up to "
            f"{worst:.3g} times): check the exposure and the tone mapping of both."
        )
    return lines


def _compared(pair: Pair, low_name: str) -> tuple[Tensor, Tensor, Tensor]:
    """Return inputs, targets of their size and the pixels to compare, ``(1, 1, h, w)``, where light is compressed."""
    low = pair.tensor(low_name)
    if low_name == "color":
        high, valid = pair.tensor("target"), torch.ones_like(pair.tensor("target")[:, :1])
    else:
        material = pair.tensor("high_material")
        light = (pair.tensor("target_radiance") - pair.tensor("high_emission")) / material.clamp_min(1e-3)
        low, high = low / (1.0 + low), light / (1.0 + light)
        valid = (material > 1e-3).all(dim=1, keepdim=True).float()
    size = (low.shape[-2], low.shape[-1])
    low, high = low.mean(dim=1, keepdim=True), F.adaptive_avg_pool2d(high, size).mean(dim=1, keepdim=True)
    return low, high, F.adaptive_avg_pool2d(valid, size) == 1.0


def _check_enlarged(label: str, pairs: Sequence[Pair]) -> list[str]:
    for mode in ("nearest", "bilinear", "bicubic"):
        differences, detail = [], []
        for pair in pairs:
            low, target = pair.tensor("color"), pair.tensor("target")
            large = F.interpolate(low, target.shape[-2:], mode=mode)
            differences.append(float((large.clamp(0.0, 1.0) - target).abs().mean()))
            detail.append(float((low[..., 1:] - low[..., :-1]).abs().mean()))
        if differences and max(differences) < ENLARGED and min(detail) > DETAIL:
            return [f"{label}: the targets are the inputs, enlarged ({mode}): record targets at full resolution."]
    return []


def _differing(first: Tensor, second: Tensor, size: tuple[int, int]) -> float:
    """Return the share of pixels whose motion differs by at least `MOVING` target pixels."""
    length = (first - second).mul(first.new_tensor(size).view(1, 2, 1, 1)).norm(dim=1)
    return float((length >= MOVING).float().mean())


def _unlike_neighbours(first: Tensor, second: Tensor, size: tuple[int, int]) -> float:
    """Return the share of pixels whose motion differs by at least `MOVING` target pixels from all of the 3x3 pixels
    around the same place: more than jitter and edges explain."""
    height, width = first.shape[-2:]
    around = F.unfold(F.pad(second, (1, 1, 1, 1), mode="replicate"), 3).view(1, 2, 9, height, width)
    length = (first[:, :, None] - around).mul(first.new_tensor(size).view(1, 2, 1, 1, 1)).norm(dim=1)
    return float((length.amin(dim=1) >= MOVING).float().mean())


def _check_high_motion(label: str, pairs: Sequence[Pair]) -> list[str]:
    shares = []
    for pair in pairs:
        low, high = pair.tensor("motion"), pair.tensor("high_motion")
        shares.append(_unlike_neighbours(low, F.interpolate(high, low.shape[-2:], mode="nearest"), pair.clip.size))
    worst = max(shares, default=0.0)
    text = f"{label}: motion in high and in low resolution differ in {worst:.1%} of the pixels of a frame"
    if worst > DISAGREE:
        raise UserError(f"{text}: record both in the same convention and for the same frames.")
    return [f"{text}, away from edges: check that both are of the same frames."] if worst > NOTED else []


def _check_dual_motion(label: str, pairs: Sequence[Pair]) -> list[str]:
    shares = [_differing(pair.tensor("motion"), pair.tensor("motion_dual"), pair.clip.size) for pair in pairs]
    if shares and max(shares) > DISAGREE:
        return [
            f"{label}: dual motion (OCMV) differs from motion (MV) in up to {max(shares):.0%} of a frame's pixels, "
            "though it should only where something was hidden before: check its convention."
        ]
    return []


def _check_remodulation(label: str, pairs: Sequence[Pair]) -> list[str]:
    differences = [
        float((linear_to_srgb(pair.tensor("target_radiance").clamp(0.0, 1.0)) - pair.tensor("target")).abs().mean())
        for pair in pairs
    ]
    if differences and max(differences) > 0.1:
        return [
            f"{label}: the remodulated target (BRDF * Irradiance, Emission_Sky) differs from View_PNG by up to "
            f"{max(differences):.2g} on average: check exposure and tone mapping of both."
        ]
    return []


def _check_linear(label: str, pairs: Sequence[Pair]) -> list[str]:
    highest = max((float(pair.read("target_radiance").max()) for pair in pairs), default=2.0)
    if highest <= 1.0:
        return [
            f"{label}: no radiance exceeds {highest:.3g}: check that the images are linear and not already tone-mapped."
        ]
    return []
