"""Which extremes there are, and which of them a command's budget and choice take."""

from collections.abc import Sequence
from dataclasses import dataclass

from supersampling.errors import UserError
from supersampling.stress.colours import COLOUR
from supersampling.stress.demodulation import DEMODULATION
from supersampling.stress.extreme import Extreme
from supersampling.stress.gates import GATES
from supersampling.stress.geometry import DEPTHS, JITTERS, MOTIONS
from supersampling.stress.sizes import SCALES, SIZES

EXTREMES: tuple[Extreme, ...] = (
    *SIZES, *SCALES, *COLOUR, *DEMODULATION, *DEPTHS, *MOTIONS, *JITTERS, *GATES,
)  # fmt: skip
# Groups that are no change of a clip.
OTHERS = "theta", "recovery", "determinism", "rollout", "divergence"
GROUPS = (*dict.fromkeys(e.group for e in EXTREMES), *OTHERS)
# ENSS's kernels come of a network as narrow as the laptop budget's: the paper's of 2,048 features takes ten times as long.
NARROW = "enss_s model.kernel_prediction.width=16"
QUICK_MODELS = "bicubic", "jau", "tus", "dlctus", NARROW, "nsrr_fast", "nsrd"
FULL_MODELS = "bicubic", "jau", "tus", "dlctus", "enss_s", "enss_m", "enss_l", "nsrr_fast", "nsrr", "nsrd"


@dataclass(frozen=True)
class Budget:
    """What decides how long it takes: roll-outs' lengths, frames after a bad one, and of TUS's divergence."""

    models: tuple[str, ...]
    rollouts: tuple[int, ...]
    horizon: int
    divergence: int
    full: bool


BUDGETS = {
    "quick": Budget(QUICK_MODELS, (240,), 32, 200, False),
    "full": Budget(FULL_MODELS, (3_600, 36_000), 64, 2000, True),
}


def budget_of(name: str) -> Budget:
    """Raises `UserError` unless it is one of them."""
    if name not in BUDGETS:
        raise UserError(f"effort={name} is not possible: use {' or '.join(BUDGETS)}.")
    return BUDGETS[name]


@dataclass(frozen=True)
class Chosen:
    """The changes of a clip, and the other groups."""

    extremes: tuple[Extreme, ...]
    others: tuple[str, ...]


def choose(names: Sequence[str] | None, full: bool) -> Chosen:
    """The extremes called ``names``: groups (``motion``) or single ones (``motion/NaN``). None takes the budget's; one that is
    named is taken in every budget.

    Raises:
        UserError: there is no such extreme.
    """
    if names is None:
        return Chosen(tuple(e for e in EXTREMES if full or not e.full), OTHERS)
    known = {e.name for e in EXTREMES}
    for name in names:
        if name not in GROUPS and name not in known:
            raise UserError(
                f"extremes holds {name}, which is none: use a list of {', '.join(GROUPS)}, or of one as motion/NaN."
            )
    wanted = set(names)
    taken = tuple(e for e in EXTREMES if e.name in wanted or (e.group in wanted and (full or not e.full)))
    return Chosen(taken, tuple(name for name in OTHERS if name in wanted))
