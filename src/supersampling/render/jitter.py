"""Sub-pixel jitter sequences: offsets ``(x, y)`` from the pixel centre in low-resolution pixels, in [-0.5, 0.5)."""

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError

# DLCTUS section 4.2.2 and figure 6. The text gives the positions (every high-resolution pixel's centre, none next to
# its predecessor); the figure with the order is not readable, so this order is our own: no two consecutive positions
# touch, not even at corners, across the pattern's repetition or across its tiling over the image.
# Cells of the 4x4 grid are numbered row by row.
_ORDER_4X4 = (0, 10, 2, 8, 1, 11, 3, 9, 15, 5, 13, 7, 14, 4, 12, 6)

# "The HR-pixels are iterated over in a hourglass pattern": top edge, diagonal, bottom edge, diagonal. (row, column)
_HOURGLASS = ((0, 0), (0, 1), (1, 0), (1, 1))


def van_der_corput(n: int, base: int) -> float:
    """Return ``h_b(n)`` of DLCTUS equation 25, the radical inverse of ``n`` in [0, 1)."""
    value, digit = 0.0, 1.0 / base
    while n > 0:
        n, remainder = divmod(n, base)
        value += remainder * digit
        digit /= base
    return value


def halton(length: int) -> NDArray[np.float32]:
    """Return the elements n = 1 to ``length`` of Halton(2,3) (DLCTUS equation 26), minus 1/2: ``(length, 2)``."""
    points = [(van_der_corput(n, 2) - 0.5, van_der_corput(n, 3) - 0.5) for n in range(1, length + 1)]
    return np.array(points, dtype=np.float32)


def thesis_4x4() -> NDArray[np.float32]:
    """Return the centres of the 16 high-resolution pixels: ``(16, 2)`` (DLCTUS 4.2.2)."""
    cells = (divmod(cell, 4) for cell in _ORDER_4X4)
    return np.array([((j + 0.5) / 4 - 0.5, (i + 0.5) / 4 - 0.5) for i, j in cells], dtype=np.float32)


def thesis_2x2() -> NDArray[np.float32]:
    """Return elements 2 to 5 of Halton(2,3) in each high-resolution pixel, in hourglass order: ``(16, 2)``.

    Source: DLCTUS 4.2.2.
    """
    points = [
        ((j + van_der_corput(n, 2)) / 2 - 0.5, (i + van_der_corput(n, 3)) / 2 - 0.5)
        for n in (2, 3, 4, 5)
        for i, j in _HOURGLASS
    ]
    return np.array(points, dtype=np.float32)


def jitter_sequence(pattern: str, scale: int) -> NDArray[np.float32]:
    """Return one period of the jitter pattern with this configured name.

    ``thesis`` is the thesis's own pattern at scales 4 and 2 and 16 elements of Halton(2,3) at the others, ``haltonN``
    the first N elements of Halton(2,3), ``none`` no jitter.

    Raises:
        UserError: The name is unknown.
    """
    if pattern == "none":
        return np.zeros((1, 2), dtype=np.float32)
    if pattern == "thesis":
        patterns = {4: thesis_4x4, 2: thesis_2x2}
        return patterns[scale]() if scale in patterns else halton(16)
    length = pattern.removeprefix("halton")
    if pattern.startswith("halton") and length.isdigit() and int(length) > 0:
        return halton(int(length))
    raise UserError(f"Invalid task.jitter={pattern}: use thesis, halton16 (or any length) or none.")


def mip_bias(setting: str, scale: int) -> float:
    """Return the low-resolution mip bias that matches the target (DLCTUS equation 47).

    ``matched`` (the thesis's data set 1) matches one sample per target pixel, ``sharp`` (data set 2) matches four.

    Raises:
        UserError: The setting is unknown.
    """
    return -float(np.log2(scale)) + target_mip_bias(setting)


def target_mip_bias(setting: str) -> float:
    """Return the target's own mip bias relative to its pixels: ``-log2(spp) / 2`` of DLCTUS equation 47."""
    matched_samples = {"matched": 1, "sharp": 4}
    if setting not in matched_samples:
        raise UserError(f"Invalid task.mip_bias={setting}: use matched (1 sample) or sharp (4 samples).")
    return -0.5 * float(np.log2(matched_samples[setting]))
