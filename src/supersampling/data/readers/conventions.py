"""What the two channels of a file's vectors hold: captures disagree on order and sign more than on anything else."""

import re
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError

AXES = {"x": 0, "y": 1}
FACTORS = ("", "*0.5", "*2")
"""Motion counted in image sizes, or by the coordinates of clip space, of which an image has 2, either way round."""
_NAME = re.compile(r"(-?x-?y|-?y-?x)(?:\*(0\.5|2))?")


@dataclass(frozen=True)
class Convention:
    """Which of our components a file's first and second channel hold, with which sign, and what ours is a multiple of.

    Ours: motion is ``previous - current`` in units of the image, jitter the sample's offset from the pixel's centre, x right,
    y down (`supersampling.frames`). ``y-x`` says: the first channel holds our y, the second our x negated. ``y-x*0.5`` says
    the same of values that have to be halved.
    """

    name: str

    @classmethod
    def parse(cls, name: str) -> "Convention":
        """Raises `UserError` unless ``name`` is a convention's."""
        if not _NAME.fullmatch(name):
            raise UserError(
                f"There is no convention {name!r}: use one of {', '.join(c.name for c in CONVENTIONS)}, perhaps with *0.5 or *2 "
                "behind it."
            )
        return cls(name)

    @property
    def axes(self) -> str:
        """The name without its factor."""
        return self.name.partition("*")[0]

    @property
    def suffix(self) -> str:
        """The factor as it stands in the name, one of `FACTORS`."""
        return self.name.removeprefix(self.axes)

    @property
    def _channels(self) -> list[tuple[float, int]]:
        factor = float(self.suffix.removeprefix("*") or 1.0)
        found: list[str] = re.findall(r"-?[xy]", self.axes)
        return [(-factor if len(term) == 2 else factor, AXES[term[-1]]) for term in found]

    def decode(self, channels: NDArray[np.float32]) -> NDArray[np.float32]:
        """A file's channels ``(..., 2)`` as our (x, y)."""
        out = np.empty_like(channels)
        for k, (factor, axis) in enumerate(self._channels):
            out[..., axis] = factor * channels[..., k]
        return out

    def encode(self, vectors: NDArray[np.float32]) -> NDArray[np.float32]:
        """Our (x, y) ``(..., 2)`` as a file's channels: the inverse of `decode`."""
        return np.stack([vectors[..., axis] / np.float32(factor) for factor, axis in self._channels], axis=-1)

    def variants(self) -> list["Convention"]:
        """All eight orders and signs, with this one's factor."""
        return [Convention(c.name + self.suffix) for c in CONVENTIONS]


CONVENTIONS = tuple(
    Convention(f"{first}{a}{second}{b}") for a, b in ("xy", "yx") for first, second in product(("", "-"), repeat=2)
)
