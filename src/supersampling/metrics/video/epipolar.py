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
        # Made once: rows kept one by one, between frames that come and go, would hold the freed memory of the frames.
        self._planes = np.empty((2, 0, 0, 3), np.uint8)
        self._frames = 0

    def add(self, output: Tensor, target: Tensor) -> None:
        """Take the next frame's images, ``(1, 3, H, W)`` in [0, 1] each."""
        if self._frames == self._longest:
            return
        height, width = target.shape[-2:]
        if self._frames == 0:
            self._planes = np.zeros((2, self._longest, width, 3), np.uint8)
        row = min(int(self._place * height), height - 1)
        for plane, image in zip(self._planes, (output, target)):
            plane[self._frames] = to_bytes(image[..., row : row + 1, :])[0]
        self._frames += 1

    def images(self) -> tuple[np.ndarray, np.ndarray]:
        """Output's and target's, ``(frames, W, 3)`` uint8. Raises `UserError` before the first frame."""
        if self._frames == 0:
            raise UserError("There is no epipolar-plane image of a clip without frames; add one first.")
        output, target = self._planes[:, : self._frames]
        return output, target
