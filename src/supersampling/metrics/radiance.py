"""PSNR of linear radiance."""

import math
from typing import final

from torch import Tensor

from supersampling.errors import UserError
from supersampling.metrics.base import FrameMetric, Moment
from supersampling.metrics.image import psnr

MU = 5000.0


def mu_law(radiance: Tensor, white: float) -> Tensor:
    """Return ``ln(1 + mu L / white) / ln(1 + mu)`` with mu = 5000 (Kalantari and Ramamoorthi 2017, section 4), any
    shape.

    0 and ``white`` become 0 and 1. Radiance above ``white`` exceeds 1 and is not clamped; negative radiance counts as
    0.
    """
    return (radiance.clamp_min(0.0) * (MU / white)).log1p() / math.log1p(MU)


def psnr_hdr_mu(output: Tensor, target: Tensor, white: float = 1.0) -> Tensor:
    """Return the PSNR ``(B,)`` in dB, peak 1, of radiance ``(B, 3, H, W)`` after `mu_law`; at most `image.PSNR_CAP`."""
    return psnr(mu_law(output, white), mu_law(target, white))


@final
class PSNRMu(FrameMetric):
    """``psnr_hdr_mu`` in dB; NaN for a method without radiance.

    Args:
        white: the radiance that becomes 1, positive. Radiance is exposed: 1 is a white surface in the light of its
            scene.
    """

    better = {"psnr_hdr_mu": "higher"}
    requires = frozenset({"target", "target_radiance"})

    def __init__(self, white: float) -> None:
        if not 0.0 < white < math.inf:
            raise UserError(
                f"Invalid white={white} of psnr_hdr_mu: use a positive number, such as 1 for exposed radiance."
            )
        self._white = white

    def measure(self, moment: Moment) -> list[float]:
        return [math.nan if moment.radiance is None else psnr_hdr_mu(*moment.radiance, self._white).item()]
