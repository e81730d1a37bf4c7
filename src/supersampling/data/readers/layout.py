"""The common interface of all capture layouts: a list of clips, and the frames of a clip."""

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from supersampling.data.readers.conventions import Convention
from supersampling.data.readers.files import Root
from supersampling.data.readers.images import Image


@dataclass(frozen=True)
class Conventions:
    """The conventions of a capture's vectors, and whether its depth runs from 1 near to 0 far (None: as documented)."""

    motion: Convention
    jitter: Convention
    reversed_depth: bool | None = None


class CaptureClip(ABC):
    """Consecutive frames of a capture; files are read on request.

    ``label`` is their position below the capture's folder, ``size`` the target's ``(width, height)`` in pixels.
    """

    def __init__(self, scene: str, split: str, label: str, size: tuple[int, int]) -> None:
        self.scene, self.split, self.label, self.size = scene, split, label, size

    @property
    @abstractmethod
    def frames(self) -> int:
        """Return the number of frames."""

    @abstractmethod
    def files(self) -> Iterable[Path]:
        """Return all files that the clip reads."""

    @abstractmethod
    def read(self, t: int, names: frozenset[str]) -> dict[str, Image]:
        """Return buffers of frame ``t``, ``(h, w, C)`` (``(2,)`` for jitter), in the project's units
        (`supersampling.frames`).

        Raises:
            UserError: a file is missing, broken, of the wrong size or in the wrong unit; the message names it.
        """


class Layout(ABC):
    """Base class of the capture layouts: a capture below a folder, read at one scale."""

    motion: ClassVar[Convention]
    """The convention of motion files according to the layout's documentation."""
    jitter: ClassVar[Convention]
    buffers: ClassVar[frozenset[str]]
    """All buffers of its clips."""
    optional: ClassVar[dict[str, frozenset[str]]] = {}
    """Buffers that a capture may lack altogether, by the folder or file that holds them."""

    def __init__(self, root: Root, scale: int, conventions: Conventions) -> None:
        self.root, self.scale, self.conventions = root, scale, conventions
        self.absent: frozenset[str] = frozenset()
        """The keys of `optional` that this capture lacks."""

    @property
    def recorded(self) -> frozenset[str]:
        """Return the buffers of this capture's clips; call it after `clips`."""
        return self.buffers.difference(*(self.optional[name] for name in self.absent))

    def leave_out(self, absent: Iterable[str]) -> None:
        """Note the keys of `optional` that no clip has, and print a line for each."""
        self.absent = frozenset(absent)
        for name in sorted(self.absent):
            print(f"{self.root.path} has no {name}: imported without {', '.join(sorted(self.optional[name]))}.")

    def summary(self) -> list[str]:
        """Return lines on how values are read; call it after `clips`."""
        return []

    @abstractmethod
    def clips(self) -> list[CaptureClip]:
        """Return all clips, in a fixed order.

        Raises:
            UserError: the capture has no clips, or a file is missing.
        """

    @abstractmethod
    def notes(self) -> dict[str, str]:
        """Return attributes for the data set files; call it after `clips`."""
