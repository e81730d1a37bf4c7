"""FLIP by its authors' own tool, ``flip-evaluator``: of display colours (Andersson et al. 2020) and of radiance (2021).

A frame's value is the mean of its error map: 0 is identical, 1 the most that two colours can differ.
"""

import math
from typing import Any, final

import flip_evaluator
import numpy as np
from torch import Tensor

from supersampling.errors import UserError
from supersampling.metrics.suite import Metric, Moment

PIXELS_PER_DEGREE = 0.7 * (3840 / 0.7) * (math.pi / 180)
"""67.02, the tool's own: a display 3840 pixels and 0.7 m wide, seen from 0.7 m."""


@final
class FLIP(Metric):
    """``flip`` of sRGB display colours in [0, 1].

    Args:
        pixels_per_degree: of visual angle, above 0: how far the viewer is from the display. Fewer is nearer, where more is seen.
    """

    names = ("flip",)
    requires = frozenset({"target"})

    def __init__(self, pixels_per_degree: float = PIXELS_PER_DEGREE) -> None:
        self._parameters = {"ppd": _checked(pixels_per_degree)}

    def __call__(self, moment: Moment) -> dict[str, float]:
        return {"flip": _mean_flip(moment.output, moment.target, "LDR", self._parameters)}


@final
class FLIPHDR(Metric):
    """``flip_hdr`` of linear radiance: the worst of `FLIP` at each pixel over exposures from ``2^start`` to ``2^stop``, each tone
    mapped by the tool's ACES curve. NaN where a method gives no radiance.

    The tool alone would choose other exposures for every frame, so that the frames of a clip were not comparable; here they are
    the same for all. Time grows with their number.

    Args:
        start: the darkest exposure, in stops; 0 leaves radiance as the scene's exposure has it.
        stop: the brightest, above ``start``.
        number: of exposures, evenly spaced, 2 or more; the tool takes ``ceil(stop - start)``.
        pixels_per_degree: as for `FLIP`.
    """

    names = ("flip_hdr",)
    requires = frozenset({"target", "target_radiance"})

    def __init__(self, start: float, stop: float, number: int, pixels_per_degree: float = PIXELS_PER_DEGREE) -> None:
        if not (math.isfinite(start) and math.isfinite(stop) and start < stop):
            raise UserError(f"flip_hdr needs start below stop, got {start} and {stop}: -3 and 3 are a choice.")
        # Of one exposure, the tool gives 0 whatever the images are.
        if number < 2:
            raise UserError(f"number of flip_hdr must be 2 or more, got {number}.")
        self._parameters = {
            "ppd": _checked(pixels_per_degree),
            "startExposure": float(start),
            "stopExposure": float(stop),
            "numExposures": int(number),
            "tonemapper": "aces",
        }

    def __call__(self, moment: Moment) -> dict[str, float]:
        if moment.radiance is None:
            return {"flip_hdr": math.nan}
        return {"flip_hdr": _mean_flip(*moment.radiance, "HDR", self._parameters)}


def _checked(pixels_per_degree: float) -> float:
    if not 0.0 < pixels_per_degree < math.inf:
        raise UserError(f"pixels_per_degree must be above 0, got {pixels_per_degree}; the tool's own is 67.02.")
    return float(pixels_per_degree)


def _mean_flip(output: Tensor, target: Tensor, dynamic_range: str, parameters: dict[str, Any]) -> float:
    """Of one frame, ``(1, 3, H, W)`` each."""
    _, mean, _ = flip_evaluator.evaluate(
        _array(target), _array(output), dynamic_range, applyMagma=False, parameters=dict(parameters)
    )
    return float(mean)


def _array(image: Tensor) -> np.ndarray:
    """``(H, W, 3)``, float32, contiguous."""
    array: np.ndarray = image[0].permute(1, 2, 0).float().contiguous().cpu().numpy()
    return array
