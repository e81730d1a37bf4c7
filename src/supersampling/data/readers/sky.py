"""The sky in depth files of unknown unit: renderers mark pixels without a surface by a value that is no distance."""

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from supersampling.data.readers.images import Image
from supersampling.errors import UserError

ENDLESS = 1e9  # Blender writes 1e10, other programs 1e30, the largest float or infinity
LARGEST_HALF = (65504.0, 65535.0)  # what remains of those in half floats and in 16 bits
GAP = 100.0  # a value that many pixels share, this many times beyond all others, is a mark as well
TOP = 4  # largest values of a frame that are looked at: marks and at least one distance
STEP = 61  # every such pixel is a sample of the distances


@dataclass(frozen=True)
class DepthScale:
    """The captured depth that becomes 1, and the values that mean sky, which becomes 1 as well."""

    unit: float
    marks: frozenset[float]
    share: float = 0.0
    """Share of pixels with a mark."""

    def decode(self, stored: Image, reversed_depth: bool) -> Image:
        """Return captured depth as depth in [0, 1], 1 in the sky."""
        sky = np.isin(stored, np.array(sorted(self.marks), dtype=np.float32)) | (stored >= ENDLESS)
        depth = np.minimum(np.where(sky, np.float32(0.0), stored) / np.float32(self.unit), np.float32(1.0))
        return np.where(sky, np.float32(1.0), 1.0 - depth if reversed_depth else depth)

    def summary(self) -> str:
        """Return one line for the user, without its end."""
        unit = f"captured depth is divided by {self.unit:g}" if self.unit != 1.0 else "captured depth is kept"
        if not self.marks:
            return unit
        verb = "counts as sky and becomes" if len(self.marks) == 1 else "count as sky and become"
        marks = " and ".join(f"{mark:g}" for mark in sorted(self.marks))
        return f"{unit}; {marks} ({self.share:.1%} of the pixels) {verb} 1"


def measure_depth(files: Iterable[tuple[Path, Image]], reversed_depth: bool) -> DepthScale:
    """Return the scale of a capture's depth: 1 for depth in [0, 1], else the power of ten above the largest distance.

    The unit is not documented, so the marks of the sky are recognised by their values: infinity, at least `ENDLESS`,
    the largest half or 16-bit number, a single negative value, a value far beyond all others that several pixels share,
    and 0 among distances that exceed 1, since no surface touches the camera.

    Raises:
        UserError: several values are negative, no pixel shows a surface, or the sky was averaged with surfaces.
    """
    top, negative = Counter[float](), Counter[float]()
    samples, zeros, pixels = [], 0, 0
    for path, depth in files:
        values, counts = np.unique(depth, return_counts=True)
        below = values < 0.0
        negative.update(dict(zip(values[below].tolist(), counts[below].tolist())))
        if len(negative) > 1:
            raise UserError(
                f"{path} has negative depths, down to {depth.min():.4g}: export depth that grows away from the camera."
            )
        real = values < ENDLESS
        top.update(dict(zip(values[~real].tolist(), counts[~real].tolist())))
        top.update(dict(zip(values[real & ~below][-TOP:].tolist(), counts[real & ~below][-TOP:].tolist())))
        zeros += int(counts[values == 0.0].sum())
        pixels += depth.size
        samples.append(depth.reshape(-1)[::STEP])
        folder = path.parent
    marks = {**negative, **_marks(top)}
    distances = [value for value in top if value not in marks]
    if not distances:
        raise UserError(f"{folder} shows no surface, only {', '.join(f'{m:g}' for m in marks)}: export depth again.")
    largest = max(distances)
    unit = 1.0 if largest <= 1.0 else 10.0 ** math.ceil(math.log10(largest))
    if largest > 1.0 and zeros and not reversed_depth:
        marks[0.0] = zeros
    sample = np.concatenate(samples)
    surfaces = sample[~np.isin(sample, np.array(sorted(marks), dtype=np.float32)) & (sample < ENDLESS)]
    if marks and len(surfaces) and largest > GAP * float(np.quantile(surfaces, 0.99)) and largest > 1.0:
        raise UserError(
            f"{folder} has depths up to {largest:.4g} beside a sky of {max(marks):g}, but 99% lie below "
            f"{float(np.quantile(surfaces, 0.99)):.4g}: surfaces seem to be averaged with the sky, export depth "
            "without a filter."
        )
    return DepthScale(unit, frozenset(marks), sum(marks.values()) / pixels)


def _marks(top: Counter[float]) -> dict[float, int]:
    """Return the marks among the largest values of all frames with their numbers of pixels."""
    values = sorted(top, reverse=True)
    marks = {}
    for value, following in zip(values, [*values[1:], 0.0]):
        shared = top[value] > 1 and value > max(1.0, GAP * following) and following > 0.0
        if not (value >= ENDLESS or value in LARGEST_HALF or shared):
            break
        marks[value] = top[value]
    return marks
