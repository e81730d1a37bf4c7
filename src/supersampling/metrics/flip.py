"""FLIP by its authors' tool ``flip-evaluator``: for display colours (Andersson et al. 2020) and for radiance (2021).

A frame's value is the mean of its error map: 0 for identical images, 1 for the largest possible difference of two
colours.
"""

import math
from typing import Any, final

import flip_evaluator
import numpy as np
from torch import Tensor

from supersampling.errors import UserError
from supersampling.metrics.base import FrameMetric, Moment

PIXELS_PER_DEGREE = 0.7 * (3840 / 0.7) * (math.pi / 180)
"""67.02, the tool's default: a display 3840 pixels and 0.7 m wide, seen from 0.7 m."""


@final
class FLIP(FrameMetric):
    """``flip`` of sRGB display colours in [0, 1].

    Args:
        pixels_per_degree: pixels per degree of visual angle, positive. Fewer means that the viewer is nearer to the
            display and sees more.
    """

    better = {"flip": "lower"}

    def __init__(self, pixels_per_degree: float = PIXELS_PER_DEGREE) -> None:
        self._parameters = {"ppd": _checked(pixels_per_degree)}

    def measure(self, moment: Moment) -> list[float]:
        return [_mean_flip(moment.output, moment.target, "LDR", self._parameters)]


@final
class FLIPHDR(FrameMetric):
    """``flip_hdr`` of linear radiance: for each pixel the largest `FLIP` over exposures from ``2^start`` to ``2^stop``,
    each tone mapped by the tool's ACES curve. NaN for a method without radiance.

    By default the tool chooses different exposures for every frame, so that the frames of a clip are not comparable;
    here all frames have the same. Time grows with their number.

    Args:
        start: the darkest exposure, in stops; 0 leaves radiance at the scene's exposure.
        stop: the brightest exposure, greater than ``start``.
        number: the number of exposures, evenly spaced, at least 2; the tool's default is ``ceil(stop - start)``.
        pixels_per_degree: as for `FLIP`.
    """

    better = {"flip_hdr": "lower"}
    requires = frozenset({"target", "target_radiance"})

    def __init__(self, start: float, stop: float, number: int, pixels_per_degree: float = PIXELS_PER_DEGREE) -> None:
        if not (math.isfinite(start) and math.isfinite(stop) and start < stop):
            raise UserError(
                f"Invalid exposures of flip_hdr, start={start} and stop={stop}: use start below stop, such as -3 and 3."
            )
        # For a single exposure the tool returns 0 whatever the images are.
        if number < 2:
            raise UserError(f"Invalid number={number} of exposures of flip_hdr: use at least 2.")
        self._parameters = {
            "ppd": _checked(pixels_per_degree),
            "startExposure": float(start),
            "stopExposure": float(stop),
            "numExposures": int(number),
            "tonemapper": "aces",
        }

    def measure(self, moment: Moment) -> list[float]:
        return [math.nan if moment.radiance is None else _mean_flip(*moment.radiance, "HDR", self._parameters)]


def _checked(pixels_per_degree: float) -> float:
    if not 0.0 < pixels_per_degree < math.inf:
        raise UserError(
            f"Invalid pixels_per_degree={pixels_per_degree}: use a positive number; the tool's default is 67.02."
        )
    return float(pixels_per_degree)


def _mean_flip(output: Tensor, target: Tensor, dynamic_range: str, parameters: dict[str, Any]) -> float:
    """Return the mean error of one frame; both images are ``(1, 3, H, W)``."""
    _, mean, _ = flip_evaluator.evaluate(
        _array(target), _array(output), dynamic_range, applyMagma=False, parameters=dict(parameters)
    )
    return float(mean)


def _array(image: Tensor) -> np.ndarray:
    """Return the image as ``(H, W, 3)``, float32, contiguous."""
    array: np.ndarray = image[0].permute(1, 2, 0).float().contiguous().cpu().numpy()
    return array
