"""One clip of a data set file, as far as the file holds it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supersampling.data.dataset_file import DatasetFile
from supersampling.errors import UserError
from supersampling.frames import BUFFERS

Array = NDArray[np.float32]


@dataclass(frozen=True)
class ClipView:
    """ClipView number ``index`` of ``store``; ``names`` are the buffers to look at, of which the file may hold a part.

    Raises:
        UserError: the file has no such clip.
    """

    store: DatasetFile
    index: int
    names: frozenset[str] = frozenset(BUFFERS)

    def __post_init__(self) -> None:
        if not 0 <= self.index < self.store.clips:
            raise UserError(f"{self.store.path} has no clip {self.index}: it holds {self.store.clips}, counted from 0.")

    @property
    def frames(self) -> int:
        return self.store.spec.frames

    @property
    def low_size(self) -> tuple[int, int]:
        """``(w, h)``."""
        (width, height), scale = self.size, self.store.spec.scale
        return width // scale, height // scale

    @property
    def size(self) -> tuple[int, int]:
        """``(W, H)``."""
        return self.store.spec.target_size

    def resolve_frame(self, frame: int | None) -> int:
        """A frame's number; ``None`` is the last one.

        Raises:
            UserError: the clip has no such frame.
        """
        if frame is None:
            return self.frames - 1
        if not 0 <= frame < self.frames:
            raise UserError(
                f"The clips of {self.store.path} have no frame {frame}: use frame=0 to {self.frames - 1}, or null "
                "for the last one."
            )
        return frame

    def has(self, name: str, frame: int) -> bool:
        """Whether this frame's buffer is there; high-resolution ones may be for the last frames only."""
        first = self.frames - self.store.spec.targets if BUFFERS[name].resolution == "high" else 0
        return name in self.names & self.store.buffers and first <= frame < self.frames

    def read(self, name: str, frame: int) -> Array:
        """``(C, h, w)``, ``(C, H, W)`` or, the jitter, ``(2,)``; float32 in the buffer's range."""
        return self.store.read(name, self.index, slice(frame, frame + 1))[0]

    def find(self, frame: int, *names: str) -> str | None:
        """The first of ``names`` that is there."""
        return next((name for name in names if self.has(name, frame)), None)
