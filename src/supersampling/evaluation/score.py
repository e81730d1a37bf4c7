"""Scoring of a method on whole clips, with its state carried from the first frame on; every frame has its values.

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
from supersampling.data.dataset_file import read_spec
from supersampling.errors import UserError
from supersampling.evaluation.protocol import Protocol
from supersampling.frames import Frame
from supersampling.metrics.base import Moment
from supersampling.metrics.prepare import HIGHEST_RADIANCE, bounded
from supersampling.metrics.selection import Metrics
from supersampling.models.base import Upsampler

PICTURED_FRAMES = 8  # at the end of a scene's first clip


@dataclass(frozen=True, kw_only=True)
class ScoredFrame:
    """The output for one frame with its input, target and scores; images are whole, all tensors ``(1, C, ., .)``.

    A clip's last frame also has ``clip_scores``, the values of the whole clip, and ``pictures`` of the method's state
    and of what it computes. The last frames of a scene's first clip have the ``pictures`` named in ``over_time``.
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
    over_time: frozenset[str] = frozenset()
    jitter: Tensor = field(default_factory=lambda: torch.zeros(1, 2))

    @property
    def place(self) -> dict[str, str | int]:
        return {"scene": self.name.scene, "clip": self.name.clip, "frame": self.index}


def model_device(model: nn.Module) -> torch.device:
    """Return the device of a model; that of a model without parameters or buffers is the host."""
    for tensor in (*model.parameters(), *model.buffers()):
        return tensor.device
    return torch.device("cpu")


@torch.inference_mode()
def score(
    model: Upsampler, metrics: Metrics, protocol: Protocol, clips: WholeClips, *, progress: bool = True
) -> Iterator[ScoredFrame]:
    """Run ``model`` over every clip, score every frame in float32, and yield the frames.

    ``clips`` must have the buffers of `evaluation_requires`.
    """
    model.eval()
    # None: tqdm shows a bar in a terminal and nothing in a log file.
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
    device, length = model_device(model), clips.length(index)
    state: Any = None
    previous: tuple[Tensor, Tensor] | None = None
    with metrics.clips.begin() as scoring:
        for t, buffers in enumerate(clips.read_frames(index)):
            batch = {name: values[None].to(device) for name, values in buffers.items()}
            frame = Frame.from_clip(batch, 0)
            last = t == length - 1
            pictures = {}
            if clips.name(index).clip == 0 and (last or (model.over_time and t >= length - PICTURED_FRAMES)):
                images = model.pictured(frame, state)
                pictures = {name: image for name, image in images.items() if last or name in model.over_time}
            upsampled, state = model(frame, state)
            target = batch["target"][:, 0]
            output = protocol.prepare(model.present(upsampled, frame), target)
            moment = protocol.inner(
                Moment(
                    output=output,
                    target=target,
                    previous=previous,
                    motion=batch["motion"][:, 0] if "motion" in metrics.requires else None,
                    motion_dual=batch["motion_dual"][:, 0] if "motion_dual" in metrics.requires else None,
                    radiance=_radiance(model, upsampled, frame, batch)
                    if "target_radiance" in metrics.requires
                    else None,
                    size=(batch["color"].shape[-2], batch["color"].shape[-1]),
                )
            )
            scores = metrics.frames(moment)
            if t >= protocol.warm_up:
                scoring.add(moment)
            previous = (output, target)
            yield ScoredFrame(
                name=clips.name(index),
                index=t,
                length=length,
                color=batch["color"][:, 0],
                target=target,
                output=output,
                scores=scores,
                clip_scores=scoring.finish() if last else {},
                pictures={**pictures, **model.state_images(state)} if last else pictures,
                over_time=model.over_time & set(pictures),
                jitter=batch["jitter"][:, 0] if "jitter" in batch else torch.zeros(1, 2),
            )


def _radiance(
    model: Upsampler, upsampled: Tensor, frame: Frame, batch: dict[str, Tensor]
) -> tuple[Tensor, Tensor] | None:
    output, target = model.radiance(upsampled, frame), batch["target_radiance"][:, 0]
    return None if output is None else (bounded(output, target, HIGHEST_RADIANCE), target)


def evaluation_requires(model: Upsampler, metrics: Metrics) -> frozenset[str]:
    """Return the buffers that scoring reads: those of the model and of the metrics, and the colour for the crops."""
    return model.requires | metrics.requires | {"color"}


def whole_clips(paths: list[Path], requires: frozenset[str], warm_up: int) -> WholeClips:
    """Return the whole clips of the data set files ``paths``, with the buffers ``requires``.

    Raises:
        UserError: a file does not have a target for every frame, or its clips end within the warm-up.
    """
    for path in paths:
        spec = read_spec(path)
        if spec.targets < spec.frames:
            raise UserError(
                f"{path} has no targets for the first frames of its clips, so it cannot be scored: use a test file."
            )
        if spec.frames <= warm_up:
            raise UserError(
                f"Invalid protocol.warm_up={warm_up}: use less than the {spec.frames} frames of each clip of {path}."
            )
    return WholeClips(paths, requires)
