"""Which window a training sample shows, of those that chance proposes."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError

EDGE = 0.5  # target pixels a frame


@dataclass(frozen=True)
class ClipWindow:
    """A window of a clip: the file and clip, the frame after its last one, and its low-resolution corner ``x, y``."""

    file: int
    clip: int
    stop: int
    x: int
    y: int


def motion_edges(pixels: NDArray[np.floating]) -> float:
    """The share of pixels whose motion ``(..., h, w, 2)``, in target pixels, differs from a neighbour's by over half a pixel.

    These are the places where something comes out from behind something else.
    """
    x = np.linalg.norm(np.diff(pixels, axis=-2), axis=-1) > EDGE
    y = np.linalg.norm(np.diff(pixels, axis=-3), axis=-1) > EDGE
    return float(x.mean() + y.mean()) / 2.0


class Pick(ABC):
    """``pick(propose, motion) -> place``; ``motion(place)`` is ``(T, h, w, 2)`` in target pixels.

    ``requires`` names the buffers that it reads.
    """

    requires: frozenset[str]

    @abstractmethod
    def __call__(
        self, propose: Callable[[], ClipWindow], motion: Callable[[ClipWindow], NDArray[np.floating]]
    ) -> ClipWindow: ...


@final
class Uniform(Pick):
    """The first proposal: every window is as likely as any other (Swensen 2021, 4.3.2)."""

    requires = frozenset[str]()

    def __call__(
        self, propose: Callable[[], ClipWindow], motion: Callable[[ClipWindow], NDArray[np.floating]]
    ) -> ClipWindow:
        return propose()


@final
class MostEdges(Pick):
    """Of ``looks`` proposals the one with the most motion edges: history fails there, and most windows hold few of them."""

    requires = frozenset({"motion"})

    def __init__(self, looks: int) -> None:
        if looks < 1:
            raise UserError(f"pick.looks must be at least 1, got {looks}; pick=uniform takes every window.")
        self.looks = looks

    def __call__(
        self, propose: Callable[[], ClipWindow], motion: Callable[[ClipWindow], NDArray[np.floating]]
    ) -> ClipWindow:
        return max((propose() for _ in range(self.looks)), key=lambda place: motion_edges(motion(place)))
