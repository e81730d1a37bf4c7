"""Which runs stand in which cell: runs that are compared share data set and budget and differ in nothing unnamed."""

from collections import Counter, defaultdict
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from supersampling.errors import UserError
from supersampling.reporting.published import Selection
from supersampling.reporting.runs import Run

RESULT_SETTINGS = (
    "model.", "task.", "loss", "optimizer", "augment", "pick", "trainer.precision", "budget.", "data.train.",
    "protocol",
)  # fmt: skip
UNTRAINED = ""
Key = TypeVar("Key", bound=Hashable)
Settings = dict[str, str]


@dataclass(frozen=True, order=True)
class Setting:
    """What runs of one comparison have in common: data set (fingerprint), its preset, scale, mip bias, and budget.

    A method that is not trained has no budget (`UNTRAINED`) and joins the runs of every budget.
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
        return cls(run.dataset, data, scenes, scale, bias, run.params.get("budget", UNTRAINED))

    def __str__(self) -> str:
        scale = f"{self.scale}×{self.scale}"
        return (
            f"{scale}, {self.mip_bias}, data={self.data} ({self.dataset[:8]}), budget={self.budget or 'none'}"
        )


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
            raise UserError(
                f"dataset='{dataset}' {problem} of the experiment: choose one of {', '.join(known)}"
            )
        runs = [run for run in runs if run.dataset == hits[0]]
    if budget is not None:
        budgets = sorted({Setting.of(run).budget for run in runs} - {UNTRAINED})
        runs = [run for run in runs if Setting.of(run).budget in (budget, UNTRAINED)]
        if budget not in budgets:
            raise UserError(f"budget='{budget}' has no finished run here: choose one of {', '.join(budgets)}")
    pools = _pools(runs)
    best = max(pools, key=lambda setting: (len(pools[setting]), _newest(pools[setting]), setting))

    def order(setting: Setting) -> tuple[object, ...]:
        far = (setting != best, setting.dataset != best.dataset, setting.data != best.data)
        return (*far, -len(pools[setting]), -_newest(pools[setting]), setting)

    return Choice(
        best, {key: pools[key] for key in sorted(pools, key=order) if key.budget in (best.budget, UNTRAINED)}
    )


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


def matches(run: Run, selection: Selection) -> bool:
    """Whether every named parameter of the run has the selected value; numbers compare as numbers."""
    return all(_same(run.params.get(name), value) for name, value in selection.items())


def pool_for(
    choice: Choice, selections: Iterable[Selection], prefer: Selection
) -> tuple[Setting, list[Run]] | None:
    """The first pool that can fill any of the selections, those of the preferred parameters first."""
    wanted = list(selections)
    pools = sorted(choice.pools.items(), key=lambda item: not all(matches(run, prefer) for run in item[1]))
    for setting, runs in pools:
        if any(matches(run, selection) for run in runs for selection in wanted):
            return setting, runs
    return None


@dataclass(frozen=True)
class Chosen(Generic[Key]):
    """One configuration's runs (its seeds) for each cell, and the runs that matched but differ in a setting unnamed."""

    cells: dict[Key, list[Run]]
    left_out: list[Run]


def choose_runs(runs: Sequence[Run], selections: Mapping[Key, Selection]) -> Chosen[Key]:
    """For every cell the runs of one configuration; configurations of one model agree in all that no cell selects.

    The configuration that fills most cells leads; a cell takes another one only where it contradicts the leader in
    no setting that both have.
    """
    swept = {name for selection in selections.values() for name in selection}
    found = {key: [run for run in runs if matches(run, selection)] for key, selection in selections.items()}
    leaders = _leaders(found, swept)
    cells: dict[Key, list[Run]] = {}
    left_out: dict[str, Run] = {}
    for key, candidates in found.items():
        fitting = [run for run in candidates if _agree(settings(run, swept), leaders[run.model])]
        groups = configurations(fitting, swept)
        lead = [group for group in groups if settings(group[0], swept) == leaders[group[0].model]]
        cells[key] = one_per_seed((lead or groups)[0]) if groups else []
        left_out.update({run.id: run for run in candidates if run not in cells[key]})
    return Chosen(cells, list(left_out.values()))


def configurations(runs: Iterable[Run], without: Iterable[str] = ()) -> list[list[Run]]:
    """Runs grouped by all settings but the seed, the largest group first, the newest among equals."""
    groups: dict[tuple[tuple[str, str], ...], list[Run]] = defaultdict(list)
    skipped = set(without)
    for run in runs:
        groups[tuple(sorted({**settings(run, skipped), "model": run.model}.items()))].append(run)
    return sorted(groups.values(), key=lambda group: (-len(group), -_newest(group), group[0].id))


def settings(run: Run, without: Iterable[str] = ()) -> Settings:
    """The parameters that can change a result of its model, less those named and what belongs to them (``name.x``)."""
    skipped = tuple(without)
    inner = tuple(f"{name}." for name in skipped)
    return {
        name: value
        for name, value in sorted(run.params.items())
        if name.startswith(RESULT_SETTINGS) and name not in skipped and not name.startswith(inner)
    }


def one_per_seed(runs: Sequence[Run]) -> list[Run]:
    """The newest run of each seed, by seed."""
    newest = {run.seed: run for run in sorted(runs, key=lambda run: (run.ended, run.id))}
    return [newest[seed] for seed in sorted(newest, key=lambda seed: (len(seed), seed))]


def _leaders(found: Mapping[Key, Sequence[Run]], swept: set[str]) -> dict[str, Settings]:
    """For each model the unswept settings that fill most cells, then have most runs, then the newest."""
    cells: dict[tuple[str, tuple[tuple[str, str], ...]], set[Key]] = defaultdict(set)
    count: Counter[tuple[str, tuple[tuple[str, str], ...]]] = Counter()
    newest: dict[tuple[str, tuple[tuple[str, str], ...]], int] = defaultdict(int)
    for key, runs in found.items():
        for run in runs:
            variant = (run.model, tuple(settings(run, swept).items()))
            cells[variant].add(key)
            count[variant] += 1
            newest[variant] = max(newest[variant], run.ended)
    ranked = sorted(
        cells, key=lambda variant: (len(cells[variant]), count[variant], newest[variant], variant[1])
    )
    return {model: dict(variant) for model, variant in ranked}


def _agree(one: Settings, other: Settings) -> bool:
    return all(_same(value, other[name]) for name, value in one.items() if name in other)


def _same(have: str | None, want: str) -> bool:
    if have is None or have == want:
        return have is not None
    try:
        return float(have) == float(want)
    except ValueError:
        return False


def _newest(runs: Sequence[Run]) -> int:
    return max(run.ended for run in runs)
