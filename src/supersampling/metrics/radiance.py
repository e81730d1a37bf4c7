"""PSNR of linear radiance."""

import math
from typing import final

from torch import Tensor

from supersampling.errors import UserError
from supersampling.metrics.image import psnr
from supersampling.metrics.suite import Metric, Moment

MU = 5000.0


def mu_law(radiance: Tensor, white: float) -> Tensor:
    """``ln(1 + mu L / white) / ln(1 + mu)``, mu = 5000 (Kalantari and Ramamoorthi 2017, section 4): 0 and ``white`` go to 0
    and 1. Radiance above ``white`` goes beyond 1 and is not cut; negative radiance counts as none. Any shape."""
    return (radiance.clamp_min(0.0) * (MU / white)).log1p() / math.log1p(MU)


def psnr_hdr_mu(output: Tensor, target: Tensor, white: float = 1.0) -> Tensor:
    """PSNR in dB after `mu_law`, for peak 1, of radiance ``(B, 3, H, W)``: ``(B,)``, at most `image.PSNR_CAP`."""
    return psnr(mu_law(output, white), mu_law(target, white))


@final
class PSNRMu(Metric):
    """``psnr_hdr_mu`` in dB; NaN where a method gives no radiance.

    Args:
        white: the radiance that counts as 1, above 0. Radiance is exposed, so that 1 is a white surface in its scene's light.
    """

    names = ("psnr_hdr_mu",)
    requires = frozenset({"target", "target_radiance"})

    def __init__(self, white: float) -> None:
        if not 0.0 < white < math.inf:
            raise UserError(f"white of psnr_hdr_mu must be above 0, got {white}; 1 suits exposed radiance.")
        self._white = white

    def __call__(self, moment: Moment) -> dict[str, float]:
        if moment.radiance is None:
            return {"psnr_hdr_mu": math.nan}
        return {"psnr_hdr_mu": psnr_hdr_mu(*moment.radiance, self._white).item()}
