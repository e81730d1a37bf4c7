"""The spatio-temporal loss at the ends of theta."""

import copy
from collections.abc import Iterator, Sequence

import torch

from supersampling.losses.temporal import SpatioTemporal
from supersampling.models.base import Upsampler
from supersampling.stress.cell import Cell, judge
from supersampling.stress.clip import Clip, clip_of
from supersampling.stress.precision import Precision
from supersampling.stress.trial import COUNTED
from supersampling.training.module import unroll

THETAS = 0.0, 0.999, 1.0
FRAMES = 5


def value_of(
    model: Upsampler, clip: Clip, theta: float, dtype: torch.dtype, precision: Precision | None, device: str
) -> tuple[float, bool]:
    """The loss of the last frames, and whether all gradients are finite."""
    model = copy.deepcopy(model).to(dtype).train()
    buffers = {name: values.float().to(device, dtype) for name, values in clip.items()}
    kept = COUNTED + 1
    last = {name: values[:, -kept:] for name, values in buffers.items()}
    if precision is None:
        outputs = unroll(model, buffers, kept)
    else:
        with precision.context(device):
            outputs = unroll(model, buffers, kept)
    value = SpatioTemporal(theta)(outputs, model.reference(last), last)
    value.backward()
    grads = [p.grad for p in model.parameters() if p.grad is not None]
    return float(value.detach()), all(bool(g.isfinite().all()) for g in grads)


def loss_cells(
    name: str, model: Upsampler, precisions: Sequence[Precision], size: tuple[int, int], device: str
) -> Iterator[Cell]:
    """A cell for each theta and precision; the error is that of the loss."""
    if not any(p.requires_grad for p in model.parameters()):
        return
    clip = clip_of(model.requires | model.compares | {"motion"}, FRAMES, *size, model.scale)
    for theta in THETAS:
        truth, _ = value_of(model, clip, theta, torch.float64, None, device)
        for precision in precisions:
            value, finite = value_of(model, clip, theta, torch.float32, precision, device)
            apart = abs(value - truth) / max(1.0, abs(truth))
            grads = "finite" if finite else "not finite"
            verdict, why = judge(value == value, apart, apart, grads, (precision.mean, precision.mean))
            yield Cell(
                name,
                f"theta/{theta:g}",
                precision.name,
                f"{size[0]}x{size[1]}",
                model.scale,
                FRAMES,
                finite=value == value,
                largest=apart,
                mean=apart,
                gradient=grads,
                value=value,
                truth=truth,
                tolerance=f"{precision.mean:g}",
                verdict=verdict,
                why=why,
                says=f"The spatio-temporal loss with theta = {theta:g}, and its gradients.",
            )
