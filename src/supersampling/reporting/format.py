"""Numbers and intervals as text: of tables and figures with typographic signs, of the terminal in plain ASCII."""

import math

from supersampling.runs.statistics import Estimate

UNRESOLVED = "unresolved"


def typeset(text: str) -> str:
    """Return numbers with a minus sign (U+2212) and the infinity sign in place of ``-`` and ``inf``."""
    return text.replace("-", "−").replace("inf", "∞")


def fixed(value: float, places: int, sign: bool = False) -> str:
    """Return a number with ``places`` decimals, with ``sign`` a plus sign as well; empty for NaN."""
    return "" if math.isnan(value) else f"{value:{'+' if sign else ''}.{places}f}"


def short(value: float) -> str:
    """Return a number with three significant digits, and all digits of the integer part from 1000 on."""
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


def thousands(value: float, sign: bool = False) -> str:
    """Return a whole number with a space between groups of three digits; empty for NaN."""
    return "" if math.isnan(value) else f"{value:{'+' if sign else ''},.0f}".replace(",", " ")


def decimals(half_width: float) -> int:
    """Return the number of decimals that shows two digits of the half-width; 4 where there is none."""
    if not half_width > 0 or math.isinf(half_width):
        return 4
    # 9.96 becomes 10, which needs no decimal.
    rounded = float(f"{half_width:.1e}")
    return min(8, max(0, 1 - math.floor(math.log10(rounded))))


def plus_minus(value: Estimate, places: int, sign: bool = False) -> str:
    """Return ``mean ± half-width``, the mean alone where there is no interval; with ``sign``, a plus sign as well."""
    mean = fixed(value.mean, places, sign)
    return mean if math.isnan(value.half_width) else f"{mean} ± {value.half_width:.{places}f}"


def span(value: Estimate, places: int, sign: bool = True) -> str:
    """Return the ends of an interval as ``low to high``."""
    return f"{fixed(value.low, places, sign)} to {fixed(value.high, places, sign)}"


def unless_resolved(value: Estimate) -> str:
    """Return ``, unresolved`` if the interval includes 0, else nothing."""
    return "" if value.resolved else f", {UNRESOLVED}"
