"""Single frames in display space against the target, one metric a class: see `supersampling.metrics.image`."""

from typing import final

from supersampling.metrics.image import mssim_thesis, psnr, ssim_gauss11, ssim_uniform11
from supersampling.metrics.suite import Metric, Moment


@final
class PSNR(Metric):
    """``psnr`` in dB."""

    names = ("psnr",)
    requires = frozenset({"target"})

    def __call__(self, moment: Moment) -> dict[str, float]:
        return {"psnr": psnr(moment.output, moment.target).item()}


@final
class SSIM(Metric):
    """``ssim``: Gaussian window of 11, sigma 1.5, as NSRR and ENSS have it."""

    names = ("ssim",)
    requires = frozenset({"target"})

    def __call__(self, moment: Moment) -> dict[str, float]:
        return {"ssim": ssim_gauss11(moment.output, moment.target).item()}


@final
class SSIMUniform11(Metric):
    """``ssim_uniform11``: uniform window of 11, sample covariance, as NSRD's code has it."""

    names = ("ssim_uniform11",)
    requires = frozenset({"target"})

    def __call__(self, moment: Moment) -> dict[str, float]:
        return {"ssim_uniform11": ssim_uniform11(moment.output, moment.target).item()}


@final
class MSSIMThesis(Metric):
    """``mssim_thesis``: SSIM with the constants of Swensen 2021."""

    names = ("mssim_thesis",)
    requires = frozenset({"target"})

    def __call__(self, moment: Moment) -> dict[str, float]:
        return {"mssim_thesis": mssim_thesis(moment.output, moment.target).item()}
