"""The catalogue of extremes, and the selection of them that a command tries."""

from collections.abc import Sequence
from dataclasses import dataclass

from supersampling.errors import UserError
from supersampling.stress.colours import COLOUR
from supersampling.stress.demodulation import DEMODULATION
from supersampling.stress.extreme import Extreme
from supersampling.stress.gates import GATES
from supersampling.stress.geometry import DEPTHS, JITTERS, MOTIONS
from supersampling.stress.sizes import SCALES, SIZES

EXTREMES: tuple[Extreme, ...] = (*SIZES, *SCALES, *COLOUR, *DEMODULATION, *DEPTHS, *MOTIONS, *JITTERS, *GATES)
# Groups that do not change a clip but test a model in their own way.
SPECIAL_GROUPS = "theta", "recovery", "determinism", "rollout", "divergence"
GROUPS = (*dict.fromkeys(extreme.group for extreme in EXTREMES), *SPECIAL_GROUPS)


@dataclass(frozen=True)
class Budget:
    """Frame counts that decide how long a command takes.

    ``rollouts`` are the lengths of the long roll-outs, ``horizon`` the frames after a bad frame, ``divergence`` the
    frames of TUS's divergence. ``full`` includes the extremes that take long.
    """

    rollouts: tuple[int, ...]
    horizon: int
    divergence: int
    full: bool


BUDGETS = {
    "quick": Budget(rollouts=(240,), horizon=32, divergence=200, full=False),
    "full": Budget(rollouts=(3_600, 36_000), horizon=64, divergence=2000, full=True),
}


@dataclass(frozen=True)
class Selection:
    """The selected changes of a clip, and the selected names of `SPECIAL_GROUPS`."""

    extremes: tuple[Extreme, ...]
    groups: tuple[str, ...]


def select_extremes(names: Sequence[str] | None, full: bool) -> Selection:
    """Return the extremes called ``names``, which are groups (``motion``) or single extremes (``motion/NaN``).

    None selects all of the budget's extremes. An extreme that is named itself is selected in every budget.

    Raises:
        UserError: a name is unknown.
    """
    if names is None:
        return Selection(tuple(extreme for extreme in EXTREMES if full or not extreme.full), SPECIAL_GROUPS)
    known = {extreme.name for extreme in EXTREMES}.union(GROUPS)
    for name in names:
        if name not in known:
            raise UserError(f"Unknown extreme {name}: use {', '.join(GROUPS)}, or a single one such as motion/NaN.")
    requested = set(names)
    selected = tuple(e for e in EXTREMES if e.name in requested or (e.group in requested and (full or not e.full)))
    return Selection(selected, tuple(name for name in SPECIAL_GROUPS if name in requested))
