"""Residual channel attention, and the U-shaped module made of it (Li et al. 2024, NSRD, supplement, section 3 and figure 4)."""

import torch
import torch.nn.functional as F
from torch import Tensor, nn

REDUCTION = 16  # of the channels inside the attention (Zhang et al. 2018, section 4.1)


class ChannelAttention(nn.Module):
    """Every channel times a factor in (0, 1) that comes from all channels' means over the image (Zhang et al. 2018, 3.3)."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.squeeze = nn.Conv2d(width, width // REDUCTION, 1)
        self.excite = nn.Conv2d(width // REDUCTION, width, 1)

    def forward(self, x: Tensor) -> Tensor:
        mean = x.mean(dim=(-2, -1), keepdim=True)
        factor: Tensor = self.excite(self.squeeze(mean).relu()).sigmoid()
        return x * factor


class ResidualAttention(nn.Module):
    """RCAB: ``x + attention(conv(relu(conv(x))))``, ``(B, width, h, w)`` in and out (Zhang et al. 2018, equations 12, 13)."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.first = nn.Conv2d(width, width, 3, padding=1)
        self.second = nn.Conv2d(width, width, 3, padding=1)
        self.attention = ChannelAttention(width)

    def forward(self, x: Tensor) -> Tensor:
        result: Tensor = x + self.attention(self.second(self.first(x).relu()))
        return result


def blocks(count: int, width: int) -> nn.Sequential:
    """``count`` residual attention blocks, one after the other."""
    return nn.Sequential(*(ResidualAttention(width) for _ in range(count)))


def halved(x: Tensor) -> Tensor:
    """Max-pooled by 2; an odd last row or column is dropped, and an axis of one pixel stays."""
    return F.max_pool2d(x, (min(2, x.shape[-2]), min(2, x.shape[-1])))


def doubled(x: Tensor, like: Tensor) -> Tensor:
    """Bilinearly upsampled by 2 to ``like``'s size: what `halved` dropped is repeated from its neighbours."""
    height, width = like.shape[-2:]
    x = F.interpolate(x, scale_factor=2, mode="bilinear", align_corners=False)[..., :height, :width]
    below, right = height - x.shape[-2], width - x.shape[-1]
    return F.pad(x, (0, right, 0, below), mode="replicate") if below or right else x


class UShaped(nn.Module):
    """``(B, width, h, w) -> (B, width, h, w)`` of 3, 2, 3, 2, 3 blocks at full, half, quarter, half and full size.

    Any size from 1x1 up. The upsampling has pixel edges in common with the pooling (``align_corners=False``), of which the
    paper says no more than "bilinear".
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
        half = self.down2(halved(full))
        x = self.centre(halved(half))
        x = self.up2(self.join2(torch.cat((doubled(x, half), half), dim=1)))
        x = self.up1(self.join1(torch.cat((doubled(x, full), full), dim=1)))
        return x
