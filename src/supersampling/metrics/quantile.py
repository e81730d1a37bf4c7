"""A high quantile of the error: what the worst pixels are like."""

from typing import final

from supersampling.metrics.base import FrameMetric, Moment


@final
class ErrorQuantile(FrameMetric):
    """``error_q95``: the value that 95 % of all pixels and channels' absolute errors do not exceed."""

    better = {"error_q95": "lower"}

    def measure(self, moment: Moment) -> list[float]:
        errors = (moment.output - moment.target).abs().flatten()
        # `torch.quantile` is limited to 16 million values, fewer than an image of 8K has.
        return [errors.kthvalue(max(1, round(0.95 * errors.numel()))).values.item()]
