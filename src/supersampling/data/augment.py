"""Changes of a training sample that keep it consistent: mirrored, rotated, or in different colours."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import final

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError
from supersampling.frames import BUFFERS

Item = Mapping[str, NDArray[np.float32]]


class Augment(ABC):
    """Base class of ``augment(item, rng) -> item``; buffers are ``(T, C, h, w)`` and square, ``jitter`` is ``(T,
    2)``."""

    @abstractmethod
    def __call__(self, item: Item, rng: np.random.Generator) -> dict[str, NDArray[np.float32]]: ...


@final
class NoAugmentation(Augment):
    """Samples as rendered, as in the thesis."""

    def __call__(self, item: Item, rng: np.random.Generator) -> dict[str, NDArray[np.float32]]:
        return dict(item)


@final
class Colours(Augment):
    """Random order of the colour channels and random gain, the same for the whole sample.

    Upsampling is linear in display-referred colour, so that a darker sample is as valid as the rendered one. The gain
    applies to all kinds of light, but not to reflectances, whose channels are only reordered: radiance = material *
    lighting still holds.

    Args:
        darkest: the smallest gain, in (0, 1]; 1 preserves the brightness.
    """

    def __init__(self, darkest: float) -> None:
        if not 0.0 < darkest <= 1.0:
            raise UserError(
                f"Invalid augment.darkest={darkest}: use a number above 0 and at most 1; 0.4 is the default."
            )
        self.darkest = darkest

    def __call__(self, item: Item, rng: np.random.Generator) -> dict[str, NDArray[np.float32]]:
        order, gain = rng.permutation(3), np.float32(rng.uniform(self.darkest, 1.0))
        return {name: self._recolour(name, values, order, gain) for name, values in item.items()}

    def _recolour(
        self, name: str, values: NDArray[np.float32], order: NDArray[np.int64], gain: np.float32
    ) -> NDArray[np.float32]:
        kind = BUFFERS[name].kind
        if kind in ("display", "light"):
            return values[:, order] * gain
        return values[:, order] if kind == "reflectance" else values


@final
class Symmetries(Augment):
    """Random one of the eight symmetries of a square, the same for the whole sample.

    A mirror changes the sign of one component of jitter, motion and normals; a transposition swaps the components.
    """

    def __call__(self, item: Item, rng: np.random.Generator) -> dict[str, NDArray[np.float32]]:
        mirror_x, mirror_y, transpose = (bool(b) for b in rng.integers(0, 2, size=3))
        sign = np.array((-1.0 if mirror_x else 1.0, -1.0 if mirror_y else 1.0), dtype=np.float32)
        changed = {}
        for name, values in item.items():
            if BUFFERS[name].resolution == "frame":
                values = values * sign
                changed[name] = np.ascontiguousarray(values[:, ::-1] if transpose else values)
                continue
            if BUFFERS[name].kind in ("plane", "direction"):
                plane = values[:, :2] * sign[:, None, None]
                values = np.concatenate((plane[:, ::-1] if transpose else plane, values[:, 2:]), axis=1)
            values = values[..., ::-1] if mirror_x else values
            values = values[..., ::-1, :] if mirror_y else values
            values = values.swapaxes(-1, -2) if transpose else values
            changed[name] = np.ascontiguousarray(values)
        return changed


@final
class Chain(Augment):
    """Several augmentations, applied in order."""

    def __init__(self, steps: Sequence[Augment]) -> None:
        self._steps = tuple(steps)

    def __call__(self, item: Item, rng: np.random.Generator) -> dict[str, NDArray[np.float32]]:
        changed = dict(item)
        for step in self._steps:
            changed = step(changed, rng)
        return changed
