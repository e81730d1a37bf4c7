"""What runs of one comparison have in common, and the setting that a report is about."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace

from supersampling.errors import UserError
from supersampling.runs.store import Run

UNTRAINED = ""


@dataclass(frozen=True, order=True)
class Setting:
    """What runs of one comparison have in common: data set (fingerprint), its preset, scale, mip bias, and budget.

    A method that is not trained has no budget (`UNTRAINED`) and joins the runs of every budget. What stands behind a
    budget's first ``_`` names the method that it is cut for: ``laptop_nsrr`` is of ``laptop``.
    """

    dataset: str
    data: str
    scenes: str
    scale: str
    mip_bias: str
    budget: str

    @classmethod
    def of(cls, run: Run) -> "Setting":
        data, scenes, scale, bias = (
            run.params.get(name, "unknown") for name in ("data", "data.scenes", "task.scale", "task.mip_bias")
        )
        scenes = ", ".join(sorted(scenes.split(",")))
        return cls(run.dataset, data, scenes, scale, bias, _family(run.params.get("budget", UNTRAINED)))

    def __str__(self) -> str:
        scales = " and ".join(f"{scale}×{scale}" for scale in self.scale.split(", "))
        dataset = ", ".join(name[:8] for name in self.dataset.split(", "))
        return f"{scales}, {self.mip_bias}, data={self.data} ({dataset}), budget={self.budget or 'none'}"


@dataclass(frozen=True)
class Choice:
    """The setting that a report is about, and the runs of every setting with its budget, the report's own first."""

    setting: Setting
    pools: dict[Setting, list[Run]]


def choose(runs: Sequence[Run], dataset: str | None, budget: str | None) -> Choice:
    """The setting with the most runs, the newest among equals; ``dataset`` (a fingerprint's prefix) and ``budget`` narrow.

    Without ``dataset`` other data sets of the same budget stay at hand for the rows that the chosen one cannot fill.
    """
    if dataset is not None:
        known = sorted({run.dataset for run in runs})
        hits = [name for name in known if name.startswith(dataset)]
        if len(hits) != 1:
            problem = "names no data set" if not hits else "names several data sets"
            raise UserError(f"dataset='{dataset}' {problem} of the experiment: choose one of {', '.join(known)}")
        runs = [run for run in runs if run.dataset == hits[0]]
    if budget is not None:
        budget = _family(budget)
        budgets = sorted({Setting.of(run).budget for run in runs} - {UNTRAINED})
        runs = [run for run in runs if Setting.of(run).budget in (budget, UNTRAINED)]
        if budget not in budgets:
            raise UserError(f"budget='{budget}' has no finished run here: choose one of {', '.join(budgets)}")
    pools = _pools(runs)
    best = max(pools, key=lambda setting: (len(pools[setting]), newest(pools[setting]), setting))

    def order(setting: Setting) -> tuple[object, ...]:
        far = (setting != best, setting.dataset != best.dataset, setting.data != best.data)
        return (*far, -len(pools[setting]), -newest(pools[setting]), setting)

    return Choice(best, {key: pools[key] for key in sorted(pools, key=order) if key.budget in (best.budget, UNTRAINED)})


def _pools(runs: Sequence[Run]) -> dict[Setting, list[Run]]:
    """Runs by setting; those without a budget join every budget of their data set."""
    pools: dict[Setting, list[Run]] = defaultdict(list)
    for run in runs:
        pools[Setting.of(run)].append(run)
    for setting in [setting for setting in pools if setting.budget == UNTRAINED]:
        trained = [s for s in pools if s.budget != UNTRAINED and replace(s, budget=UNTRAINED) == setting]
        for other in trained:
            pools[other].extend(pools[setting])
        if trained:
            del pools[setting]
    return dict(pools)


def _family(budget: str) -> str:
    return budget.partition("_")[0]


def newest(runs: Sequence[Run]) -> int:
    """When the last of them ended."""
    return max(run.ended for run in runs)
