"""View of one clip of a data set file."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supersampling.data.dataset_file import DatasetFile
from supersampling.errors import UserError
from supersampling.frames import BUFFERS

Array = NDArray[np.float32]


@dataclass(frozen=True)
class ClipView:
    """Clip number ``index`` of the data set ``file``; ``names`` are the buffers to show, some of which may be missing.

    Raises:
        UserError: the file does not have this clip.
    """

    file: DatasetFile
    index: int
    names: frozenset[str] = frozenset(BUFFERS)

    def __post_init__(self) -> None:
        if not 0 <= self.index < self.file.clips:
            raise UserError(f"Invalid clip={self.index}: use 0 to {self.file.clips - 1} for {self.file.path}.")

    @property
    def frames(self) -> int:
        return self.file.spec.frames

    @property
    def low_size(self) -> tuple[int, int]:
        """Return ``(w, h)``."""
        (width, height), scale = self.size, self.file.spec.scale
        return width // scale, height // scale

    @property
    def size(self) -> tuple[int, int]:
        """Return ``(W, H)``."""
        return self.file.spec.target_size

    def resolve_frame(self, frame: int | None) -> int:
        """Return the number of a frame; ``None`` is the last one.

        Raises:
            UserError: the clip does not have this frame.
        """
        if frame is None:
            return self.frames - 1
        if not 0 <= frame < self.frames:
            raise UserError(
                f"Invalid frame={frame}: use 0 to {self.frames - 1} for {self.file.path}, or null for the last frame."
            )
        return frame

    def has(self, name: str, frame: int) -> bool:
        """Return whether a frame has a buffer; high-resolution buffers may exist for the last frames only."""
        first = self.frames - self.file.spec.targets if BUFFERS[name].resolution == "high" else 0
        return name in self.names & self.file.buffers and first <= frame < self.frames

    def read(self, name: str, frame: int) -> Array:
        """Return a buffer ``(C, h, w)`` or ``(C, H, W)``, or jitter ``(2,)``; float32 in the buffer's range."""
        return self.file.read(name, self.index, slice(frame, frame + 1))[0]

    def find(self, frame: int, *names: str) -> str | None:
        """Return the first of ``names`` that the frame has; None if it has none of them."""
        return next((name for name in names if self.has(name, frame)), None)
