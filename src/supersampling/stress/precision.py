"""Number formats, and how far from float64 each may be."""

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass

from supersampling.deploy import quantise
from supersampling.errors import UserError
from supersampling.models.precision import autocast, missing_convolution


@dataclass(frozen=True)
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
        return self.largest, self.mean

    @property
    def tolerance(self) -> str:
        return f"{self.largest:g} / {self.mean:g}"

    def context(self, device: str) -> AbstractContextManager[object]:
        return autocast(device, self.name)


STEP = 1.0 / 255.0
PRECISIONS = {
    p.name: p
    for p in (
        Precision("float32", STEP / 2, 1e-5,
                  "Half a step of 8 bits, so that an image is never seen to change; in the mean 10^-5, of which a dozen "
                  "convolutions' rounding is a tenth."),
        Precision("bfloat16", 32 * STEP, 4 * STEP,
                  "8 binary digits are a rounding of 2^-9, half a step of 8 bits, in each of about ten layers and again in each "
                  "frame: 4 steps in the mean, and 8 times as much in single pixels."),
        Precision("float16", 4 * STEP, STEP / 2,
                  "11 digits, an eighth of bfloat16's rounding."),
        Precision("int8", 64 * STEP, 8 * STEP, "7 digits and a sign, twice bfloat16's rounding."),
    )
}  # fmt: skip

INT8 = PRECISIONS["int8"]


def lacks(name: str, device: str) -> str:
    """Why this device cannot compute in a precision; empty if it can."""
    return quantise.missing().rstrip(".") if name == "int8" else missing_convolution(device, name)


def chosen(names: Sequence[str] | None, device: str) -> list[Precision]:
    """The precisions called ``names``; None takes all that the device has, and int8, so that its rows say why there are none.

    Raises:
        UserError: an unknown one, or one that the device lacks.
    """
    if names is None:
        return [p for name, p in PRECISIONS.items() if name == "int8" or not lacks(name, device)]
    for name in names:
        if name not in PRECISIONS:
            raise UserError(f"precisions holds {name}, which is none: use a list of {', '.join(PRECISIONS)}.")
        if why := lacks(name, device):
            raise UserError(f"precisions={name} is not possible: {why}; leave it out.")
    return [PRECISIONS[name] for name in names]
