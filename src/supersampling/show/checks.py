"""Measurements on a clip: the errors of its motion vectors, its disocclusions, and the smoothness of its lighting
relative to its radiance."""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from supersampling.ops.demodulate import demodulate
from supersampling.ops.resample import upsample_motion
from supersampling.ops.warp import outside, warp
from supersampling.show.clip import Array, ClipView

MASK_THRESHOLD = 0.1  # low-resolution pixels (Li et al. 2024, NSRD, section 3.2)


@dataclass(frozen=True, eq=False)
class WarpCheck:
    """The previous target warped to the current one, ``warped (3, H, W)``, and its errors.

    ``error`` and ``still_error (H, W)`` are the absolute differences of the warped and of the unwarped previous target
    to the current one, means over the channels; ``inside (H, W)``: the previous position is in the image.
    """

    warped: Array
    error: Array
    still_error: Array
    inside: NDArray[np.bool_]

    @property
    def mean(self) -> float:
        """Return the mean error of the warped target over the pixels inside, in [0, 1]; NaN without such pixels."""
        return float(self.error[self.inside].mean()) if self.inside.any() else float("nan")

    @property
    def still_mean(self) -> float:
        """Return the mean error of the unwarped target, as `mean`."""
        return float(self.still_error[self.inside].mean()) if self.inside.any() else float("nan")


def compare_warped(previous: Array, target: Array, motion: Array) -> WarpCheck:
    """Warp ``previous (3, H, W)`` by ``motion``, ``(2, H, W)`` or low-resolution ``(2, h, w)``, and compare with
    ``target``.

    Vectors that are not finite count as leaving the image.
    """
    vectors = torch.from_numpy(np.where(np.isfinite(motion), motion, np.float32(2.0)))[None]
    if motion.shape[-2:] != target.shape[-2:]:
        vectors = upsample_motion(vectors, (target.shape[-2], target.shape[-1]))
    warped = warp(torch.from_numpy(previous)[None], vectors)[0].numpy()
    return WarpCheck(
        warped=warped,
        error=np.abs(warped - target).mean(axis=0),
        still_error=np.abs(previous - target).mean(axis=0),
        inside=~outside(vectors)[0, 0].numpy(),
    )


def check_warp(clip: ClipView, frame: int) -> WarpCheck | None:
    """Return the check of a frame; None if one of the two targets or the motion is missing.

    High-resolution motion vectors are preferred if the clip has them.
    """
    motion = clip.find(frame, "high_motion", "motion")
    if motion is None or not clip.has("target", frame) or not clip.has("target", frame - 1):
        return None
    return compare_warped(clip.read("target", frame - 1), clip.read("target", frame), clip.read(motion, frame))


def disoccluded(motion: Array, dual: Array, threshold: float = MASK_THRESHOLD) -> NDArray[np.bool_]:
    """Return the motion mask ``(h, w)`` of NSRD, section 3.2: the vectors differ by at least ``threshold`` pixels on an
    axis.

    Both vectors are ``(2, h, w)``.
    """
    height, width = motion.shape[-2:]
    pixels = np.abs(dual - motion) * np.array((width, height), dtype=np.float32)[:, None, None]
    return (pixels >= threshold).any(axis=0)


def read_lighting(clip: ClipView, frame: int) -> Array | None:
    """Return demodulated lighting ``(3, h, w)``; None if radiance, material or emission is missing."""
    names = ("radiance", "material", "emission")
    if not all(clip.has(name, frame) for name in names):
        return None
    radiance, material, emission = (torch.from_numpy(clip.read(name, frame))[None] for name in names)
    return demodulate(radiance, material, emission)[0].numpy()


def gradient_energy(image: Array) -> float:
    """Return the mean squared difference of neighbours (both axes) divided by the mean square of ``(C, h, w)``.

    It does not depend on the image's unit; 0 for a black image.
    """
    values = image.astype(np.float64)
    power = float(np.square(values).mean())
    steps = sum(float(np.square(np.diff(values, axis=axis)).mean()) for axis in (-1, -2) if values.shape[axis] > 1)
    return steps / power if power > 0.0 else 0.0
