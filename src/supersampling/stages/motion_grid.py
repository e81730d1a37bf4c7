"""Slot ``motion_grid``: the choice of a motion vector for each target pixel.

Mercier et al. 2023, section 4.1, "Depth-informed dilation".
"""

import math
from abc import ABC, abstractmethod
from typing import final

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from supersampling.errors import UserError
from supersampling.ops.resample import upsample_motion


class MotionGrid(nn.Module, ABC):
    """Motion at the target resolution, ``forward(motion (B, 2, h, w), depth (B, 1, h, w), scale) -> (B, 2, H, W)``."""

    @abstractmethod
    def forward(self, motion: Tensor, depth: Tensor, scale: int) -> Tensor: ...


@final
class FrontmostOfBlock(MotionGrid):
    """The motion of the frontmost pixel (lowest depth) of each ``block x block`` square of target pixels.

    Blocks start at the image's top-left corner; those at the right and at the bottom end with the image. A target pixel
    has the motion and depth of the low-resolution pixel that covers it, so at a scale that does not divide the block a
    low-resolution pixel can count in two blocks. Of equal depths the first by rows and columns wins; the paper does not
    say.
    """

    def __init__(self, block: int) -> None:
        super().__init__()
        if block < 1:
            raise UserError(f"Invalid motion_grid.block={block}: use at least 1 target pixel; the paper has 8.")
        self.block = block

    def forward(self, motion: Tensor, depth: Tensor, scale: int) -> Tensor:
        b, _, h, w = depth.shape
        # The coarsest grid whose cells divide both low-resolution pixels and blocks: repeat * h by repeat * w.
        common = math.gcd(self.block, scale)
        repeat, cell = scale // common, self.block // common
        fine = depth.repeat_interleave(repeat, -2).repeat_interleave(repeat, -1)
        rows, columns = -(-h * repeat // cell), -(-w * repeat // cell)
        room = (0, columns * cell - w * repeat, 0, rows * cell - h * repeat)
        cells = F.pad(fine, room, value=math.inf).view(b, rows, cell, columns, cell).transpose(2, 3)
        place = cells.reshape(b, rows, columns, cell * cell).argmin(dim=-1)
        top = cell * torch.arange(rows, device=depth.device)[:, None]
        left = cell * torch.arange(columns, device=depth.device)
        y, x = (top + place // cell) // repeat, (left + place % cell) // repeat
        index = (y * w + x).flatten(1)[:, None].expand(-1, 2, -1)
        grid = motion.flatten(2).gather(2, index).view(b, 2, rows, columns)
        full = grid.repeat_interleave(self.block, -2).repeat_interleave(self.block, -1)
        return full[..., : h * scale, : w * scale]


@final
class BilinearMotion(MotionGrid):
    """Bilinear upsampling, independent of depth: the row "(-) MV dilation" of table 3.

    The paper does not say how motion is brought to the target resolution there; NSRR and DLCTUS do this.
    """

    def forward(self, motion: Tensor, depth: Tensor, scale: int) -> Tensor:
        h, w = motion.shape[-2:]
        return upsample_motion(motion, (h * scale, w * scale))
