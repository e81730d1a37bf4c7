"""Number formats, and their tolerated distance from float64."""

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass

from supersampling.deploy import quantise
from supersampling.errors import UserError
from supersampling.models.precision import autocast, missing_convolution


@dataclass(frozen=True, kw_only=True)
class Precision:
    """A number format: weights and buffers stay float32, convolutions are computed in it, as in training.

    ``largest`` and ``mean`` are the tolerances, in units of the output's range; ``reason`` says where they come from.
    """

    name: str
    largest: float
    mean: float
    reason: str

    @property
    def limits(self) -> tuple[float, float]:
        """The tolerances of the largest and of the mean error."""
        return self.largest, self.mean

    @property
    def tolerance(self) -> str:
        """The tolerances as text."""
        return f"{self.largest:g} / {self.mean:g}"

    def context(self, device: str) -> AbstractContextManager[object]:
        """Return the context in which a model computes in this precision."""
        return autocast(device, self.name)


STEP = 1.0 / 255.0
FLOAT32 = Precision(
    name="float32",
    largest=STEP / 2,
    mean=1e-5,
    reason="Half a step of 8 bits, so that no image visibly changes; in the mean 10^-5, of which the rounding of a "
    "dozen convolutions is a tenth.",
)
BFLOAT16 = Precision(
    name="bfloat16",
    largest=32 * STEP,
    mean=4 * STEP,
    reason="8 binary digits are a rounding of 2^-9, half a step of 8 bits, in each of about ten layers and again in "
    "each frame: 4 steps in the mean, and 8 times as much in single pixels.",
)
FLOAT16 = Precision(
    name="float16", largest=4 * STEP, mean=STEP / 2, reason="11 digits, an eighth of bfloat16's rounding."
)
INT8 = Precision(
    name="int8", largest=64 * STEP, mean=8 * STEP, reason="7 digits and a sign, twice bfloat16's rounding."
)
PRECISIONS = {precision.name: precision for precision in (FLOAT32, BFLOAT16, FLOAT16, INT8)}


def explain_missing(name: str, device: str) -> str:
    """Return the reason that this device cannot compute in a precision; empty if it can."""
    return quantise.missing().rstrip(".") if name == "int8" else missing_convolution(device, name)


def select_precisions(names: Sequence[str] | None, device: str) -> list[Precision]:
    """Return the precisions called ``names``.

    None selects all that the device has, and int8 in any case, so that its cells say why they were not tried.

    Raises:
        UserError: a precision is unknown, or the device does not have it.
    """
    if names is None:
        return [p for name, p in PRECISIONS.items() if name == "int8" or not explain_missing(name, device)]
    for name in names:
        if name not in PRECISIONS:
            raise UserError(f"Unknown precision {name}: use {', '.join(PRECISIONS)}.")
        if reason := explain_missing(name, device):
            raise UserError(f"Precision {name} is not available: {reason}; remove it from precisions.")
    return [PRECISIONS[name] for name in names]
