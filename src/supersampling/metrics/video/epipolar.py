"""Epipolar-plane images: one row of pixels over time (Bolles et al. 1987; NSRD, figure 6). Flicker shows as horizontal stripes,
ghosting as smeared edges, a stable picture as clean lines."""

import numpy as np
from torch import Tensor

from supersampling.errors import UserError
from supersampling.metrics.video.base import to_bytes


class EpipolarPlane:
    """Gathers a row of every frame of a clip; time runs downwards.

    Args:
        place: which row, from 0 (the image's top) to 1 (its bottom).
        longest: frames that are kept, the clip's first, so that memory is bounded.
    """

    def __init__(self, place: float = 0.5, longest: int = 512) -> None:
        if not 0.0 <= place <= 1.0:
            raise UserError(f"The row's place must lie in [0, 1], got {place}; 0.5 is the middle.")
        self._place, self._longest = place, longest
        self._rows: list[tuple[np.ndarray, np.ndarray]] = []

    def add(self, output: Tensor, target: Tensor) -> None:
        """Take the next frame's images, ``(1, 3, H, W)`` in [0, 1] each."""
        if len(self._rows) == self._longest:
            return
        height = target.shape[-2]
        row = min(int(self._place * height), height - 1)
        ours, theirs = (to_bytes(image[..., row : row + 1, :])[0] for image in (output, target))
        self._rows.append((ours, theirs))

    def images(self) -> tuple[np.ndarray, np.ndarray]:
        """Output's and target's, ``(frames, W, 3)`` uint8. Raises `UserError` before the first frame."""
        if not self._rows:
            raise UserError("There is no epipolar-plane image of a clip without frames; add one first.")
        output, target = zip(*self._rows)
        return np.stack(output), np.stack(target)
