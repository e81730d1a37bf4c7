"""Colours and radiance: black, white, single and alternating pixels, and the ends of float16."""

from collections.abc import Callable
from functools import partial

import torch
from torch import Tensor

from supersampling.stress.clip import Clip, change_buffers, fill_buffers
from supersampling.stress.extreme import COLOURS, Extreme

HALF_LARGEST = 65504.0
LIGHT = ("radiance", "target_radiance")
EMISSION = ("emission", "high_emission")
Change = Callable[[Clip, float, tuple[str, ...]], Clip]


def fill(clip: Clip, value: float, names: tuple[str, ...]) -> Clip:
    """Return the clip with one value in every pixel; emission, which is part of the radiance, is removed."""
    return fill_buffers(_without_emission(clip) if "radiance" in names else clip, value, *names)


def set_hot_pixel(clip: Clip, value: float, names: tuple[str, ...]) -> Clip:
    """Return the clip all black except for one pixel in the middle."""

    def change(values: Tensor) -> Tensor:
        black = torch.zeros_like(values)
        black[..., values.shape[-2] // 2, values.shape[-1] // 2] = value
        return black

    return change_buffers(_without_emission(clip), change, *names)


def set_checkerboard(clip: Clip, value: float, names: tuple[str, ...]) -> Clip:
    """Return the clip with ``value`` in every second pixel of each buffer's own resolution: the Nyquist frequency."""

    def change(values: Tensor) -> Tensor:
        rows, columns = (torch.arange(n) for n in values.shape[-2:])
        return (((rows[:, None] + columns) % 2) * value).to(values).expand_as(values).clone()

    return change_buffers(_without_emission(clip), change, *names)


def scale_light(clip: Clip, gain: float) -> Clip:
    """Return the clip with radiance and emission times ``gain``."""
    return change_buffers(clip, lambda values: values * gain, *LIGHT, *EMISSION)


def spread_light(clip: Clip, low: float, high: float) -> Clip:
    """Return the clip with radiance from ``low`` at the left to ``high`` at the right, uniform in its logarithm."""

    def change(values: Tensor) -> Tensor:
        fraction = torch.linspace(0.0, 1.0, values.shape[-1], dtype=values.dtype)
        return (low * (high / low) ** fraction).expand_as(values).clone()

    return change_buffers(_without_emission(clip), change, *LIGHT)


def _without_emission(clip: Clip) -> Clip:
    return fill_buffers(clip, 0.0, *EMISSION)


def _colour_and_light(name: str, meaning: str, change: Change, value: float, light: float) -> Extreme:
    """Return an extreme of displayed colour up to ``value`` and of radiance up to ``light``."""

    def change_colours(clip: Clip) -> Clip:
        clip = change(clip, value, ("color", "target"))
        return change(clip, light, LIGHT) if "radiance" in clip else clip

    return Extreme(f"colour/{name}", meaning, change=change_colours, touches=frozenset(COLOURS))


def _light(name: str, meaning: str, change: Callable[[Clip], Clip]) -> Extreme:
    return Extreme(f"hdr/{name}", meaning, change=change, touches=frozenset(LIGHT))


COLOUR = (
    _colour_and_light("black", "Colour and radiance are 0.", fill, 0.0, 0.0),
    _colour_and_light("white", "Colour is 1, radiance 65504, in every pixel.", fill, 1.0, HALF_LARGEST),
    _colour_and_light("hot pixel", "Black, with one pixel at the largest value.", set_hot_pixel, 1.0, HALF_LARGEST),
    _colour_and_light(
        "checkerboard", "Colour alternates between 0 and 1 (Nyquist); radiance 0 and 100.", set_checkerboard, 1.0, 100.0
    ),
    _colour_and_light("denormal", "Colour and radiance are 1e-40, below float32's normal range.", fill, 1e-40, 1e-40),
    _light("1e-8", "Radiance times 1e-8.", partial(scale_light, gain=1e-8)),
    _light("65504", "Radiance of 65504, float16's largest.", partial(fill, value=HALF_LARGEST, names=LIGHT)),
    _light("1e6", "Radiance of 1e6, beyond float16.", partial(fill, value=1e6, names=LIGHT)),
    _light(
        "1e-8 to 65504", "Radiance from 1e-8 to 65504 in one image.", partial(spread_light, low=1e-8, high=HALF_LARGEST)
    ),
    _light(
        "infinite",
        "Radiance is infinite, as float16 stores values beyond its range.",
        partial(fill, value=float("inf"), names=("radiance",)),
    ),
    Extreme(
        "colour/out of range",
        "Displayed colour from -1 to 2.",
        change=lambda clip: change_buffers(clip, lambda values: 3.75 * values - 1.375, "color"),
        touches=frozenset({"color"}),
    ),
)
