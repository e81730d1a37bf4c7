"""Depth, motion and jitter at their ends and beyond."""

import torch
from torch import Tensor

from supersampling.stress.clip import Clip, each
from supersampling.stress.extreme import Extreme

DEPTH = ("depth", "high_depth")
MOTION = ("motion", "motion_dual", "high_motion")
FAR = 40.0  # screens


def depth(name: str, says: str, value: float) -> Extreme:
    def change(clip: Clip) -> Clip:
        return each(clip, lambda v: torch.full_like(v, value), *DEPTH)

    return Extreme(f"depth/{name}", says, change, frozenset({"depth"}))


def reversed_depth(clip: Clip) -> Clip:
    """1 at the near plane, 0 at the far plane."""
    return each(clip, lambda v: 1.0 - v, *DEPTH)


def motion(name: str, says: str, pixels: tuple[float, float]) -> Extreme:
    """The same motion everywhere, in low-resolution pixels."""

    def change(clip: Clip) -> Clip:
        h, w = clip["motion"].shape[-2:]
        same = torch.tensor((pixels[0] / w, pixels[1] / h), dtype=torch.float64)[:, None, None]
        return each(clip, lambda v: same.expand_as(v).clone(), *MOTION)

    return Extreme(f"motion/{name}", says, change, frozenset({"motion"}))


def discontinuous(clip: Clip) -> Clip:
    """Half an image to the right and half an image up, pixel by pixel in turn."""

    def change(values: Tensor) -> Tensor:
        rows, columns = (torch.arange(n) for n in values.shape[-2:])
        odd = (rows[:, None] + columns) % 2 == 1
        right, up = (torch.tensor(v).to(values)[:, None, None] for v in ((0.5, 0.0), (0.0, -0.5)))
        return torch.where(odd, right, up).expand_as(values).clone()

    return each(clip, change, *MOTION)


def filled(name: str, says: str, value: float, *names: str) -> Extreme:
    """One value, finite or not, in whole buffers of every frame."""

    def change(clip: Clip) -> Clip:
        return each(clip, lambda v: torch.full_like(v, value), *names)

    return Extreme(name, says, change, frozenset(names))


def jitter(name: str, says: str, at: tuple[float, float]) -> Extreme:
    def change(clip: Clip) -> Clip:
        return each(clip, lambda v: torch.tensor(at, dtype=torch.float64).expand_as(v).clone(), "jitter")

    return Extreme(f"jitter/{name}", says, change, frozenset({"jitter"}))


LAST = 0.5 - 2.0**-25  # float32's last number below a half
DEPTHS = (
    depth("0", "Everything lies on the near plane.", 0.0),
    depth("1", "Everything lies on the far plane; equal everywhere, too.", 1.0),
    depth("equal", "Everything lies at half the range.", 0.5),
    depth("infinite", "Depth is infinite, out of its range.", float("inf")),
    Extreme("depth/reversed", "1 is near and 0 is far.", reversed_depth, frozenset({"depth"})),
    Extreme("depth/reversed and infinite", "View depth as 1/x: infinite in a corner, 0 elsewhere.",
            lambda clip: each(clip, _corner, *DEPTH), frozenset({"depth"})),
)  # fmt: skip


def _corner(values: Tensor) -> Tensor:
    changed = torch.zeros_like(values)
    changed[..., 0, 0] = float("inf")
    return changed


MOTIONS = (
    motion("zero", "Nothing moves.", (0.0, 0.0)),
    motion("half a pixel", "Half a low-resolution pixel on both axes.", (0.5, 0.5)),
    motion("half a target pixel", "An eighth of a low-resolution pixel: half a target pixel at 4x4.", (0.125, 0.125)),
    motion("one pixel", "Exactly one low-resolution pixel.", (1.0, 1.0)),
    motion("many screens", "40 images to the side.", (FAR * 20, -FAR * 12)),
    motion("1e30", "A finite motion that no image holds.", (1e30, -1e30)),
    filled("motion/NaN", "Motion is NaN in every frame.", float("nan"), *MOTION),
    filled("motion/infinite", "Motion is infinite in every frame.", float("inf"), *MOTION),
    Extreme("motion/discontinuous", "Neighbours move apart by half an image.", discontinuous, frozenset({"motion"})),
)  # fmt: skip
JITTERS = (
    jitter("centre", "Samples at pixel centres.", (0.0, 0.0)),
    jitter("-0.5", "The first of its range, on both axes.", (-0.5, -0.5)),
    jitter("below 0.5", "The last of its range.", (LAST, LAST)),
    jitter("0.5", "Just out of its range.", (0.5, 0.5)),
    jitter("3", "Three pixels away.", (3.0, -3.0)),
    filled("jitter/NaN", "Jitter is NaN in every frame.", float("nan"), "jitter"),
)
