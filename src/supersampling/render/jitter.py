"""Sub-pixel jitter sequences: offsets ``(x, y)`` from the pixel centre in low-resolution pixels, in [-0.5, 0.5)."""

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError

# DLCTUS section 4.2.2 gives the positions, and figure 6, which is not readable, their order. The orders are therefore
# those of its author's program (`Jitter::Custom` of Rendering/aa/taa/jitter.h). Pixels are (column, row) of the high
# resolution within a low-resolution pixel.
_ORDER_4X4 = "21 02 23 00 12 33 10 31 03 20 01 22 30 11 32 13"

# "The HR-pixels are iterated over in a hourglass pattern": diagonal, edge, diagonal, edge.
_HOURGLASS = ((0, 0), (1, 1), (0, 1), (1, 0))
# The four elements of Halton(2,3), starting with another one in each turn, so that each pixel gets all of them.
_ELEMENTS = (2, 3, 4, 5)


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
    pixels = ((int(pixel[0]), int(pixel[1])) for pixel in _ORDER_4X4.split())
    return np.array([((x + 0.5) / 4 - 0.5, (y + 0.5) / 4 - 0.5) for x, y in pixels], dtype=np.float32)


def thesis_2x2() -> NDArray[np.float32]:
    """Return elements 2 to 5 of Halton(2,3) in each high-resolution pixel, in hourglass order: ``(16, 2)``.

    Source: DLCTUS 4.2.2.
    """
    points = [
        ((x + van_der_corput(n, 2)) / 2 - 0.5, (y + van_der_corput(n, 3)) / 2 - 0.5)
        for turn in range(4)
        for (x, y), n in zip(_HOURGLASS, _ELEMENTS[turn:] + _ELEMENTS[:turn])
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
    """Return the mip bias of the low resolution, relative to its own pixels (DLCTUS equation 47).

    ``matched`` (the thesis's data set 1) matches one sample per target pixel, ``sharp`` (data set 2) matches four.
    ``supersampledN`` is as ``matched``; only its target differs.

    Raises:
        UserError: The setting is unknown.
    """
    return -float(np.log2(scale)) + _biases(setting)[0]


def target_mip_bias(setting: str) -> float:
    """Return the target's own mip bias, relative to its pixels.

    It is ``-log2(spp) / 2`` of DLCTUS equation 47, and ``-log2(N)`` for ``supersampledN``: references are rendered at N
    times the resolution on each axis, without bias, before they are averaged (NSRR 3.4: 3; NSRD 4.1 and QRISP, Mercier
    et al. 2023, section 3: 2).

    Raises:
        UserError: The setting is unknown.
    """
    return _biases(setting)[1]


def _biases(setting: str) -> tuple[float, float]:
    """Return the levels of the low resolution and of the target, relative to one sample per target pixel."""
    if setting == "matched":
        return 0.0, 0.0
    if setting == "sharp":
        return -1.0, -1.0
    factor = setting.removeprefix("supersampled")
    if factor != setting and factor.isdigit() and int(factor) > 0:
        return 0.0, -float(np.log2(int(factor)))
    raise UserError(
        f"Invalid task.mip_bias={setting}: use matched (1 sample), sharp (4 samples) or supersampled2 (or another "
        "factor on each axis)."
    )
