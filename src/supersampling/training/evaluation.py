"""Scores a method on whole clips from their first frame, its state carried on; every frame's value is kept."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
import torch
from torch import Tensor, nn
from tqdm import tqdm

from supersampling.data.clips import ClipName, WholeClips
from supersampling.data.store import spec_of
from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.metrics.image import mssim_thesis, psnr, ssim_gauss11
from supersampling.metrics.temporal import spatial_loss, temporal_loss
from supersampling.models.base import Upsampler

METRICS = ("psnr", "ssim", "mssim_thesis", "spatial", "temporal")


@dataclass(frozen=True)
class ScoredFrame:
    """One output with what it was made from; all tensors ``(1, C, ., .)``."""

    name: ClipName
    index: int
    length: int
    color: Tensor
    target: Tensor
    output: Tensor
    scores: dict[str, float]

    @property
    def row(self) -> dict[str, str | int | float]:
        return {"scene": self.name.scene, "clip": self.name.clip, "frame": self.index, **self.scores}


def device_of(model: nn.Module) -> torch.device:
    """Where a model lives; a model without parameters or buffers lives on the host."""
    for tensor in (*model.parameters(), *model.buffers()):
        return tensor.device
    return torch.device("cpu")


@torch.inference_mode()
def score(model: Upsampler, clips: WholeClips, *, progress: bool = True) -> Iterator[ScoredFrame]:
    """Run ``model`` over every clip and score every frame.

    Scores: ``psnr`` in dB, ``ssim`` (Gaussian 11, sigma 1.5), ``mssim_thesis``, ``spatial`` and ``temporal`` (the two losses
    of DLCTUS table 10; the first frame of a clip has no temporal one: NaN). Outputs are scored in float32, not quantised.
    ``clips`` has to carry motion beside what the model reads.
    """
    model.eval()
    device = device_of(model)
    for name, clip in tqdm(clips, desc="evaluate", unit="clip", disable=not progress, leave=False):
        state: Any = None
        previous: tuple[Tensor, Tensor] | None = None
        length = len(clip["color"])
        batch = {key: value.unsqueeze(0).to(device) for key, value in clip.items()}
        for t in range(length):
            output, state = model(Frame.of(batch, t), state)
            target = batch["target"][:, t]
            scores = {
                "psnr": psnr(output, target).item(),
                "ssim": ssim_gauss11(output, target).item(),
                "mssim_thesis": mssim_thesis(output, target).item(),
                "spatial": float("nan"),
                "temporal": float("nan"),
            }
            if previous is not None:
                motion = batch["motion"][:, t]
                scores["spatial"] = spatial_loss(output, target, *previous, motion).item()
                scores["temporal"] = temporal_loss(output, target, *previous, motion).item()
            previous = (output, target)
            yield ScoredFrame(name, t, length, batch["color"][:, t], target, output, scores)


def by_clip(frames: pd.DataFrame) -> pd.DataFrame:
    """Means over each clip's frames (frames without a value left out)."""
    return frames.groupby(["scene", "clip"], sort=False)[list(METRICS)].mean().reset_index()


def summary(clips: pd.DataFrame) -> dict[str, float]:
    """``test/<metric>`` over all clips and ``test/<scene>/<metric>`` for each scene, its ``/`` written ``_``."""
    means = {f"test/{m}": float(clips[m].mean()) for m in METRICS}
    for scene, rows in clips.groupby("scene", sort=False):
        for m in METRICS:
            means[f"test/{str(scene).replace('/', '_')}/{m}"] = float(rows[m].mean())
    return means


def whole_clips(paths: list[Path], model: Upsampler) -> WholeClips:
    """Whole clips with what scoring a model reads: its inputs, and colour and motion for crops and the temporal loss.

    Raises:
        UserError: a file without a target for every frame.
    """
    for path in paths:
        spec = spec_of(path)
        if spec.targets < spec.frames:
            raise UserError(
                f"{path} lacks the targets of its clips' first frames, so it cannot be scored: name a test file."
            )
    return WholeClips(paths, model.requires | {"color", "motion"})
