"""Which frames of a capture are looked at before it is imported."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from supersampling.data.readers.images import Image
from supersampling.data.readers.layout import CaptureClip

PROPOSED = 24  # pairs whose motion is read
CHOSEN = 6  # of which the checks take those that move most
MOVING = 0.5  # target pixels a frame


@dataclass(frozen=True)
class Pair:
    """Frames ``t - 1`` and ``t`` of a clip; ``moving`` is the share of low-resolution pixels that move by `MOVING` or more."""

    clip: CaptureClip
    t: int
    moving: float

    def read(self, name: str, before: bool = False) -> Image:
        return self.clip.read(self.t - before, frozenset({name}))[name]

    def tensor(self, name: str, before: bool = False) -> Tensor:
        """A buffer of frame ``t`` (of ``t - 1`` if ``before``), ``(1, C, h, w)``."""
        return torch.from_numpy(np.ascontiguousarray(self.read(name, before).transpose(2, 0, 1)))[None]


def select_pairs(clips: Sequence[CaptureClip]) -> list[Pair]:
    """Up to `CHOSEN` pairs, the ones that move most of those spread evenly over all clips; the same for the same capture."""
    every = [(clip, t) for clip in clips for t in range(1, clip.frames)]
    spread = sorted({round(k) for k in np.linspace(0, len(every) - 1, PROPOSED)}) if every else []
    proposed = []
    for k in spread:
        clip, t = every[k]
        motion = clip.read(t, frozenset({"motion"}))["motion"]
        length = np.linalg.norm(motion * np.array(clip.size, dtype=np.float32), axis=-1)
        proposed.append(Pair(clip, t, float((length >= MOVING).mean())))
    return sorted(proposed, key=lambda pair: -pair.moving)[:CHOSEN]
