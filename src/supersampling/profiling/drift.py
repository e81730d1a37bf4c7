"""Effect of a backend and precision on a method's quality over whole clips, each roll-out with a state of its own.

A recurrent method feeds its own errors back, so a difference may grow from frame to frame: the slope measures that.
"""

import copy
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import pandas as pd
import torch
from torch import Tensor

from supersampling.data.clips import WholeClips
from supersampling.deploy.quantise import tiled
from supersampling.evaluation.score import whole_clips
from supersampling.frames import Frame
from supersampling.metrics.image import psnr
from supersampling.metrics.prepare import Prepare
from supersampling.models.base import Upsampler

Variant = tuple[str, str]  # backend, precision
CALIBRATION_FRAMES = 8  # per clip


class Player(Protocol):
    """A loaded method: see `supersampling.profiling.backends.Stream`."""

    def reset(self) -> None: ...

    def prepare(self, frame: Frame) -> Any: ...

    def step(self, prepared: Any) -> Any: ...

    def image(self, result: Any) -> Tensor: ...


@torch.inference_mode()
def roll(
    model: Upsampler,
    players: Mapping[Variant, Player],
    clips: WholeClips,
    prepare: Prepare,
    indices: Sequence[int] | None = None,
) -> pd.DataFrame:
    """Return a row per frame and variant: ``scene, clip, frame, backend, precision, psnr, changed, largest``.

    ``psnr`` is that of the model as it is trained (PyTorch, float32), ``changed`` that of the variant, both against the
    target. ``largest`` is the largest difference between their images; infinite if one is not finite.

    Args:
        indices: the clips to roll over; None for all.
    """
    model = copy.deepcopy(model).cpu().eval()
    rows = []
    for index in range(len(clips)) if indices is None else indices:
        name, state = clips.name(index), None
        for player in players.values():
            player.reset()
        for t, parts in enumerate(clips.read_frames(index)):
            batch = {key: values[None] for key, values in parts.items()}
            frame, target = Frame.from_clip(batch, 0), batch["target"][:, 0]
            output, state = model(frame, state)
            exact = model.present(output, frame)
            exact_psnr = psnr(prepare(exact, target), target).item()
            for (backend, precision), player in players.items():
                image = player.image(player.step(player.prepare(frame)))
                row = {"scene": name.scene, "clip": name.clip, "frame": t, "backend": backend, "precision": precision}
                changed = psnr(prepare(image, target), target).item()
                largest = float((image - exact).abs().nan_to_num(nan=torch.inf).max())
                rows.append(row | {"psnr": exact_psnr, "changed": changed, "largest": largest})
    return pd.DataFrame(rows)


def first_clips(clips: WholeClips) -> list[int]:
    """Return the index of each scene's first clip."""
    first: dict[str, int] = {}
    for index in range(len(clips)):
        first.setdefault(clips.name(index).scene, index)
    return list(first.values())


def calibration_clips(
    files: Sequence[Path], model: Upsampler, size: tuple[int, int], frames: int = CALIBRATION_FRAMES
) -> Iterator[Iterator[Frame]]:
    """Yield the first frames of each file's first clip, `tiled` to ``size``, to calibrate int8 with.

    Validation files are good enough.
    """
    for path in files:
        clips = whole_clips([path], model.requires, 0)
        parts = zip(range(frames), clips.read_frames(0))
        yield (tiled(Frame.from_clip({k: v[None] for k, v in part.items()}, 0), size, model.scale) for _, part in parts)
