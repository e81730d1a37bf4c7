"""Epipolar-plane images: one row of pixels over time (Bolles et al. 1987; NSRD, figure 6).

Flicker appears as horizontal stripes, ghosting as smeared edges, a stable image as clean lines.
"""

import numpy as np
from torch import Tensor

from supersampling.errors import UserError
from supersampling.metrics.video.base import to_bytes


class EpipolarPlane:
    """The image of one row of every frame of a clip; time runs downwards.

    Args:
        place: the position of the row, from 0 (top of the image) to 1 (bottom).
        longest: the maximum number of frames, which bounds memory; later frames are ignored.
    """

    def __init__(self, place: float = 0.5, longest: int = 512) -> None:
        if not 0.0 <= place <= 1.0:
            raise UserError(f"Invalid place={place} of the row: use a number between 0 and 1; 0.5 is the middle.")
        self._place, self._longest = place, longest
        # Allocated once: rows allocated one by one, between short-lived frames, would fragment the memory of the
        # frames.
        self._planes = np.empty((2, 0, 0, 3), np.uint8)
        self._frames = 0

    def add(self, output: Tensor, target: Tensor) -> None:
        """Add the images of the next frame, ``(1, 3, H, W)`` in [0, 1] each."""
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
        """Return the images of output and target, ``(frames, W, 3)`` uint8; raise `UserError` if no frame was added."""
        if self._frames == 0:
            raise UserError("A clip without frames has no epipolar-plane image: add a frame first.")
        output, target = self._planes[:, : self._frames]
        return output, target
