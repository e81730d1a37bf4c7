"""The U-Net of NSRR's reconstruction (Xiao et al. 2020, 3.2.4)."""

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from supersampling.errors import UserError

SHRINK = 4  # factor of the U-Net's coarsest scale


class UNet(nn.Module):
    """Ten convolutions 3x3 at three scales, 64-32, 64-64, 128-128, 64-64, 32-3 (figure 4, blue), of any image size.

    ``(B, channels, H, W) -> (B, 3, H, W)``. The text does not say what lies between them: here 2x2 max pooling
    downwards, bilinear interpolation upwards, a scale's last features concatenated after the upsampled ones, and a ReLU
    after every convolution except the last. An image whose size is not a multiple of 4 is padded with zeros to the
    right and below, and the output is cropped.
    """

    def __init__(self, channels: int, width: int = 64) -> None:
        super().__init__()
        if width < 2 or width % 2:
            raise UserError(f"Invalid model.width={width}: use an even number, at least 2; the paper has 64 and 32.")
        half = width // 2
        self.fine = _pair(channels, width, half)
        self.middle = _pair(half, width, width)
        self.coarse = _pair(width, 2 * width, 2 * width)
        self.to_middle = _pair(3 * width, width, width)
        self.to_fine = nn.Sequential(
            nn.Conv2d(width + half, half, 3, padding=1), nn.ReLU(inplace=True), nn.Conv2d(half, 3, 3, padding=1)
        )

    def forward(self, x: Tensor) -> Tensor:
        height, width = x.shape[-2:]
        bottom, right = -height % SHRINK, -width % SHRINK
        if bottom or right:
            x = F.pad(x, (0, right, 0, bottom))
        fine = self.fine(x)
        middle = self.middle(F.max_pool2d(fine, 2))
        coarse = self.coarse(F.max_pool2d(middle, 2))
        middle = self.to_middle(torch.cat((_double(coarse), middle), dim=1))
        return self.to_fine(torch.cat((_double(middle), fine), dim=1))[..., :height, :width]


def _pair(channels: int, first: int, second: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(channels, first, 3, padding=1),
        nn.ReLU(inplace=True),
        nn.Conv2d(first, second, 3, padding=1),
        nn.ReLU(inplace=True),
    )


def _double(x: Tensor) -> Tensor:
    return F.interpolate(x, scale_factor=2, mode="bilinear", align_corners=False)
