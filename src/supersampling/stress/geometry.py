"""Depth, motion and jitter at the ends of their ranges and beyond."""

from collections.abc import Callable
from functools import partial

import torch
from torch import Tensor

from supersampling.stress.clip import Clip, change_buffers, fill_buffers
from supersampling.stress.extreme import Extreme

DEPTH = ("depth", "high_depth")
MOTION = ("motion", "motion_dual", "high_motion")
FAR = 40.0  # screens
LAST = 0.5 - 2.0**-25  # float32's last number below a half


def reverse_depth(clip: Clip) -> Clip:
    """Return the clip with depth 1 at the near plane and 0 at the far plane."""
    return change_buffers(clip, lambda values: 1.0 - values, *DEPTH)


def set_infinite_corner(clip: Clip) -> Clip:
    """Return the clip with an infinite depth in one corner and 0 elsewhere."""

    def change(values: Tensor) -> Tensor:
        changed = torch.zeros_like(values)
        changed[..., 0, 0] = float("inf")
        return changed

    return change_buffers(clip, change, *DEPTH)


def set_motion(clip: Clip, x: float, y: float) -> Clip:
    """Return the clip with the same motion everywhere, in low-resolution pixels."""
    height, width = clip["motion"].shape[-2:]
    motion = torch.tensor((x / width, y / height), dtype=torch.float64)[:, None, None]
    return change_buffers(clip, lambda values: motion.expand_as(values).clone(), *MOTION)


def set_discontinuous_motion(clip: Clip) -> Clip:
    """Return the clip with half an image to the right and half an image up, alternating from pixel to pixel."""

    def change(values: Tensor) -> Tensor:
        rows, columns = (torch.arange(n) for n in values.shape[-2:])
        odd = (rows[:, None] + columns) % 2 == 1
        right, up = (torch.tensor(v).to(values)[:, None, None] for v in ((0.5, 0.0), (0.0, -0.5)))
        return torch.where(odd, right, up).expand_as(values).clone()

    return change_buffers(clip, change, *MOTION)


def set_jitter(clip: Clip, x: float, y: float) -> Clip:
    """Return the clip with the same jitter in every frame, in low-resolution pixels."""
    jitter = torch.tensor((x, y), dtype=torch.float64)
    return change_buffers(clip, lambda values: jitter.expand_as(values).clone(), "jitter")


def _depth(name: str, meaning: str, change: float | Callable[[Clip], Clip]) -> Extreme:
    def fill(clip: Clip) -> Clip:
        return change(clip) if callable(change) else fill_buffers(clip, change, *DEPTH)

    return Extreme(f"depth/{name}", meaning, change=fill, touches=frozenset({"depth"}))


def _motion(name: str, meaning: str, x: float, y: float) -> Extreme:
    change = partial(set_motion, x=x, y=y)
    return Extreme(f"motion/{name}", meaning, change=change, touches=frozenset({"motion"}))


def _jitter(name: str, meaning: str, x: float, y: float) -> Extreme:
    change = partial(set_jitter, x=x, y=y)
    return Extreme(f"jitter/{name}", meaning, change=change, touches=frozenset({"jitter"}))


def _filled(name: str, meaning: str, value: float, *names: str) -> Extreme:
    """Return an extreme of one value, finite or not, in whole buffers of every frame."""

    def change(clip: Clip) -> Clip:
        return fill_buffers(clip, value, *names)

    return Extreme(name, meaning, change=change, touches=frozenset(names))


DEPTHS = (
    _depth("0", "Everything lies on the near plane.", 0.0),
    _depth("1", "Everything lies on the far plane; this is uniform depth as well.", 1.0),
    _depth("equal", "Everything lies at half the range.", 0.5),
    _depth("infinite", "Depth is infinite, out of its range.", float("inf")),
    _depth("reversed", "1 is near and 0 is far.", reverse_depth),
    _depth("reversed and infinite", "View depth as 1/x: infinite in a corner, 0 elsewhere.", set_infinite_corner),
)
MOTIONS = (
    _motion("zero", "Nothing moves.", 0.0, 0.0),
    _motion("half a pixel", "Half a low-resolution pixel on both axes.", 0.5, 0.5),
    _motion("half a target pixel", "An eighth of a low-resolution pixel: half a target pixel at 4x4.", 0.125, 0.125),
    _motion("one pixel", "Exactly one low-resolution pixel.", 1.0, 1.0),
    _motion("many screens", "40 images to the side.", FAR * 20, -FAR * 12),
    _motion("1e30", "A finite motion far beyond any image.", 1e30, -1e30),
    _filled("motion/NaN", "Motion is NaN in every frame.", float("nan"), *MOTION),
    _filled("motion/infinite", "Motion is infinite in every frame.", float("inf"), *MOTION),
    Extreme(
        "motion/discontinuous",
        "Neighbouring pixels move apart by half an image.",
        change=set_discontinuous_motion,
        touches=frozenset({"motion"}),
    ),
)
JITTERS = (
    _jitter("centre", "Samples at pixel centres.", 0.0, 0.0),
    _jitter("-0.5", "The first value of its range, on both axes.", -0.5, -0.5),
    _jitter("below 0.5", "The last value of its range.", LAST, LAST),
    _jitter("0.5", "Just out of its range.", 0.5, 0.5),
    _jitter("3", "Three pixels away.", 3.0, -3.0),
    _filled("jitter/NaN", "Jitter is NaN in every frame.", float("nan"), "jitter"),
)
