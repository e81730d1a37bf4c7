"""Metrics of single frames in display colours, one class per metric: see `supersampling.metrics.image`."""

from typing import final

from supersampling.metrics.base import FrameMetric, Moment
from supersampling.metrics.image import psnr, ssim_gauss11, ssim_uniform11, ssim_zero_pad11


@final
class PSNR(FrameMetric):
    """``psnr`` in dB."""

    better = {"psnr": "higher"}

    def measure(self, moment: Moment) -> list[float]:
        return [psnr(moment.output, moment.target).item()]


@final
class SSIM(FrameMetric):
    """``ssim``: Gaussian window of 11, sigma 1.5, as in NSRR and ENSS."""

    better = {"ssim": "higher"}

    def measure(self, moment: Moment) -> list[float]:
        return [ssim_gauss11(moment.output, moment.target).item()]


@final
class SSIMUniform11(FrameMetric):
    """``ssim_uniform11``: uniform window of 11, sample covariance, as in NSRD's code."""

    better = {"ssim_uniform11": "higher"}

    def measure(self, moment: Moment) -> list[float]:
        return [ssim_uniform11(moment.output, moment.target).item()]


@final
class SSIMZeroPad11(FrameMetric):
    """``ssim_zero_pad11``: as `SSIM`, with zeros outside the image, as in the program of Swensen 2021."""

    better = {"ssim_zero_pad11": "higher"}

    def measure(self, moment: Moment) -> list[float]:
        return [ssim_zero_pad11(moment.output, moment.target).item()]
