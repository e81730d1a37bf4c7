"""A clip of the closed-form world in memory, whose frames may be changed."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from capture_files import JITTER, SIZE, frame


@cache
def rendered(t, speed):
    return {n: b.astype(np.float32) for n, b in frame(t, 0, 2, JITTER[t % len(JITTER)], speed).items()}


def unchanged(frame, t):
    pass


@dataclass
class Rendered:
    """A clip; ``change(buffers, t)`` edits a frame's buffers in place."""

    change: Callable = unchanged
    speed: float = 1.0
    frames: int = 6
    size: tuple[int, int] = SIZE
    label: str = "clip"

    def read(self, t, names):
        buffers = {name: buffer.copy() for name, buffer in rendered(t, self.speed).items()}
        self.change(buffers, t)
        return {name: buffers[name] for name in names}
