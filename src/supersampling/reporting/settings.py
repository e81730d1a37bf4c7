"""The common setting of the runs of one comparison, and the setting that a report is about."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache

import yaml

from supersampling.errors import UserError
from supersampling.resources import resources
from supersampling.runs.relation import RUN, SCENES, TRAINED
from supersampling.runs.store import Run

UNTRAINED = ""


@dataclass(frozen=True, order=True, kw_only=True)
class Setting:
    """The common setting of compared runs: data set (fingerprint), its preset, scale, mip bias, and budget.

    A method that is not trained has no budget (`UNTRAINED`) and joins the runs of every budget. A budget that is cut
    for one model counts as the one that it is cut from (`budget_family`). ``trained`` is the training data of an
    evaluation where they are others than those that were scored; empty if they are the same.
    """

    dataset: str
    data: str
    scenes: str
    scale: str
    mip_bias: str
    budget: str
    trained: str = ""

    @classmethod
    def of(cls, run: Run) -> "Setting":
        return cls(
            dataset=run.dataset,
            data=run.params.get("data", "unknown"),
            scenes=", ".join(sorted(run.params.get("data.scenes", "unknown").split(","))),
            scale=run.params.get("task.scale", "unknown"),
            mip_bias=run.params.get("task.mip_bias", "unknown"),
            budget=budget_family(run.params["budget"]) if is_trained(run) else UNTRAINED,
            trained=_training_data(run) if is_trained(run) else "",
        )

    def __str__(self) -> str:
        scales = " and ".join(f"{scale}×{scale}" for scale in self.scale.split(", "))
        dataset = ", ".join(name[:8] for name in self.dataset.split(", "))
        trained = f", trained with {self.trained}" if self.trained else ""
        return f"{scales}, {self.mip_bias}, data={self.data} ({dataset}), budget={self.budget or 'none'}{trained}"


@dataclass(frozen=True)
class Choice:
    """The setting that a report is about, and the runs of every setting with its budget, the report's own first.

    ``pools`` has trainings only, ``tested`` evaluations as well.
    """

    setting: Setting
    pools: dict[Setting, list[Run]]
    tested: dict[Setting, list[Run]] = field(default_factory=dict)


def is_trained(run: Run) -> bool:
    """Return whether a run's method was trained: only then does it log a budget."""
    return "budget" in run.params


@cache
def budget_family(budget: str) -> str:
    """Return the budget that a budget counts as in comparisons: itself, unless ``reports/budgets.yaml`` names
    another."""
    text = (resources() / "reports" / "budgets.yaml").read_text(encoding="utf-8")
    families: dict[str, list[str]] = yaml.safe_load(text)
    return next((family for family, members in families.items() if budget in members), budget)


def choose(runs: Sequence[Run], dataset: str | None, budget: str | None) -> Choice:
    """Return the setting with the most trainings, the newest among equals.

    Without ``dataset`` other data sets of the same budget remain available for the rows that the chosen one cannot
    fill.

    Args:
        dataset: the beginning of a fingerprint; only its runs and the evaluations of its trainings are considered.
        budget: only its runs, and those of methods that are not trained, are considered.

    Raises:
        UserError: no data set or several begin so, no run has the budget, or there are evaluations only.
    """
    jobs = [run for run in runs if run.kind == "job"]
    # Those of an earlier version do not say what they were scored on.
    evaluations = [run for run in runs if run.kind == "evaluation" and SCENES in run.params]
    if not jobs:
        raise UserError("The experiment has evaluations only: train first.")
    if dataset is not None:
        known = sorted({run.dataset for run in jobs})
        hits = [name for name in known if name.startswith(dataset)]
        if len(hits) != 1:
            problem = "Several data sets begin" if hits else "No data set of the experiment begins"
            raise UserError(f"{problem} with dataset={dataset}: choose one of {', '.join(known)}.")
        jobs = [run for run in jobs if run.dataset == hits[0]]
        trainings = {run.id for run in jobs}
        evaluations = [run for run in evaluations if run.dataset == hits[0] or run.params.get(RUN) in trainings]
    if budget is not None:
        budget = budget_family(budget)
        budgets = sorted({Setting.of(run).budget for run in jobs} - {UNTRAINED})
        jobs = [run for run in jobs if Setting.of(run).budget in (budget, UNTRAINED)]
        if budget not in budgets:
            raise UserError(f"No finished run has budget={budget}: choose one of {', '.join(budgets)}.")
    pools = _pools(jobs)
    best = max(pools, key=lambda setting: (len(pools[setting]), newest(pools[setting]), setting))
    return Choice(best, _ordered(pools, best), _ordered(_pools([*jobs, *evaluations]), best))


def _ordered(pools: dict[Setting, list[Run]], best: Setting) -> dict[Setting, list[Run]]:
    """Return the pools of the budget of ``best``, itself first, then those of its data set, then of its preset."""

    def order(setting: Setting) -> tuple[object, ...]:
        far = (setting != best, setting.dataset != best.dataset, setting.data != best.data)
        return (*far, -len(pools[setting]), -newest(pools[setting]), setting)

    return {key: pools[key] for key in sorted(pools, key=order) if key.budget in (best.budget, UNTRAINED)}


def _pools(runs: Sequence[Run]) -> dict[Setting, list[Run]]:
    """Return the runs by setting; those without a budget join every budget of their data set."""
    pools: dict[Setting, list[Run]] = defaultdict(list)
    for run in runs:
        pools[Setting.of(run)].append(run)
    for setting in [setting for setting in pools if setting.budget == UNTRAINED]:
        trained = [s for s in pools if s.budget != UNTRAINED and replace(s, budget=UNTRAINED, trained="") == setting]
        for target in trained:
            pools[target].extend(pools[setting])
        if trained:
            del pools[setting]
    return dict(pools)


def _training_data(run: Run) -> str:
    """Return ``data.camera=walk data.scenes=atrium``: the logged data of an evaluation's training that it did not
    score."""
    names = sorted(name for name in run.params if name.startswith(f"{TRAINED}data"))
    return " ".join(f"{name.removeprefix(TRAINED)}={run.params[name]}" for name in names)


def newest(runs: Sequence[Run]) -> int:
    """Return when the last of the runs ended."""
    return max(run.ended for run in runs)
