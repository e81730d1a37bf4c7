"""The record of an extreme."""

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass

from supersampling.models.base import Upsampler
from supersampling.stress.clip import Clip

COLOURS = ("color", "target", "radiance", "target_radiance")


def unchanged(clip: Clip) -> Clip:
    """Return the clip itself."""
    return clip


@dataclass(frozen=True)
class Extreme:
    """A change of the plain clip, of its size, or of a model.

    Args:
        name: ``group/detail``.
        meaning: a sentence.
        change: the change of the clip.
        touches: the changed buffers; a model that reads none of them has no cell. Empty: every model has one.
        adjust: changes a model in place and returns whether the model has what is changed.
        size: width and height of the low resolution.
        target: width and height of the target.
        scale: the model's scale.
        full: whether the quick budget leaves it out.
    """

    name: str
    meaning: str
    _: KW_ONLY
    change: Callable[[Clip], Clip] = unchanged
    touches: frozenset[str] = frozenset()
    adjust: Callable[[Upsampler], bool] | None = None
    size: tuple[int, int] | None = None
    target: tuple[int, int] | None = None
    scale: int | None = None
    frames: int = 6
    full: bool = False

    @property
    def group(self) -> str:
        """The part of the name before the slash."""
        return self.name.partition("/")[0]

    def low_size(self, size: tuple[int, int], scale: int) -> tuple[int, int]:
        """Return width and height of the low resolution, which are the default ``size`` if the extreme sets none."""
        if self.target:
            return max(1, self.target[0] // scale), max(1, self.target[1] // scale)
        return self.size or size

    def concerns(self, model: Upsampler) -> bool:
        """Return whether the model reads a changed buffer."""
        return not self.touches or bool(self.touches & model.requires)
