"""The warping error of Lai et al. 2018, "Learning Blind Video Temporal Consistency" (evaluation).

``E(V_t, V_t+1) = 1 / sum(M) sum(M ||V_t - warped V_t+1||^2)``, averaged over the clip's pairs of frames; as in the authors' code
the sum in the denominator counts colour channels too, so that it is a mean squared error of values in [0, 1]. Here the
previous frame is warped to the current one, by the renderer's motion, bilinear. Blur lowers it below the reference's own:
read it beside ``_reference``.

The authors' code is ``evaluate_WarpError.py`` of github.com/phoenix104104/fast_blind_video_consistency: there a pair of frames
without a visible pixel counts as an error of 0, here it does not count.
"""

from abc import ABC, abstractmethod
from typing import final

import torch
from torch import Tensor

from supersampling.metrics.regions import disoccluded
from supersampling.metrics.suite import Moment
from supersampling.metrics.video.base import Scoring, VideoMetric
from supersampling.ops.resample import upsample_motion
from supersampling.ops.warp import outside, warp


class Visibility(ABC):
    """Which pixels two frames share: the weights ``M (1, 1, H, W)`` in [0, 1]."""

    suffix: str
    requires: frozenset[str]

    @abstractmethod
    def __call__(self, moment: Moment, warped_target: Tensor, motion: Tensor) -> Tensor:
        """``warped_target`` is the previous target and ``motion`` this frame's, both at target resolution."""


@final
class DualMotion(Visibility):
    """1 where the point was neither hidden (NSRD's motion mask) nor outside of the previous image, else 0."""

    suffix = ""
    requires = frozenset({"motion", "motion_dual"})

    def __call__(self, moment: Moment, warped_target: Tensor, motion: Tensor) -> Tensor:
        assert moment.motion is not None
        assert moment.motion_dual is not None
        height, width = motion.shape[-2:]
        return (~disoccluded(moment.motion, moment.motion_dual, (height, width))).to(motion.dtype)


@final
class Photometric(Visibility):
    """``exp(-50 ||I_t - warped I_t-1||^2)`` of the target's frames, the visibility mask of the paper's temporal
    losses, for data without dual motion; 0 outside of the previous image. It also hides what the reference itself
    changes, such as moving shadows.

    50 is the paper's alpha, and that of the authors' ``train.py``. That code squares the sum of the channels' differences, in
    which opposite ones cancel; here it is the norm, as the paper and the code's own comment have it."""

    suffix = "_photometric"
    requires = frozenset({"motion"})

    def __call__(self, moment: Moment, warped_target: Tensor, motion: Tensor) -> Tensor:
        distance = (moment.target - warped_target).square().sum(dim=1, keepdim=True)
        return torch.where(outside(motion), 0.0, torch.exp(-50.0 * distance))


@final
class WarpingError(VideoMetric):
    """``warping_error`` of the output, that of the reference with the same weights, and their ratio, which is NaN where the
    reference's is 0. With `Photometric` the names end in ``_photometric``: another convention."""

    def __init__(self, visibility: Visibility) -> None:
        self._visibility = visibility
        base = f"warping_error{visibility.suffix}"
        self.names = (base, f"{base}_reference", f"{base}_ratio")
        self.requires = frozenset({"target"}) | visibility.requires

    def begin(self) -> Scoring:
        return _Warping(self.names, self._visibility)


@final
class _Warping(Scoring):
    def __init__(self, names: tuple[str, ...], visibility: Visibility) -> None:
        self._names = names
        self._visibility = visibility
        self._previous: tuple[Tensor, Tensor] | None = None
        self._sums = (0.0, 0.0)
        self._pairs = 0

    def add(self, moment: Moment) -> None:
        if self._previous is not None:
            assert moment.motion is not None
            height, width = moment.target.shape[-2:]
            motion = upsample_motion(moment.motion, (height, width))
            output, target = (warp(image, motion) for image in self._previous)
            weight = self._visibility(moment, target, motion)
            total = weight.sum()
            if total > 0.0:  # a cut shares no pixel: such a pair has no error
                errors = ((moment.output, output), (moment.target, target))
                a, b = (
                    ((now - then).square().mean(dim=1, keepdim=True) * weight).sum() / total for now, then in errors
                )
                self._sums = (self._sums[0] + a.item(), self._sums[1] + b.item())
                self._pairs += 1
        self._previous = (moment.output, moment.target)

    def finish(self) -> dict[str, float]:
        if self._pairs == 0:
            return dict.fromkeys(self._names, float("nan"))
        output, reference = (value / self._pairs for value in self._sums)
        ratio = output / reference if reference > 0.0 else float("nan")
        return dict(zip(self._names, (output, reference, ratio)))
