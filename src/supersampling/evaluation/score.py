"""Scores a method on whole clips from their first frame, its state carried on; every frame's value is kept.

Clips are read frame by frame, so that memory does not grow with their length.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn
from tqdm import tqdm

from supersampling.data.clips import ClipName, WholeClips
from supersampling.data.store import spec_of
from supersampling.errors import UserError
from supersampling.evaluation.protocol import Protocol
from supersampling.frames import Frame
from supersampling.metrics.chosen import Metrics
from supersampling.metrics.prepare import HIGHEST_RADIANCE, bounded
from supersampling.metrics.suite import Moment
from supersampling.models.base import Upsampler


@dataclass(frozen=True)
class ScoredFrame:
    """One output with what it was made from, whole; all tensors ``(1, C, ., .)``.

    With a clip's last frame come ``clip_scores``, the values of the whole clip, and ``pictures`` of the method's state.
    """

    name: ClipName
    index: int
    length: int
    color: Tensor
    target: Tensor
    output: Tensor
    scores: dict[str, float]
    clip_scores: Mapping[str, float] = field(default_factory=dict)
    pictures: Mapping[str, Tensor] = field(default_factory=dict)

    @property
    def place(self) -> dict[str, str | int]:
        return {"scene": self.name.scene, "clip": self.name.clip, "frame": self.index}


def device_of(model: nn.Module) -> torch.device:
    """Where a model lives; a model without parameters or buffers lives on the host."""
    for tensor in (*model.parameters(), *model.buffers()):
        return tensor.device
    return torch.device("cpu")


@torch.inference_mode()
def score(
    model: Upsampler, metrics: Metrics, protocol: Protocol, clips: WholeClips, *, progress: bool = True
) -> Iterator[ScoredFrame]:
    """Run ``model`` over every clip and score every frame, in float32.

    ``clips`` has to carry colour and what the metrics read beside what the model reads: see `evaluation_requires`.
    """
    model.eval()
    # None: a terminal shows a bar, a log file nothing.
    disable = None if progress else True
    with tqdm(total=clips.frames, desc="evaluate", unit="frame", disable=disable, leave=False) as bar:
        for index in range(len(clips)):
            bar.set_postfix_str(f"{clips.name(index).scene} {clips.name(index).clip}")
            for frame in _score_clip(model, metrics, protocol, clips, index):
                bar.update()
                yield frame


def _score_clip(
    model: Upsampler, metrics: Metrics, protocol: Protocol, clips: WholeClips, index: int
) -> Iterator[ScoredFrame]:
    device, length = device_of(model), clips.length(index)
    state: Any = None
    previous: tuple[Tensor, Tensor] | None = None
    with metrics.of_clips.begin() as whole:
        for t, buffers in enumerate(clips.read_frames(index)):
            batch = {name: values[None].to(device) for name, values in buffers.items()}
            frame = Frame.from_clip(batch, 0)
            made, state = model(frame, state)
            target = batch["target"][:, 0]
            output = protocol.prepare(model.present(made, frame), target)
            moment = protocol.inner(
                Moment(
                    output,
                    target,
                    previous,
                    batch["motion"][:, 0] if "motion" in metrics.requires else None,
                    batch["motion_dual"][:, 0] if "motion_dual" in metrics.requires else None,
                    _radiance(model, made, frame, batch) if "target_radiance" in metrics.requires else None,
                    (batch["color"].shape[-2], batch["color"].shape[-1]),
                )
            )
            scores = metrics.of_frames(moment)
            if t >= protocol.warm_up:
                whole.add(moment)
            last = t == length - 1
            of_clip = whole.finish() if last else {}
            pictures = model.state_images(state) if last else {}
            previous = (output, target)
            yield ScoredFrame(
                clips.name(index),
                t,
                length,
                batch["color"][:, 0],
                target,
                output,
                scores,
                of_clip,
                pictures,
            )


def _radiance(model: Upsampler, made: Tensor, frame: Frame, batch: dict[str, Tensor]) -> tuple[Tensor, Tensor] | None:
    wanted, given = batch["target_radiance"][:, 0], model.radiance(made, frame)
    return None if given is None else (bounded(given, wanted, HIGHEST_RADIANCE), wanted)


def evaluation_requires(model: Upsampler, metrics: Metrics) -> frozenset[str]:
    """The buffers that scoring reads: the model's, the metrics', and the colour that crops show."""
    return model.requires | metrics.requires | {"color"}


def whole_clips(paths: list[Path], requires: frozenset[str], warm_up: int) -> WholeClips:
    """Whole clips with these buffers.

    Raises:
        UserError: a file without a target for every frame, or with clips that end within the warm-up.
    """
    for path in paths:
        spec = spec_of(path)
        if spec.targets < spec.frames:
            raise UserError(
                f"{path} lacks the targets of its clips' first frames, so it cannot be scored: name a test file."
            )
        if spec.frames <= warm_up:
            raise UserError(
                f"protocol.warm_up={warm_up} leaves nothing of the {spec.frames} frames of each clip of {path}: choose less."
            )
    return WholeClips(paths, requires)
