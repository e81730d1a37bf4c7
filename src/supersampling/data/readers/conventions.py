"""Conventions of the two channels of vectors in files: captures differ in their order and sign more than in anything
else."""

import re
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError

AXES = {"x": 0, "y": 1}
FACTORS = ("", "*0.5", "*2")
"""Units of motion relative to image sizes: equal, or half or twice for coordinates of clip space, where an image has
size 2."""
_NAME = re.compile(r"(-?x-?y|-?y-?x)(?:\*(0\.5|2))?")


@dataclass(frozen=True)
class Convention:
    """The components, signs and factor of a file's two channels relative to the project's vectors.

    In the project, motion is ``previous - current`` in units of the image, jitter is the sample's offset from the
    pixel's centre, x right, y down (`supersampling.frames`). ``y-x`` means: the first channel holds y, the second -x.
    ``y-x*0.5`` means the same for values that have to be halved.
    """

    name: str

    @classmethod
    def parse(cls, name: str) -> "Convention":
        """Return the convention ``name``; raise `UserError` if it does not exist."""
        if not _NAME.fullmatch(name):
            raise UserError(
                f"Unknown convention {name!r}: use one of {', '.join(c.name for c in CONVENTIONS)}, optionally "
                "followed by "
                "*0.5 or *2."
            )
        return cls(name)

    @property
    def axes(self) -> str:
        """Return the name without its factor."""
        return self.name.partition("*")[0]

    @property
    def suffix(self) -> str:
        """Return the factor as written in the name, one of `FACTORS`."""
        return self.name.removeprefix(self.axes)

    @property
    def _channels(self) -> list[tuple[float, int]]:
        factor = float(self.suffix.removeprefix("*") or 1.0)
        terms: list[str] = re.findall(r"-?[xy]", self.axes)
        return [(-factor if len(term) == 2 else factor, AXES[term[-1]]) for term in terms]

    def decode(self, channels: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return a file's channels ``(..., 2)`` as the project's (x, y)."""
        out = np.empty_like(channels)
        for k, (factor, axis) in enumerate(self._channels):
            out[..., axis] = factor * channels[..., k]
        return out

    def encode(self, vectors: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the project's (x, y) ``(..., 2)`` as a file's channels: the inverse of `decode`."""
        return np.stack([vectors[..., axis] / np.float32(factor) for factor, axis in self._channels], axis=-1)

    def variants(self) -> list["Convention"]:
        """Return the conventions of all eight orders and signs, with the factor of this one."""
        return [Convention(c.name + self.suffix) for c in CONVENTIONS]


CONVENTIONS = tuple(
    Convention(f"{first}{a}{second}{b}") for a, b in ("xy", "yx") for first, second in product(("", "-"), repeat=2)
)
