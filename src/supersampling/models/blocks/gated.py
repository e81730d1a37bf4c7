"""Gated convolution (Yu et al. 2019; Li et al. 2024, NSRD, equation 5)."""

import torch.nn.functional as F
from torch import Tensor, nn


class GatedConvolution(nn.Module):
    """``LeakyReLU(conv_f(x)) * sigmoid(conv_g(x))``, 3x3: ``(B, channels, h, w) -> (B, width, h, w)``.

    Both are computed by one convolution of twice the width: features first, then gates. The paper states no slope; 0.2
    is that of Yu et al.
    """

    def __init__(self, channels: int, width: int) -> None:
        super().__init__()
        self.both = nn.Conv2d(channels, 2 * width, 3, padding=1)

    def forward(self, x: Tensor) -> Tensor:
        features, gate = self.both(x).chunk(2, dim=1)
        return F.leaky_relu(features, 0.2) * gate.sigmoid()

    def gate_bias(self) -> Tensor | None:
        """Return the gates' half of the bias, ``(width,)``."""
        bias = self.both.bias
        return None if bias is None else bias[bias.numel() // 2 :]
