"""The warping error of Lai et al. 2018, "Learning Blind Video Temporal Consistency" (evaluation).

``E(V_t, V_t+1) = 1 / sum(M) sum(M ||V_t - warped V_t+1||^2)``, averaged over the clip's pairs of frames; as in the
authors' code the sum in the denominator includes the colour channels, so that it is a mean squared error of values in
[0, 1]. Here the previous frame is warped to the current one, bilinearly, by the renderer's motion. Blur lowers the
error below that of the
reference: compare it with ``_reference``.

The authors' code is ``evaluate_WarpError.py`` of github.com/phoenix104104/fast_blind_video_consistency: there a pair of
frames without a visible pixel counts as an error of 0, here it does not count.
"""

from abc import ABC, abstractmethod
from typing import final

import torch
from torch import Tensor

from supersampling.metrics.base import Moment
from supersampling.metrics.regions import disoccluded
from supersampling.metrics.video.base import Scoring, VideoMetric
from supersampling.ops.resample import upsample_motion
from supersampling.ops.warp import outside, warp


class Visibility(ABC):
    """Base class of the visibility of pixels in two frames: the weights ``M (1, 1, H, W)`` in [0, 1]."""

    suffix: str
    requires: frozenset[str]

    @abstractmethod
    def __call__(self, moment: Moment, warped_target: Tensor, motion: Tensor) -> Tensor:
        """Return the weights; ``warped_target`` is the previous target, both arguments are at target resolution."""


@final
class DualMotion(Visibility):
    """1 where the point was visible in the previous image; 0 where it was hidden (NSRD's motion mask) or outside."""

    suffix = ""
    requires = frozenset({"motion", "motion_dual"})

    def __call__(self, moment: Moment, warped_target: Tensor, motion: Tensor) -> Tensor:
        assert moment.motion is not None
        assert moment.motion_dual is not None
        height, width = motion.shape[-2:]
        return (~disoccluded(moment.motion, moment.motion_dual, (height, width))).to(motion.dtype)


@final
class Photometric(Visibility):
    """``exp(-50 ||I_t - warped I_t-1||^2)`` of the target's frames, for data without dual motion; 0 outside of the
    previous image.

    This is the visibility mask of the paper's temporal losses. It also hides changes of the reference, such as moving
    shadows. 50 is the paper's alpha, and that of the authors' ``train.py``. That code squares the sum of the channels'
    differences, in which opposite signs cancel; here it is the norm, as in the paper and in the code's comment.
    """

    suffix = "_photometric"
    requires = frozenset({"motion"})

    def __call__(self, moment: Moment, warped_target: Tensor, motion: Tensor) -> Tensor:
        distance = (moment.target - warped_target).square().sum(dim=1, keepdim=True)
        return torch.where(outside(motion), 0.0, torch.exp(-50.0 * distance))


@final
class WarpingError(VideoMetric):
    """``warping_error`` of the output, ``warping_error_reference`` of the target with the same weights, and their ratio
    ``warping_error_ratio``, which is NaN where the error of the reference is 0. With `Photometric`, another convention,
    the names begin with ``warping_error_photometric``."""

    better = {"warping_error*_reference": "neither", "warping_error*_ratio": "neither", "warping_error*": "lower"}

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
            # The frames around a cut share no pixel: such a pair has no error.
            if total > 0.0:
                pairs = ((moment.output, output), (moment.target, target))
                errors = [((x - y).square().mean(dim=1, keepdim=True) * weight).sum() / total for x, y in pairs]
                self._sums = (self._sums[0] + errors[0].item(), self._sums[1] + errors[1].item())
                self._pairs += 1
        self._previous = (moment.output, moment.target)

    def finish(self) -> dict[str, float]:
        if self._pairs == 0:
            return dict.fromkeys(self._names, float("nan"))
        output, reference = (value / self._pairs for value in self._sums)
        ratio = output / reference if reference > 0.0 else float("nan")
        return dict(zip(self._names, (output, reference, ratio)))
