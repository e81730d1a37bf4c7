"""Changes of a training sample that keep it true: the same scene seen in a mirror, turned, or in other colours."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import final

import numpy as np
from numpy.typing import NDArray

from supersampling.frames import BUFFERS

Item = Mapping[str, NDArray[np.float32]]


class Augment(ABC):
    """``augment(item, rng) -> item``; buffers are ``(T, C, h, w)`` and square, ``jitter`` is ``(T, 2)``."""

    @abstractmethod
    def __call__(self, item: Item, rng: np.random.Generator) -> dict[str, NDArray[np.float32]]: ...


@final
class NoAugmentation(Augment):
    """Samples as they were rendered, as the thesis has it."""

    def __call__(self, item: Item, rng: np.random.Generator) -> dict[str, NDArray[np.float32]]:
        return dict(item)


@final
class Symmetries(Augment):
    """One of the square's eight symmetries and of the six orders of the colour channels, drawn for the whole sample.

    A mirror turns the sign of that component of jitter and motion, a transposition exchanges the components.
    """

    def __call__(self, item: Item, rng: np.random.Generator) -> dict[str, NDArray[np.float32]]:
        mirror_x, mirror_y, transpose = (bool(b) for b in rng.integers(0, 2, size=3))
        order = rng.permutation(3)
        sign = np.array((-1.0 if mirror_x else 1.0, -1.0 if mirror_y else 1.0), dtype=np.float32)
        changed = {}
        for name, values in item.items():
            if BUFFERS[name].resolution == "frame":
                values = values * sign
                changed[name] = np.ascontiguousarray(values[:, ::-1] if transpose else values)
                continue
            if name in ("color", "target"):
                values = values[:, order]
            if name == "motion":
                values = values * sign[:, None, None]
                values = values[:, ::-1] if transpose else values
            values = values[..., ::-1] if mirror_x else values
            values = values[..., ::-1, :] if mirror_y else values
            values = values.swapaxes(-1, -2) if transpose else values
            changed[name] = np.ascontiguousarray(values)
        return changed
