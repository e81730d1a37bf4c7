"""Pairs of frames on which a capture is checked before its import."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from supersampling.data.readers.images import Image
from supersampling.data.readers.layout import CaptureClip

CANDIDATES = 24  # pairs whose motion is read
SELECTED = 6  # pairs for the checks: those that move most, or least
MOVING = 0.5  # target pixels per frame


@dataclass(frozen=True)
class Pair:
    """Frames ``t - 1`` and ``t`` of a clip; ``moving`` is the share of low-resolution pixels that move by at least
    `MOVING`."""

    clip: CaptureClip
    t: int
    moving: float

    @property
    def label(self) -> str:
        return f"{self.clip.label}, frame {self.t}"

    def read(self, name: str, before: bool = False) -> Image:
        return self.clip.read(self.t - before, frozenset({name}))[name]

    def tensor(self, name: str, before: bool = False) -> Tensor:
        """Return a buffer of frame ``t`` (of ``t - 1`` if ``before``), ``(1, C, h, w)``."""
        return torch.from_numpy(np.ascontiguousarray(self.read(name, before).transpose(2, 0, 1)))[None]


def select_pairs(clips: Sequence[CaptureClip]) -> list[Pair]:
    """Return up to `CANDIDATES` pairs, spread evenly over all clips, those with the most motion first."""
    frames = [(clip, t) for clip in clips for t in range(1, clip.frames)]
    spread = sorted({round(k) for k in np.linspace(0, len(frames) - 1, CANDIDATES)}) if frames else []
    pairs = []
    for k in spread:
        clip, t = frames[k]
        motion = clip.read(t, frozenset({"motion"}))["motion"]
        length = np.linalg.norm(motion * np.array(clip.size, dtype=np.float32), axis=-1)
        pairs.append(Pair(clip, t, float((length >= MOVING).mean())))
    return sorted(pairs, key=lambda pair: -pair.moving)


def extremes(pairs: Sequence[Pair]) -> list[Pair]:
    """Return the `SELECTED` pairs that move most, and as many of those that move least."""
    return [*pairs[:SELECTED], *pairs[SELECTED:][-SELECTED:]]
