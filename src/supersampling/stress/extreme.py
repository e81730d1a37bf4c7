"""What an extreme is."""

from collections.abc import Callable
from dataclasses import dataclass

from supersampling.models.base import Upsampler
from supersampling.stress.clip import Clip

COLOURS = ("color", "target", "radiance", "target_radiance")


def unchanged(clip: Clip) -> Clip:
    return clip


@dataclass(frozen=True)
class Extreme:
    """A change of the plain clip, of its size, or of a model.

    ``name`` is ``group/what``, ``says`` a sentence. A model that reads none of ``touches`` has no such row (empty: all have it).
    ``adjust`` changes a model in place and says whether it has what is changed. ``size`` is the low resolution's width and
    height, ``target`` the target's; ``full`` ones are left out of the quick budget.
    """

    name: str
    says: str
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
        return self.name.partition("/")[0]

    def low(self, size: tuple[int, int], scale: int) -> tuple[int, int]:
        """Width and height of the low resolution, of the default ``size`` where the extreme has none."""
        if self.target:
            return max(1, self.target[0] // scale), max(1, self.target[1] // scale)
        return self.size or size

    def concerns(self, model: Upsampler) -> bool:
        return not self.touches or bool(self.touches & model.requires)
