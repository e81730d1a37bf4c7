"""Colours and radiance: black, white, single and alternating pixels, and the ends of float16."""

from functools import partial

import torch
from torch import Tensor

from supersampling.stress.clip import Clip, each
from supersampling.stress.extreme import COLOURS, Extreme

HALF_LARGEST = 65504.0
LIGHT = ("radiance", "target_radiance")


def everywhere(clip: Clip, value: float, names: tuple[str, ...]) -> Clip:
    """One value in every pixel; emission, which is part of the radiance, is taken away."""
    clip = each(clip, torch.zeros_like, "emission", "high_emission") if "radiance" in names else clip
    return each(clip, lambda v: torch.full_like(v, value), *names)


def hot_pixel(clip: Clip, value: float, names: tuple[str, ...]) -> Clip:
    """All black but one pixel in the middle."""

    def change(values: Tensor) -> Tensor:
        black = torch.zeros_like(values)
        black[..., values.shape[-2] // 2, values.shape[-1] // 2] = value
        return black

    return each(each(clip, torch.zeros_like, "emission", "high_emission"), change, *names)


def checkerboard(clip: Clip, value: float, names: tuple[str, ...]) -> Clip:
    """Every other pixel, of every buffer's own resolution: the Nyquist frequency."""

    def change(values: Tensor) -> Tensor:
        rows, columns = (torch.arange(n) for n in values.shape[-2:])
        return (((rows[:, None] + columns) % 2) * value).to(values).expand_as(values).clone()

    return each(each(clip, torch.zeros_like, "emission", "high_emission"), change, *names)


def scaled(clip: Clip, gain: float) -> Clip:
    """Radiance and emission times ``gain``."""
    return each(clip, lambda v: v * gain, *LIGHT, "emission", "high_emission")


def spread(clip: Clip, low: float, high: float) -> Clip:
    """Radiance from ``low`` to ``high`` in one image, evenly in its logarithm, from left to right."""

    def change(values: Tensor) -> Tensor:
        place = torch.linspace(0.0, 1.0, values.shape[-1], dtype=values.dtype)
        return (low * (high / low) ** place).expand_as(values).clone()

    return each(each(clip, torch.zeros_like, "emission", "high_emission"), change, *LIGHT)


def _both(name: str, says: str, made: object, value: float, light: float) -> tuple[Extreme, ...]:
    """For displayed colour up to ``value`` and radiance up to ``light``."""

    def change(clip: Clip) -> Clip:
        clip = made(clip, value, ("color", "target"))  # type: ignore[operator]
        return made(clip, light, LIGHT) if "radiance" in clip else clip  # type: ignore[operator]

    return (Extreme(f"colour/{name}", says, change, frozenset(COLOURS)),)


COLOUR = (
    *_both("black", "Colour and radiance are 0.", everywhere, 0.0, 0.0),
    *_both("white", "Colour is 1, radiance 65504, everywhere.", everywhere, 1.0, HALF_LARGEST),
    *_both("hot pixel", "Black, with one pixel at the largest value.", hot_pixel, 1.0, HALF_LARGEST),
    *_both("checkerboard", "0 and 1 in turn, pixel by pixel (Nyquist); radiance 0 and 100.", checkerboard, 1.0, 100.0),
    *_both("denormal", "Colour and radiance are 1e-40, below float32's normal numbers.", everywhere, 1e-40, 1e-40),
    Extreme("hdr/1e-8", "Radiance times 1e-8.", partial(scaled, gain=1e-8), frozenset(LIGHT)),
    Extreme("hdr/65504", "Radiance of 65504, float16's largest.",
            partial(everywhere, value=HALF_LARGEST, names=LIGHT), frozenset(LIGHT)),
    Extreme("hdr/1e6", "Radiance of 1e6, beyond float16.", partial(everywhere, value=1e6, names=LIGHT), frozenset(LIGHT)),
    Extreme("hdr/1e-8 to 65504", "Radiance from 1e-8 to 65504 in one image.",
            partial(spread, low=1e-8, high=HALF_LARGEST), frozenset(LIGHT)),
    Extreme("hdr/infinite", "Radiance is infinite, as float16 stores what is beyond it.",
            partial(everywhere, value=float("inf"), names=("radiance",)), frozenset(LIGHT)),
    Extreme("colour/out of range", "Displayed colour from -1 to 2.",
            lambda clip: each(clip, lambda v: 3.75 * v - 1.375, "color"), frozenset({"color"})),
)  # fmt: skip
