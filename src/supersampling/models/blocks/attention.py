"""Residual channel attention and the U-shaped module of NSRD (Li et al. 2024, supplement, section 3 and figure 4)."""

import torch
import torch.nn.functional as F
from torch import Tensor, nn

REDUCTION = 16  # divisor of the channels inside the attention (Zhang et al. 2018, section 4.1)


class ChannelAttention(nn.Module):
    """Each channel times a factor in (0, 1), computed from the means of all channels (Zhang et al. 2018, 3.3)."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.squeeze = nn.Conv2d(width, width // REDUCTION, 1)
        self.excite = nn.Conv2d(width // REDUCTION, width, 1)

    def forward(self, x: Tensor) -> Tensor:
        mean = x.mean(dim=(-2, -1), keepdim=True)
        factor: Tensor = self.excite(self.squeeze(mean).relu()).sigmoid()
        return x * factor


class ResidualAttention(nn.Module):
    """RCAB: ``x + attention(conv(relu(conv(x))))`` on ``(B, width, h, w)`` (Zhang et al. 2018, equations 12 and 13)."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.first = nn.Conv2d(width, width, 3, padding=1)
        self.second = nn.Conv2d(width, width, 3, padding=1)
        self.attention = ChannelAttention(width)

    def forward(self, x: Tensor) -> Tensor:
        result: Tensor = x + self.attention(self.second(self.first(x).relu()))
        return result


def blocks(count: int, width: int) -> nn.Sequential:
    """Return a sequence of ``count`` residual attention blocks."""
    return nn.Sequential(*(ResidualAttention(width) for _ in range(count)))


def halve(x: Tensor) -> Tensor:
    """Max-pool by 2; an odd last row or column is dropped, and an axis of one pixel stays."""
    return F.max_pool2d(x, (min(2, x.shape[-2]), min(2, x.shape[-1])))


def double(x: Tensor, like: Tensor) -> Tensor:
    """Upsample bilinearly by 2 to the size of ``like``, repeating the last row or column where `halve` dropped one."""
    height, width = like.shape[-2:]
    x = F.interpolate(x, scale_factor=2, mode="bilinear", align_corners=False)[..., :height, :width]
    below, right = height - x.shape[-2], width - x.shape[-1]
    return F.pad(x, (0, right, 0, below), mode="replicate") if below or right else x


class UShaped(nn.Module):
    """3, 2, 3, 2, 3 blocks at full, half, quarter, half and full size: ``(B, width, h, w) -> (B, width, h, w)``.

    The image may have any size. The upsampling aligns pixel edges with the pooling (``align_corners=False``); the paper
    only says "bilinear".
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.down1, self.down2 = blocks(3, width), blocks(2, width)
        self.centre = blocks(3, width)
        self.join2 = nn.Conv2d(2 * width, width, 3, padding=1)
        self.up2 = blocks(2, width)
        self.join1 = nn.Conv2d(2 * width, width, 3, padding=1)
        self.up1 = blocks(3, width)

    def forward(self, x: Tensor) -> Tensor:
        full = self.down1(x)
        half = self.down2(halve(full))
        x = self.centre(halve(half))
        x = self.up2(self.join2(torch.cat((double(x, half), half), dim=1)))
        x = self.up1(self.join1(torch.cat((double(x, full), full), dim=1)))
        return x
