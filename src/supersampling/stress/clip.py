"""The clip that every extreme starts from: a smooth scene in closed form, seen by a camera that circles."""

import math
from collections.abc import Callable, Iterable, Mapping

import torch
import torch.nn.functional as F
from torch import Tensor

from supersampling.frames import BUFFERS, Buffer, Frame
from supersampling.render.jitter import van_der_corput

Clip = dict[str, Tensor]
"""Buffers by name, ``(B, T, C, h, w)`` or ``(B, T, 2)``."""

RADIUS, PERIOD = (
    3.0,
    40.0,
)  # of the camera's circle, low-resolution pixels and frames: half a pixel a frame, nothing leaves for good
JITTERS = 16
CYCLE = math.lcm(JITTERS, int(PERIOD))  # frames after which the clip begins again, without a jump
_PLACE = {name: 7 * k for k, name in enumerate(("color", "light", "material", "emission", "normal"))}


def wave(x: Tensor, y: Tensor, k: float) -> Tensor:
    """In [0.1, 0.9], another one for every ``k``; ``x y`` in low-resolution pixels."""
    first = torch.sin((0.55 + 0.06 * (k % 5)) * x + (0.37 - 0.05 * (k % 3)) * y + 1.3 * k)
    second = torch.cos((0.29 - 0.07 * (k % 4)) * x - (0.61 + 0.04 * (k % 7)) * y + 0.7 * k)
    return 0.5 + 0.2 * first + 0.2 * second


def jitter_of(t: int) -> tuple[float, float]:
    """(x, y) of a frame, in [-0.5, 0.5): Halton(2, 3), 16 long."""
    n = t % JITTERS + 1
    return van_der_corput(n, 2) - 0.5, van_der_corput(n, 3) - 0.5


def camera(t: int, moving: bool) -> tuple[float, float]:
    """Where the scene lies at frame ``t``, low-resolution pixels."""
    angle = 2.0 * math.pi * t / PERIOD
    return (RADIUS * math.cos(angle), RADIUS * math.sin(angle)) if moving else (0.0, 0.0)


def inputs_at(
    names: Iterable[str], t: int, width: int, height: int, scale: int, batch: int = 1, moving: bool = True
) -> Clip:
    """Frame ``t`` of the clip, float64, ``(B, C, h, w)``: the buffers called ``names``, references among them.

    Item ``k`` of a batch shows the scene elsewhere. Radiance is material times light plus emission; motion is exact.
    """
    then, now = camera(t - 1, moving), camera(t, moving)
    jitter = torch.tensor(jitter_of(t), dtype=torch.float64).expand(batch, 2).clone()
    made: Clip = {}
    for name in sorted(names):
        buffer = BUFFERS[name]
        if name == "jitter":
            made[name] = jitter
            continue
        fine = scale if buffer.resolution == "high" else 1
        offset = (0.0, 0.0) if buffer.resolution == "high" else tuple(jitter[0].tolist())
        x, y = _places(width * fine, height * fine, 1.0 / fine, offset, now, batch)
        shift = ((then[0] - now[0]) / width, (then[1] - now[1]) / height)
        made[name] = _values(buffer, x, y, shift)
    return made


def _places(
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
        apart = 0.02 * (_waves(x, y, 40, 2) - 0.5) if name == "motion_dual" else 0.0
        return torch.tensor(shift, dtype=x.dtype)[:, None, None].expand(len(x), 2, *x.shape[1:]) + apart
    if name == "radiance":
        light = 2.0 * _waves(x, y, _PLACE["light"], 3) * _waves(x, y, _PLACE["material"], 3)
        return light + 0.1 * _waves(x, y, _PLACE["emission"], 3)
    if name == "normal":
        return F.normalize(_waves(x, y, _PLACE["normal"], 3) - 0.4, dim=1)
    values = _waves(x, y, _PLACE.get("color" if name == "target" else name, 50 + len(name)), buffer.channels)
    return 0.1 * values if name == "emission" else values


def clip_of(
    names: Iterable[str],
    frames: int,
    width: int,
    height: int,
    scale: int,
    batch: int = 1,
    moving: bool = True,
) -> Clip:
    """The clip's first frames, ``(B, T, ...)``, float64."""
    names = list(names)
    every = [inputs_at(names, t, width, height, scale, batch, moving) for t in range(frames)]
    return {name: torch.stack([one[name] for one in every], dim=1) for name in names}


def frame_of(inputs: Mapping[str, Tensor], dtype: torch.dtype, device: str) -> Frame:
    """A frame of what `inputs_at` gave: rounded to float32, as all buffers are, and then in ``dtype``."""
    references = ("target", "target_radiance")
    read = {name: values.float().to(device, dtype) for name, values in inputs.items() if name not in references}
    return Frame(**read)


def each(clip: Clip, change: Callable[[Tensor], Tensor], *names: str) -> Clip:
    """The clip with ``change`` applied to those of the buffers that are there."""
    return {name: change(values) if name in names else values for name, values in clip.items()}
