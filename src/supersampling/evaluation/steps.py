"""Pictures of what a method computes in consecutive frames, with the places of the samples (Mercier et al. 2023, figure
6)."""

from collections import defaultdict, deque
from pathlib import Path

import numpy as np
import torch
import torch.nn.functional as F
from PIL import Image, ImageDraw
from torch import Tensor

from supersampling.evaluation.score import PICTURED_FRAMES, ScoredFrame

WINDOW = 8  # target pixels, or the next multiple of the scale
MAGNIFIED = 16  # pixels of the picture for each target pixel
GAP = 8
DOT = (214, 39, 40)


class Steps:
    """The pictures over time of a clip's last frames, and how they are drawn side by side."""

    def __init__(self) -> None:
        self._scale = 1
        # By name: images (H, W) with the jitter of their frame. Whole frames would fill the memory at 1080p.
        self._images: defaultdict[str, deque[tuple[Tensor, Tensor]]] = defaultdict(
            lambda: deque(maxlen=PICTURED_FRAMES)
        )

    def add(self, frame: ScoredFrame) -> None:
        self._scale = frame.target.shape[-1] // frame.color.shape[-1]
        for name in frame.over_time:
            self._images[name].append((frame.pictures[name][0, 0], frame.jitter[0]))

    def save(self, folder: Path, stem: str, corner: tuple[int, int], size: int) -> None:
        """Write ``<stem>_<name>.png`` for each picture over time, from the ``size`` square at ``corner (y, x)``."""
        for name, items in self._images.items():
            y, x, side = quiet_window(torch.stack([image for image, _ in items]), self._scale, corner, size)
            tiles = [_tile(image[y : y + side, x : x + side], jitter, self._scale) for image, jitter in items]
            _beside(tiles).save(folder / f"{stem}_{name}.png")


def quiet_window(values: Tensor, scale: int, corner: tuple[int, int], size: int) -> tuple[int, int, int]:
    """Return top, left and side of the window with the least mean of ``values (T, H, W)``: for a blending mask, the
    surface whose history is kept.

    It lies in the ``size`` square at ``corner (y, x)``, at a multiple of ``scale``.
    """
    side = min(-(-WINDOW // scale) * scale, size // scale * scale)
    top, left = (-(-place // scale) * scale for place in corner)
    height, width = corner[0] + size - top, corner[1] + size - left
    region = values.mean(dim=0)[None, None, top : top + height, left : left + width].float()
    means = F.avg_pool2d(region, side, stride=scale)
    best = int(means.argmin())
    return top + best // means.shape[-1] * scale, left + best % means.shape[-1] * scale, side


def _tile(values: Tensor, jitter: Tensor, scale: int) -> Image.Image:
    """Return one window, magnified, with a dot at each sample's place."""
    grey = (values.clamp(0, 1) * 255).round().to(torch.uint8).cpu().numpy()
    magnified = grey.repeat(MAGNIFIED, axis=0).repeat(MAGNIFIED, axis=1)
    image = Image.fromarray(magnified).convert("RGB")
    draw, radius = ImageDraw.Draw(image), MAGNIFIED / 5
    for row in range(values.shape[0] // scale):
        for column in range(values.shape[1] // scale):
            x = (column + 0.5 + float(jitter[0])) * scale * MAGNIFIED
            y = (row + 0.5 + float(jitter[1])) * scale * MAGNIFIED
            draw.ellipse((x - radius, y - radius, x + radius - 1, y + radius - 1), fill=DOT)
    return image


def _beside(tiles: list[Image.Image]) -> Image.Image:
    """Return the tiles from left to right, with white between them."""
    gap = np.full((tiles[0].height, GAP, 3), 255, np.uint8)
    parts = [part for tile in tiles for part in (gap, np.asarray(tile))][1:]
    return Image.fromarray(np.concatenate(parts, axis=1))
