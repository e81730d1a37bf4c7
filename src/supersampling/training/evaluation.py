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
from supersampling.metrics.suite import Moment, Suite
from supersampling.models.base import Upsampler

PLACE = ["scene", "clip", "frame"]


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
def score(
    model: Upsampler, metrics: Suite, clips: WholeClips, *, progress: bool = True
) -> Iterator[ScoredFrame]:
    """Run ``model`` over every clip and score every frame, in float32, not quantised.

    ``clips`` has to carry colour and what the metrics read beside what the model reads: see `evaluation_requires`.
    """
    model.eval()
    device = device_of(model)
    for name, clip in tqdm(clips, desc="evaluate", unit="clip", disable=not progress, leave=False):
        state: Any = None
        previous: tuple[Tensor, Tensor] | None = None
        length = len(clip["color"])
        batch = {key: value.unsqueeze(0).to(device) for key, value in clip.items()}
        for t in range(length):
            frame = Frame.of(batch, t)
            output, state = model(frame, state)
            output = model.present(output, frame)
            target = batch["target"][:, t]
            motion = batch["motion"][:, t] if "motion" in metrics.requires else None
            scores = metrics(Moment(output, target, previous, motion))
            previous = (output, target)
            yield ScoredFrame(name, t, length, batch["color"][:, t], target, output, scores)


def by_clip(frames: pd.DataFrame) -> pd.DataFrame:
    """Means over each clip's frames (frames without a value left out)."""
    means = frames.drop(columns="frame").groupby(["scene", "clip"], sort=False).mean()
    return means.reset_index()


def metrics_of(table: pd.DataFrame) -> list[str]:
    """The columns that are metrics."""
    return [str(name) for name in table.columns if name not in PLACE]


def summary(clips: pd.DataFrame) -> dict[str, float]:
    """``test/<metric>`` over all clips and ``test/<scene>/<metric>`` for each scene, its ``/`` written ``_``."""
    names = metrics_of(clips)
    means = {f"test/{m}": float(clips[m].mean()) for m in names}
    for scene, rows in clips.groupby("scene", sort=False):
        for m in names:
            means[f"test/{str(scene).replace('/', '_')}/{m}"] = float(rows[m].mean())
    return means


def evaluation_requires(model: Upsampler, metrics: Suite) -> frozenset[str]:
    """The buffers that scoring reads: the model's, the metrics', and the colour that crops show."""
    return model.requires | metrics.requires | {"color"}


def whole_clips(paths: list[Path], requires: frozenset[str]) -> WholeClips:
    """Whole clips with these buffers.

    Raises:
        UserError: a file without a target for every frame.
    """
    for path in paths:
        spec = spec_of(path)
        if spec.targets < spec.frames:
            raise UserError(
                f"{path} lacks the targets of its clips' first frames, so it cannot be scored: name a test file."
            )
    return WholeClips(paths, requires)
