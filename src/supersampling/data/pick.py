"""The selection of the window of a training sample among random proposals."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError

EDGE = 0.5  # target pixels per frame


@dataclass(frozen=True, kw_only=True)
class ClipWindow:
    """A window of a clip: its file and clip, the frame after its last one, and its low-resolution corner ``x, y``."""

    file: int
    clip: int
    stop: int
    x: int
    y: int


def motion_edges(pixels: NDArray[np.floating]) -> float:
    """Return the share of pixels whose motion ``(..., h, w, 2)``, in target pixels, differs from a neighbour's by over
    0.5.

    There, surfaces come into view from behind others.
    """
    x = np.linalg.norm(np.diff(pixels, axis=-2), axis=-1) > EDGE
    y = np.linalg.norm(np.diff(pixels, axis=-3), axis=-1) > EDGE
    return float(x.mean() + y.mean()) / 2.0


class Pick(ABC):
    """Base class of ``pick(propose, motion) -> window``; ``motion(window)`` is ``(T, h, w, 2)`` in target pixels.

    ``requires`` names the buffers that it reads.
    """

    requires: frozenset[str]

    @abstractmethod
    def __call__(
        self, propose: Callable[[], ClipWindow], motion: Callable[[ClipWindow], NDArray[np.floating]]
    ) -> ClipWindow: ...


@final
class Uniform(Pick):
    """The first proposal: all windows have the same probability (Swensen 2021, 4.3.2)."""

    requires = frozenset[str]()

    def __call__(
        self, propose: Callable[[], ClipWindow], motion: Callable[[ClipWindow], NDArray[np.floating]]
    ) -> ClipWindow:
        return propose()


@final
class MostEdges(Pick):
    """The proposal with the most motion edges of ``looks``: history fails there, and most windows have few of them."""

    requires = frozenset({"motion"})

    def __init__(self, looks: int) -> None:
        if looks < 1:
            raise UserError(f"Invalid pick.looks={looks}: use at least 1, or pick=uniform for the first proposal.")
        self.looks = looks

    def __call__(
        self, propose: Callable[[], ClipWindow], motion: Callable[[ClipWindow], NDArray[np.floating]]
    ) -> ClipWindow:
        return max((propose() for _ in range(self.looks)), key=lambda window: motion_edges(motion(window)))
