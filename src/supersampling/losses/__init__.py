"""Training losses over the counted frames of a clip; each can be a term of a weighted sum."""

from supersampling.losses.base import Loss
from supersampling.losses.perceptual import Perceptual
from supersampling.losses.pixel import L1, MSE, SmoothL1
from supersampling.losses.ssim import SSIM
from supersampling.losses.temporal import MaskedTemporal, SpatioTemporal
from supersampling.losses.weighted import Sum

__all__ = ["L1", "MSE", "SSIM", "Loss", "MaskedTemporal", "Perceptual", "SmoothL1", "SpatioTemporal", "Sum"]
