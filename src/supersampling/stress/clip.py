"""The plain clip that every extreme starts from: a smooth scene in closed form and a camera that moves in a circle."""

import math
from collections.abc import Callable, Iterable, Mapping

import torch
import torch.nn.functional as F
from torch import Tensor

from supersampling.frames import BUFFERS, Buffer, Frame
from supersampling.render.jitter import van_der_corput

Clip = dict[str, Tensor]
"""Buffers by name, ``(B, T, C, h, w)`` or ``(B, T, 2)``."""

# Of the camera's circle, in low-resolution pixels and frames: half a pixel per frame, and no content leaves for good.
RADIUS, PERIOD = 3.0, 40.0
JITTERS = 16
CYCLE = math.lcm(JITTERS, int(PERIOD))  # frames after which the clip begins again, without a jump
_WAVES = {name: 7 * k for k, name in enumerate(("color", "light", "material", "emission", "normal"))}


def wave(x: Tensor, y: Tensor, k: float) -> Tensor:
    """Return values in [0.1, 0.9], a different wave for each ``k``; ``x`` and ``y`` are in low-resolution pixels."""
    first = torch.sin((0.55 + 0.06 * (k % 5)) * x + (0.37 - 0.05 * (k % 3)) * y + 1.3 * k)
    second = torch.cos((0.29 - 0.07 * (k % 4)) * x - (0.61 + 0.04 * (k % 7)) * y + 0.7 * k)
    return 0.5 + 0.2 * first + 0.2 * second


def jitter_at(t: int) -> tuple[float, float]:
    """Return the jitter (x, y) of frame ``t``, in [-0.5, 0.5): Halton(2, 3) with a period of 16."""
    n = t % JITTERS + 1
    return van_der_corput(n, 2) - 0.5, van_der_corput(n, 3) - 0.5


def camera(t: int, moving: bool) -> tuple[float, float]:
    """Return the position of the scene in frame ``t``, in low-resolution pixels."""
    angle = 2.0 * math.pi * t / PERIOD
    return (RADIUS * math.cos(angle), RADIUS * math.sin(angle)) if moving else (0.0, 0.0)


def make_inputs(
    names: Iterable[str], t: int, width: int, height: int, scale: int, batch: int = 1, moving: bool = True
) -> Clip:
    """Return the buffers called ``names``, which may include references, of frame ``t``: float64, ``(B, C, h, w)``.

    Each item of a batch shows another place of the scene. Radiance is material times light plus emission; motion is
    exact.
    """
    before, now = camera(t - 1, moving), camera(t, moving)
    jitter = torch.tensor(jitter_at(t), dtype=torch.float64).expand(batch, 2).clone()
    inputs: Clip = {}
    for name in sorted(names):
        buffer = BUFFERS[name]
        if name == "jitter":
            inputs[name] = jitter
            continue
        factor = scale if buffer.resolution == "high" else 1
        offset = (0.0, 0.0) if buffer.resolution == "high" else tuple(jitter[0].tolist())
        x, y = _positions(width * factor, height * factor, 1.0 / factor, offset, now, batch)
        shift = ((before[0] - now[0]) / width, (before[1] - now[1]) / height)
        inputs[name] = _values(buffer, x, y, shift)
    return inputs


def _positions(
    columns: int, rows: int, step: float, offset: tuple[float, ...], camera: tuple[float, float], batch: int
) -> tuple[Tensor, Tensor]:
    item = 17.0 * torch.arange(batch, dtype=torch.float64)[:, None, None]
    x = (torch.arange(columns, dtype=torch.float64) + 0.5) * step + offset[0] - camera[0] + item
    y = (torch.arange(rows, dtype=torch.float64)[:, None] + 0.5) * step + offset[1] - camera[1] + item
    return x.expand(batch, rows, columns), y.expand(batch, rows, columns)


def _waves(x: Tensor, y: Tensor, first: int, count: int) -> Tensor:
    return torch.stack([wave(x, y, k) for k in range(first, first + count)], dim=1)


def _values(buffer: Buffer, x: Tensor, y: Tensor, shift: tuple[float, float]) -> Tensor:
    name = buffer.name.removeprefix("high_").removeprefix("target_")
    if name in ("motion", "motion_dual"):
        offset = 0.02 * (_waves(x, y, 40, 2) - 0.5) if name == "motion_dual" else 0.0
        return torch.tensor(shift, dtype=x.dtype)[:, None, None].expand(len(x), 2, *x.shape[1:]) + offset
    if name == "radiance":
        light = 2.0 * _waves(x, y, _WAVES["light"], 3) * _waves(x, y, _WAVES["material"], 3)
        return light + 0.1 * _waves(x, y, _WAVES["emission"], 3)
    if name == "normal":
        return F.normalize(_waves(x, y, _WAVES["normal"], 3) - 0.4, dim=1)
    values = _waves(x, y, _WAVES.get("color" if name == "target" else name, 50 + len(name)), buffer.channels)
    return 0.1 * values if name == "emission" else values


def make_clip(
    names: Iterable[str], frames: int, width: int, height: int, scale: int, batch: int = 1, moving: bool = True
) -> Clip:
    """Return the first frames of the clip, ``(B, T, ...)``, float64."""
    names = list(names)
    inputs = [make_inputs(names, t, width, height, scale, batch, moving) for t in range(frames)]
    return {name: torch.stack([buffers[name] for buffers in inputs], dim=1) for name in names}


def make_frame(inputs: Mapping[str, Tensor], dtype: torch.dtype, device: str) -> Frame:
    """Return a frame of the buffers of `make_inputs`, rounded to float32, as all buffers are, and then in ``dtype``."""
    references = ("target", "target_radiance")
    buffers = {name: values.float().to(device, dtype) for name, values in inputs.items() if name not in references}
    return Frame(**buffers)


def change_buffers(clip: Clip, change: Callable[[Tensor], Tensor], *names: str) -> Clip:
    """Return the clip with ``change`` applied to the named buffers, of which those that the clip lacks are ignored."""
    return {name: change(values) if name in names else values for name, values in clip.items()}


def fill_buffers(clip: Clip, value: float, *names: str) -> Clip:
    """Return the clip with one value in the whole of the named buffers."""
    return change_buffers(clip, lambda values: torch.full_like(values, value), *names)
