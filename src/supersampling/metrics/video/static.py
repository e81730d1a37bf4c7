"""Flicker of static pixels: the pixel-wise standard deviation of ENSS (Mercier et al. 2023), table 3.

The paper takes 18 frames of a clip whose camera does not move, computes the standard deviation of every pixel over
them, and averages over the image. Its numbers (0.54, 1.10) are interpreted here as 8-bit levels; it is assumed that the
deviation divides by the number of frames, for each colour channel separately.
"""

import math
from typing import final

import torch
from torch import Tensor

from supersampling.errors import UserError
from supersampling.metrics.base import Moment
from supersampling.metrics.regions import static
from supersampling.metrics.video.base import Scoring, VideoMetric


@final
class StaticDeviation(VideoMetric):
    """``static_std`` of the output, ``static_std_reference`` of the target, and ``static_std_fraction``, the share of
    the clip's pixels and frames that belong to spans.

    A span is an unbroken sequence of at least ``shortest`` frames in which a pixel has no motion (`regions.STILL`).
    Each pixel has its own spans, so that a clip counts if its camera rests for a while. Spans are weighted by their
    number of frames; NaN without spans. Moving lights and shadows count too: compare with the value of the reference.
    """

    better = {"static_std": "lower", "static_std_reference": "neither", "static_std_fraction": "neither"}
    requires = frozenset({"target", "motion"})

    def __init__(self, shortest: int = 8) -> None:
        if shortest < 2:
            raise UserError(f"Invalid shortest={shortest} of static_std: use at least 2 frames, such as 8.")
        self._shortest = shortest

    def begin(self) -> Scoring:
        return _Spans(self._shortest)


@final
class _Spans(Scoring):
    """Running means and squared deviations (Welford 1962) of output and target; a pixel that moves starts again."""

    def __init__(self, shortest: int) -> None:
        self._shortest = shortest
        # (1, 1, H, W): the number of frames in the pixel's current span.
        self._count: Tensor | None = None
        # (2, 3, H, W): output, target.
        self._mean = self._squares = torch.empty(0)
        self._sums = (0.0, 0.0)
        self._weight = 0.0
        self._seen = 0

    def add(self, moment: Moment) -> None:
        assert moment.motion is not None
        values = torch.cat((moment.output, moment.target))
        if self._count is None:
            self._count = values.new_zeros((1, 1, *values.shape[-2:]))
            self._mean, self._squares = torch.zeros_like(values), torch.zeros_like(values)
        height, width = values.shape[-2:]
        still = static(moment.motion, (height, width))
        self._end(~still)
        self._count = torch.where(still, self._count + 1.0, 0.0)
        change = values - self._mean
        self._mean = torch.where(still, self._mean + change / self._count.clamp_min(1.0), 0.0)
        self._squares = torch.where(still, self._squares + change * (values - self._mean), 0.0)
        self._seen += self._count.numel()

    def _end(self, pixels: Tensor) -> None:
        """End the spans of ``pixels (1, 1, H, W)``, and add those that are long enough to the sums."""
        assert self._count is not None
        frames = torch.where(pixels & (self._count >= self._shortest), self._count, 0.0)
        deviation = (self._squares / self._count.clamp_min(1.0)).sqrt().mean(dim=1, keepdim=True)
        output, target = (255.0 * deviation * frames).sum(dim=(1, 2, 3), dtype=torch.float64).tolist()
        self._sums = (self._sums[0] + output, self._sums[1] + target)
        self._weight += frames.sum(dtype=torch.float64).item()

    def finish(self) -> dict[str, float]:
        if self._count is not None:
            self._end(torch.ones_like(self._count, dtype=torch.bool))
            self._count = torch.zeros_like(self._count)
        fraction = self._weight / self._seen if self._seen else math.nan
        weight = self._weight or math.nan
        return dict(zip(StaticDeviation.names, (self._sums[0] / weight, self._sums[1] / weight, fraction)))
