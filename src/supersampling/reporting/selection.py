"""Which runs stand in which cell: runs that are compared share data set and budget and differ in nothing unnamed."""

from collections import Counter, defaultdict
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from supersampling.reporting.papers.schema import Selection
from supersampling.reporting.settings import Choice, Setting, newest
from supersampling.runs.store import Run

RESULT_SETTINGS = (
    "model.", "task.", "loss", "optimizer", "augment", "pick", "trainer.precision", "budget.", "data.train.",
    "protocol",
)  # fmt: skip
# What a data set and a budget derive from the task.
FOLLOWS_TASK = {"data.train", "budget.crop"}
Key = TypeVar("Key", bound=Hashable)
Settings = dict[str, str]


def matches(run: Run, selection: Selection) -> bool:
    """Whether every named parameter has the selected value, of ``one|other`` either; numbers compare as numbers."""
    return all(any(_same(run.params.get(name), one) for one in value.split("|")) for name, value in selection.items())


def pools_for(choice: Choice, selections: Iterable[Selection], prefer: Selection) -> list[tuple[Setting, list[Run]]]:
    """The pools that can fill any of the selections, those of the preferred parameters first.

    Where the selections differ in the task (``task.scale`` 2 and 4) no data set holds them all: then the pools of one
    preset, its scenes and one budget count as one, a data set for each task.
    """
    wanted = list(selections)
    pools = _across_tasks(choice) if _sweep_tasks(wanted) else list(choice.pools.items())
    pools.sort(key=lambda item: not all(matches(run, prefer) for run in item[1]))
    return [
        (setting, runs)
        for setting, runs in pools
        if any(matches(run, selection) for run in runs for selection in wanted)
    ]


def _sweep_tasks(selections: Iterable[Selection]) -> bool:
    """Whether the selections name different tasks."""
    tasks = [{item for item in selection.items() if item[0].startswith("task.")} for selection in selections]
    return any(task != tasks[0] for task in tasks)


def _across_tasks(choice: Choice) -> list[tuple[Setting, list[Run]]]:
    groups: dict[tuple[str, str], dict[tuple[tuple[str, str], ...], Setting]] = defaultdict(dict)
    for setting, runs in choice.pools.items():
        task = tuple(sorted(item for item in runs[0].params.items() if item[0].startswith("task.")))
        groups[setting.data, setting.scenes].setdefault(task, setting)
    return [
        (
            _joined(list(members.values())),
            [run for setting in members.values() for run in choice.pools[setting]],
        )
        for members in groups.values()
    ]


def _joined(settings: Sequence[Setting]) -> Setting:
    def every(values: Iterable[str]) -> str:
        return ", ".join(dict.fromkeys(values))

    return replace(
        settings[0],
        dataset=every(s.dataset for s in settings),
        scale=every(sorted(s.scale for s in settings)),
        mip_bias=every(s.mip_bias for s in settings),
        budget=max(s.budget for s in settings),  # of one budget, or untrained
    )


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
    # What every cell leaves open in the same way is as good as unnamed.
    swept -= {
        name for name in swept if len(values := {s.get(name) for s in selections.values()}) == 1 and "|" in str(values)
    }
    if _sweep_tasks(selections.values()):
        swept |= FOLLOWS_TASK
    found = {key: [run for run in runs if matches(run, selection)] for key, selection in selections.items()}
    leaders = _leaders(found, swept)
    cells: dict[Key, list[Run]] = {}
    left_out: dict[str, Run] = {}
    for key, candidates in found.items():
        fitting = [run for run in candidates if _agree(settings(run, swept), leaders[run.model])]
        groups = configurations(fitting)
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
    return sorted(groups.values(), key=lambda group: (-len(group), -newest(group), group[0].id))


def settings(run: Run, without: Iterable[str] = ()) -> Settings:
    """The parameters that can change a result of its model, less those named and what belongs to them (``name.x``).

    Runs of one model agree in ``model.x`` also where ``model`` is named.
    """
    skipped = tuple(without)
    inner = tuple(f"{name}." for name in skipped if name != "model")
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
    ranked = sorted(cells, key=lambda variant: (len(cells[variant]), count[variant], newest[variant], variant[1]))
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
