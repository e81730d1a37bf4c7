"""Sub-pixel jitter sequences: offsets ``(x, y)`` from the pixel centre in low-resolution pixels, in [-0.5, 0.5)."""

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError

# DLCTUS section 4.2.2 and figure 6. The text gives the positions (every high-resolution pixel's centre, none next to
# its predecessor); the figure with the order did not survive, so the order is ours: no two consecutive positions
# touch, corners, the pattern's repetition and its tiling over the image included. (row, column) of the 4x4 grid.
_ORDER_4X4 = (
    (0, 0), (2, 2), (0, 2), (2, 0), (0, 1), (2, 3), (0, 3), (2, 1),
    (3, 3), (1, 1), (3, 1), (1, 3), (3, 2), (1, 0), (3, 0), (1, 2),
)  # fmt: skip

# "The HR-pixels are iterated over in a hourglass pattern": top edge, diagonal, bottom edge, diagonal. (row, column)
_HOURGLASS = ((0, 0), (0, 1), (1, 0), (1, 1))


def van_der_corput(n: int, base: int) -> float:
    """``h_b(n)`` of DLCTUS equation 25."""
    value, digit = 0.0, 1.0 / base
    while n > 0:
        n, remainder = divmod(n, base)
        value += remainder * digit
        digit /= base
    return value


def halton(length: int) -> NDArray[np.float32]:
    """The first ``length`` elements of Halton(2,3) (DLCTUS equation 26), from n = 1, centred: ``(length, 2)``."""
    points = [(van_der_corput(n, 2) - 0.5, van_der_corput(n, 3) - 0.5) for n in range(1, length + 1)]
    return np.array(points, dtype=np.float32)


def thesis_4x4() -> NDArray[np.float32]:
    """The centres of the 16 high-resolution pixels: ``(16, 2)`` (DLCTUS 4.2.2)."""
    return np.array([((j + 0.5) / 4 - 0.5, (i + 0.5) / 4 - 0.5) for i, j in _ORDER_4X4], dtype=np.float32)


def thesis_2x2() -> NDArray[np.float32]:
    """Elements 2 to 5 of Halton(2,3) within each high-resolution pixel, in hourglass order: ``(16, 2)`` (DLCTUS 4.2.2)."""
    points = [
        ((j + van_der_corput(n, 2)) / 2 - 0.5, (i + van_der_corput(n, 3)) / 2 - 0.5)
        for n in (2, 3, 4, 5)
        for i, j in _HOURGLASS
    ]
    return np.array(points, dtype=np.float32)


def jitter_sequence(pattern: str, scale: int) -> NDArray[np.float32]:
    """One period of a jitter pattern by its configured name.

    ``thesis`` is the thesis's own at scale 4 and 2 and Halton(2,3) of 16 at the others, ``haltonN`` the first N elements
    of Halton(2,3), ``none`` no jitter.

    Raises:
        UserError: another name.
    """
    if pattern == "none":
        return np.zeros((1, 2), dtype=np.float32)
    if pattern == "thesis":
        own = {4: thesis_4x4, 2: thesis_2x2}
        return own[scale]() if scale in own else halton(16)
    length = pattern.removeprefix("halton")
    if pattern.startswith("halton") and length.isdigit() and int(length) > 0:
        return halton(int(length))
    raise UserError(f"task.jitter={pattern} is not a pattern: use thesis, halton16 (or any length) or none.")


def mip_bias(setting: str, scale: int) -> float:
    """The low-resolution mip bias that matches the target, equation 47 of DLCTUS.

    ``matched`` (the thesis's data set 1) matches one sample per target pixel, ``sharp`` (data set 2) matches four.

    Raises:
        UserError: another name.
    """
    return -float(np.log2(scale)) + target_mip_bias(setting)


def target_mip_bias(setting: str) -> float:
    """The mip bias of the target itself: ``-log2(spp) / 2`` of DLCTUS equation 47, relative to its own pixels."""
    matched_samples = {"matched": 1, "sharp": 4}
    if setting not in matched_samples:
        raise UserError(f"task.mip_bias={setting} is not a setting: use matched (1 sample) or sharp (4 samples).")
    return -0.5 * float(np.log2(matched_samples[setting]))
