"""The divergence of cubic reprojection that Swensen 2021, 6.1.1, reports: reproduced, measured, and compared with `gain`."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np
import torch
from torch import Tensor

from supersampling.models.tus import TUS
from supersampling.stages.colour_space import RGB
from supersampling.stages.dilate import NoDilation
from supersampling.stages.pad import JitterAligned
from supersampling.stages.rectify import Clamp, NoRectification, Rectify
from supersampling.stages.reproject import Bicubic5, Bicubic9, Bilinear, Reproject
from supersampling.stress.cell import Cell
from supersampling.stress.clip import frame_of, inputs_at
from supersampling.stress.gain import Kernel

Make = Callable[[], Reproject]
KERNELS: tuple[tuple[Kernel, Make], ...] = (
    (Kernel("bicubic9", 9, -0.75), partial(Bicubic9, -0.75)),
    (Kernel("bicubic9_a50", 9, -0.5), partial(Bicubic9, -0.5)),
    (Kernel("bicubic5", 5, -0.75), partial(Bicubic5, -0.75)),
    (Kernel("bicubic5_a50", 5, -0.5), partial(Bicubic5, -0.5)),
    (Kernel("bilinear", 2), Bilinear),
)
SIDE, FRAMES = 64, 600
TOO_LARGE = 1e200  # float64's end is not waited for
SMALL = 1e-30  # where an error is begun that must not reach the end
AGREES = 0.003  # of a growth per frame with the closed form: an image of 64 pixels does not hold every wave


def motion_of(pixels: tuple[float, float], size: int) -> Tensor:
    """``(1, 2, size, size)`` of one motion everywhere."""
    return (torch.tensor(pixels, dtype=torch.float64) / size).view(1, 2, 1, 1).expand(1, 2, size, size).clone()


def growth(stage: Reproject, fraction: float, side: int = SIDE, frames: int = FRAMES) -> tuple[float, int]:
    """Growth per frame of an error in a history that moves to and fro by ``fraction`` pixels, and how many frames were run.

    In float64, from noise. Content stays in the image, so that nothing but the kernel acts. The slope of the logarithm of the
    magnitude over the last half of the frames.
    """
    generator = torch.Generator().manual_seed(0)
    history = SMALL * torch.randn(1, 1, side, side, generator=generator, dtype=torch.float64)
    there = motion_of((fraction, fraction), side)
    logs = []
    for t in range(frames):
        history = stage(history, there if t % 2 == 0 else -there)
        size = float(history.square().mean().sqrt())
        if size == 0.0 or size > TOO_LARGE:
            break
        logs.append(math.log(size))
    half = len(logs) // 2
    slope = np.polynomial.Polynomial.fit(np.arange(half, len(logs)), logs[half:], 1).convert().coef[1:].sum()
    return math.exp(float(slope)), len(logs)


def one_way(stage: Reproject, fraction: float, side: int = SIDE) -> float:
    """The largest factor by which noise in the middle grows while it moves out of the image."""
    generator = torch.Generator().manual_seed(0)
    history = torch.zeros(1, 1, side, side, dtype=torch.float64)
    middle = slice(side // 4, -side // 4)
    noise = torch.randn(history[..., middle, middle].shape, generator=generator, dtype=torch.float64)
    history[..., middle, middle] = noise
    first, largest = float(history.abs().max()), 0.0
    there = motion_of((fraction, 0.0), side)
    for _ in range(int(side / max(fraction, 1e-3))):
        history = stage(history, there)
        largest = max(largest, float(history.abs().max()))
    return largest / first


def tus_error(make: Make, rectify: Rectify, alpha: float, frames: int, size: int = 16) -> tuple[float, int]:
    """TUS on a scene that shakes by half a target pixel: the RMS difference from what it showed in its second frame, and the
    frame at which that passed 8 steps of 8 bits (-1: never)."""
    scale = 2
    model = TUS(scale, 0.8, alpha, make(), rectify, NoDilation(), JitterAligned()).eval()
    inputs = inputs_at(model.requires, 0, size, size, scale, moving=False)
    inputs["jitter"] = torch.zeros_like(inputs["jitter"])
    there = torch.full_like(inputs["motion"], 0.5 / (size * scale))
    state = first = None
    apart, passed = 0.0, -1
    with torch.no_grad():
        for t in range(frames):
            frame = frame_of({**inputs, "motion": there if t % 2 else -there}, torch.float32, "cpu")
            output, state = model(frame, state)
            first = output if t == 1 else first
            if first is not None and t % 2 == 1:
                apart = float((output - first).square().mean().sqrt())
                passed = t if passed < 0 and apart > 8 / 255 else passed
    return apart, passed


def divergence_cells(frames: int) -> Iterator[Cell]:
    """Growth per frame against the closed form, and what rectification does about it; ``frames`` of each TUS."""
    for kernel, make in KERNELS:
        name = f"reproject={kernel.name}"
        for cell in (*_growths(kernel, make()), _one_way(kernel, make()), *_tus(make, frames)):
            yield replace(cell, model=name)


def _growths(kernel: Kernel, stage: Reproject) -> Iterator[Cell]:
    value, ran = growth(stage, 0.0)
    says = "Growth per frame of a history that stands still."
    yield _cell("static", ran, value, 1.0, abs(value - 1.0) < 1e-12, "1", says)
    for fraction in (0.5, 0.25):
        value, ran = growth(stage, fraction)
        truth = kernel.gain(fraction, fraction)
        says = f"Growth per frame of an error that moves to and fro by {fraction:g} pixels; the kernel's largest gain."
        good = value <= truth * (1 + 1e-9) and (truth <= 1.0 + 1e-9 or abs(value - truth) <= AGREES)
        why = f"grows {100 * (value - 1):.2g} % a frame" if value > 1.0 + 1e-6 else ""
        cell = _cell(f"to and fro {fraction:g}", ran, value, truth, good, f"{AGREES:g} below the gain", says)
        yield replace(cell, why=why)


def _one_way(kernel: Kernel, stage: Reproject) -> Cell:
    value, truth = one_way(stage, 0.5), kernel.gain(0.5, 0.0) ** (2 * SIDE)
    says = (
        "Largest factor while noise moves out of the image, half a pixel a frame; the gain to the power of the frames."
    )
    return _cell("one way 0.5", 2 * SIDE, value, truth, value <= truth, "the gain's power", says)


def _tus(make: Make, frames: int) -> Iterator[Cell]:
    for name, rectify in (("none", NoRectification()), ("clamp_rgb", Clamp(RGB()))):
        for alpha in (0.0, 1.0):
            value, passed = tus_error(make, rectify, alpha, frames)
            says = f"TUS, rectify={name}, alpha={alpha:g}, shaken by half a target pixel: RMS difference at the end."
            cell = _cell(f"TUS {name} alpha {alpha:g}", frames, value, math.nan, value <= 1.0, "1, the range", says)
            why = "" if passed < 0 else f"more than 8 steps of 8 bits from frame {passed} on"
            yield replace(cell, size="32x32", precision="float32", why=why)


def _cell(what: str, frames: int, value: float, truth: float, good: bool, tolerance: str, says: str) -> Cell:
    return Cell(
        model="",
        extreme=f"divergence/{what}",
        precision="float64",
        size=f"{SIDE}x{SIDE}",
        scale=1,
        frames=frames,
        finite=math.isfinite(value),
        value=value,
        truth=truth,
        tolerance=tolerance,
        verdict="holds" if good else "fails",
        says=says,
    )
