"""The spatio-temporal loss at the ends of theta."""

import copy
from collections.abc import Iterator, Sequence

import torch

from supersampling.losses.temporal import SpatioTemporal
from supersampling.models.base import Upsampler
from supersampling.stress.cell import Cell, judge
from supersampling.stress.clip import Clip, make_clip
from supersampling.stress.precision import Precision
from supersampling.stress.trial import LOSS_FRAMES
from supersampling.training.module import unroll

THETAS = 0.0, 0.999, 1.0
FRAMES = 5


def compute_loss(
    model: Upsampler, clip: Clip, theta: float, dtype: torch.dtype, precision: Precision | None, device: str
) -> tuple[float, bool]:
    """Return the loss of the last frames, and whether all gradients are finite."""
    model = copy.deepcopy(model).to(dtype).train()
    buffers = {name: values.float().to(device, dtype) for name, values in clip.items()}
    count = LOSS_FRAMES + 1
    last = {name: values[:, -count:] for name, values in buffers.items()}
    if precision is None:
        outputs = unroll(model, buffers, count)
    else:
        with precision.context(device):
            outputs = unroll(model, buffers, count)
    loss = SpatioTemporal(theta)(outputs, model.reference(last), last)
    loss.backward()
    gradients = [p.grad for p in model.parameters() if p.grad is not None]
    return float(loss.detach()), all(bool(g.isfinite().all()) for g in gradients)


def loss_cells(
    name: str, model: Upsampler, precisions: Sequence[Precision], size: tuple[int, int], device: str
) -> Iterator[Cell]:
    """Yield one cell per theta and precision, whose error is that of the loss; none for a model without parameters."""
    if not any(p.requires_grad for p in model.parameters()):
        return
    clip = make_clip(model.requires | model.compares | {"motion"}, FRAMES, *size, model.scale)
    for theta in THETAS:
        truth, _ = compute_loss(model, clip, theta, torch.float64, None, device)
        for precision in precisions:
            value, finite = compute_loss(model, clip, theta, torch.float32, precision, device)
            error = abs(value - truth) / max(1.0, abs(truth))
            gradient = "finite" if finite else "not finite"
            verdict, reason = judge(value == value, error, error, gradient, (precision.mean, precision.mean))
            yield Cell(
                model=name,
                extreme=f"theta/{theta:g}",
                precision=precision.name,
                size=f"{size[0]}x{size[1]}",
                scale=model.scale,
                frames=FRAMES,
                finite=value == value,
                largest=error,
                mean=error,
                gradient=gradient,
                value=value,
                truth=truth,
                tolerance=f"{precision.mean:g}",
                verdict=verdict,
                reason=reason,
                says=f"The spatio-temporal loss with theta = {theta:g}, and its gradients.",
            )
