"""The gradient of bicubic reprojection: this package against PyTorch, and a training step with each.

    python scripts/timing/gradient.py
    python scripts/timing/gradient.py loss.theta=0.5    any overrides of train.py

Tests never assert speed.
"""

import os
import statistics
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from unittest.mock import patch

import torch
import torch.nn.functional as F
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate
from torch import Tensor

ROOT = Path(__file__).resolve().parents[2]
os.environ.setdefault("SUPERSAMPLING_ROOT", str(ROOT))

from supersampling.commands.resolvers import register  # noqa: E402
from supersampling.ops import interpolate  # noqa: E402
from supersampling.ops.cubic_gradient import bicubic_grid_sample  # noqa: E402
from supersampling.training.module import unroll  # noqa: E402

REPEATS = 15


def torch_grid_sample(image: Tensor, grid: Tensor) -> Tensor:
    return F.grid_sample(image, grid, mode="bicubic", padding_mode="border", align_corners=False)


def milliseconds(work: Callable[[], object]) -> float:
    work()
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return statistics.median(times) * 1e3


def main(overrides: list[str]) -> None:
    register()
    with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):
        cfg = compose("train", ["scene=atrium", *overrides])
    torch.set_num_threads(cfg.threads)
    batch, frames, side, scale = cfg.budget.batch, cfg.budget.frames, cfg.budget.crop, cfg.task.scale
    torch.manual_seed(0)
    image = torch.rand(batch, 4, side, side, requires_grad=True)
    grid = torch.rand(batch, side, side, 2) * 2.2 - 1.1
    grad = torch.rand_like(image)
    model, loss = instantiate(cfg.model), instantiate(cfg.loss)
    outputs, low = cfg.budget.counted + loss.previous, side // scale
    clip = {
        "color": torch.rand(batch, frames, 3, low, low),
        "depth": torch.rand(batch, frames, 1, low, low),
        "motion": torch.randn(batch, frames, 2, low, low) * 0.01,
        "jitter": torch.rand(batch, frames, 2) - 0.5,
    }
    target = torch.rand(batch, outputs, 3, side, side)

    def step() -> None:
        loss(unroll(model, clip, outputs), target, {"motion": clip["motion"][:, -outputs:]}).backward()

    print(f"batch {batch}, {frames} frames, crops of {side} pixels, {cfg.threads} threads")
    for name, sample in (("PyTorch", torch_grid_sample), ("package", bicubic_grid_sample)):
        compute_gradient = partial(torch.autograd.grad, sample(image, grid), image, grad, retain_graph=True)
        with patch.object(interpolate, "bicubic_grid_sample", sample):
            gradient, training = milliseconds(compute_gradient), milliseconds(step)
            print(f"{name:10s} gradient {gradient:6.2f} ms   training step {training:6.1f} ms")


if __name__ == "__main__":
    main(sys.argv[1:])
