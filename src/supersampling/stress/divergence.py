"""The divergence of cubic reprojection (Swensen 2021, 6.1.1): reproduced, measured, and compared with `gain`."""

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
from supersampling.stress.cell import Cell, Verdict
from supersampling.stress.clip import make_frame, make_inputs
from supersampling.stress.gain import Kernel

StageFactory = Callable[[], Reproject]
KERNELS: tuple[tuple[Kernel, StageFactory], ...] = (
    (Kernel("bicubic9", 9, -0.75), partial(Bicubic9, -0.75)),
    (Kernel("bicubic9_a50", 9, -0.5), partial(Bicubic9, -0.5)),
    (Kernel("bicubic5", 5, -0.75), partial(Bicubic5, -0.75)),
    (Kernel("bicubic5_a50", 5, -0.5), partial(Bicubic5, -0.5)),
    (Kernel("bilinear", 2), Bilinear),
)
SIDE, FRAMES = 64, 600
TOO_LARGE = 1e200  # a roll-out stops before float64 overflows
SMALL = 1e-30  # magnitude at which an error starts that must not overflow
GROWTH_TOLERANCE = 0.003  # of a growth per frame, below the closed form: a 64-pixel image does not contain every wave
EIGHT_BITS = 8 / 255  # 8 steps of 8 bits, a visible error


def uniform_motion(pixels: tuple[float, float], size: int) -> Tensor:
    """Return one motion everywhere, ``(1, 2, size, size)``."""
    return (torch.tensor(pixels, dtype=torch.float64) / size).view(1, 2, 1, 1).expand(1, 2, size, size).clone()


def growth(stage: Reproject, fraction: float, side: int = SIDE, frames: int = FRAMES) -> tuple[float, int]:
    """Return the growth per frame of an error in a history that moves to and fro by ``fraction`` pixels.

    The number of frames that were run comes second. In float64, from noise. Content stays in the image, so that only
    the kernel acts. The growth is the slope of the logarithm of the magnitude over the last half of the frames.
    """
    generator = torch.Generator().manual_seed(0)
    history = SMALL * torch.randn(1, 1, side, side, generator=generator, dtype=torch.float64)
    motion = uniform_motion((fraction, fraction), side)
    logs = []
    for t in range(frames):
        history = stage(history, motion if t % 2 == 0 else -motion)
        magnitude = float(history.square().mean().sqrt())
        if magnitude == 0.0 or magnitude > TOO_LARGE:
            break
        logs.append(math.log(magnitude))
    half = len(logs) // 2
    slope = np.polynomial.Polynomial.fit(np.arange(half, len(logs)), logs[half:], 1).convert().coef[1:].sum()
    return math.exp(float(slope)), len(logs)


def directed_growth(stage: Reproject, fraction: float, side: int = SIDE) -> float:
    """Return the largest factor by which noise in the middle grows while it moves out of the image."""
    generator = torch.Generator().manual_seed(0)
    history = torch.zeros(1, 1, side, side, dtype=torch.float64)
    middle = slice(side // 4, -side // 4)
    noise = torch.randn(history[..., middle, middle].shape, generator=generator, dtype=torch.float64)
    history[..., middle, middle] = noise
    initial, largest = float(history.abs().max()), 0.0
    motion = uniform_motion((fraction, 0.0), side)
    for _ in range(int(side / max(fraction, 1e-3))):
        history = stage(history, motion)
        largest = max(largest, float(history.abs().max()))
    return largest / initial


def tus_error(
    make_stage: StageFactory, rectify: Rectify, alpha: float, frames: int, size: int = 16
) -> tuple[float, int]:
    """Return TUS's final error on a scene that shakes by half a target pixel, and the frame where it becomes visible.

    The error is the RMS difference from the output of the second frame; it is visible above 8 steps of 8 bits (-1:
    never).
    """
    scale = 2
    model = TUS(scale, 0.8, alpha, make_stage(), rectify, NoDilation(), JitterAligned()).eval()
    inputs = make_inputs(model.requires, 0, size, size, scale, moving=False)
    inputs["jitter"] = torch.zeros_like(inputs["jitter"])
    motion = torch.full_like(inputs["motion"], 0.5 / (size * scale))
    state = reference = None
    error, visible = 0.0, -1
    with torch.no_grad():
        for t in range(frames):
            frame = make_frame({**inputs, "motion": motion if t % 2 else -motion}, torch.float32, "cpu")
            output, state = model(frame, state)
            reference = output if t == 1 else reference
            if reference is not None and t % 2 == 1:
                error = float((output - reference).square().mean().sqrt())
                visible = t if visible < 0 and error > EIGHT_BITS else visible
    return error, visible


def divergence_cells(frames: int) -> Iterator[Cell]:
    """Yield the growth per frame against the closed form, and TUS's error over ``frames`` frames with rectification."""
    for kernel, make_stage in KERNELS:
        name = f"reproject={kernel.name}"
        stage = make_stage()
        for cell in (*_growth_cells(kernel, stage), _directed_cell(kernel, stage), *_tus_cells(make_stage, frames)):
            yield replace(cell, model=name)


def _growth_cells(kernel: Kernel, stage: Reproject) -> Iterator[Cell]:
    value, frames = growth(stage, 0.0)
    cell = _cell("static", frames, value, 1.0, "Growth per frame of a history that does not move.")
    yield replace(cell, verdict=_verdict(abs(value - 1.0) < 1e-12), tolerance="1")
    for fraction in (0.5, 0.25):
        value, frames = growth(stage, fraction)
        truth = kernel.gain(fraction, fraction)
        meaning = (
            f"Growth per frame of an error that moves to and fro by {fraction:g} pixels; the kernel's largest gain."
        )
        good = value <= truth * (1 + 1e-9) and (truth <= 1.0 + 1e-9 or abs(value - truth) <= GROWTH_TOLERANCE)
        yield replace(
            _cell(f"to and fro {fraction:g}", frames, value, truth, meaning),
            verdict=_verdict(good),
            tolerance=f"{GROWTH_TOLERANCE:g} below the gain",
            reason=f"grows {100 * (value - 1):.2g} % per frame" if value > 1.0 + 1e-6 else "",
        )


def _directed_cell(kernel: Kernel, stage: Reproject) -> Cell:
    value, truth = directed_growth(stage, 0.5), kernel.gain(0.5, 0.0) ** (2 * SIDE)
    meaning = (
        "Largest factor while noise leaves the image, half a pixel per frame; the gain to the power of the frames."
    )
    cell = _cell("one way 0.5", 2 * SIDE, value, truth, meaning)
    return replace(cell, verdict=_verdict(value <= truth), tolerance="the gain's power")


def _tus_cells(make_stage: StageFactory, frames: int) -> Iterator[Cell]:
    for name, rectify in (("none", NoRectification()), ("clamp_rgb", Clamp(RGB()))):
        for alpha in (0.0, 1.0):
            value, visible = tus_error(make_stage, rectify, alpha, frames)
            meaning = f"TUS, rectify={name}, alpha={alpha:g}, shaken by half a target pixel: RMS difference at the end."
            yield replace(
                _cell(f"TUS {name} alpha {alpha:g}", frames, value, math.nan, meaning),
                size="32x32",
                precision="float32",
                verdict=_verdict(value <= 1.0),
                tolerance="1, the range",
                reason="" if visible < 0 else f"more than 8 steps of 8 bits from frame {visible} on",
            )


def _verdict(good: bool) -> Verdict:
    return "holds" if good else "fails"


def _cell(detail: str, frames: int, value: float, truth: float, meaning: str) -> Cell:
    return Cell(
        model="",
        extreme=f"divergence/{detail}",
        precision="float64",
        size=f"{SIDE}x{SIDE}",
        scale=1,
        frames=frames,
        finite=math.isfinite(value),
        value=value,
        truth=truth,
        says=meaning,
    )
