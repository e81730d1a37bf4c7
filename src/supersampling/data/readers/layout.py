"""The small interface that all capture layouts share: a list of clips, and the frames of a clip."""

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
    """What a capture's vectors hold, and whether its depth runs from 1 near to 0 far (None: as documented)."""

    motion: Convention
    jitter: Convention
    reversed_depth: bool | None = None


class CaptureClip(ABC):
    """Consecutive frames of a capture; files are read when a frame is asked for.

    ``label`` is where they lie below the capture's folder, ``size`` the target's ``(width, height)`` in pixels.
    """

    def __init__(self, scene: str, split: str, label: str, size: tuple[int, int]) -> None:
        self.scene, self.split, self.label, self.size = scene, split, label, size

    @property
    @abstractmethod
    def frames(self) -> int:
        """How many frames the clip has."""

    @abstractmethod
    def files(self) -> Iterable[Path]:
        """All files that the clip reads."""

    @abstractmethod
    def read(self, t: int, names: frozenset[str]) -> dict[str, Image]:
        """Some buffers of frame ``t``, ``(h, w, C)`` (``(2,)`` for jitter) in our units and ranges (`supersampling.frames`).

        Raises:
            UserError: names the file that is missing, broken, of the wrong size or in the wrong unit.
        """


class Layout(ABC):
    """A capture below a folder, seen at one scale."""

    motion: ClassVar[Convention]
    """What the layout's documentation says that motion files hold."""
    jitter: ClassVar[Convention]
    buffers: ClassVar[frozenset[str]]
    """All that its clips have."""

    def __init__(self, root: Root, scale: int, conventions: Conventions) -> None:
        self.root, self.scale, self.conventions = root, scale, conventions

    @abstractmethod
    def clips(self) -> list[CaptureClip]:
        """All clips, in a fixed order.

        Raises:
            UserError: there are none, or a file is missing.
        """

    @abstractmethod
    def notes(self) -> dict[str, str]:
        """Attributes of the files that are made of it, once its clips are known."""
