"""The runs of each cell.

Runs that are compared share data set and budget, and differ in no setting that their cells do not name.
"""

import math
from collections import Counter, defaultdict
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from supersampling.reporting.papers.schema import Selection
from supersampling.reporting.settings import Choice, Setting, newest
from supersampling.runs.keys import compared_parameters
from supersampling.runs.relation import SCENES, TRAINED, in_order
from supersampling.runs.store import Run

RESULT_SETTINGS = compared_parameters()
COMPARED = (*RESULT_SETTINGS, *(f"{TRAINED}{name}" for name in RESULT_SETTINGS), f"{TRAINED}data")
# Settings that a data set and a budget derive from the task.
FOLLOWS_TASK = {"data.train", "budget.crop"}
# What a selection says of the training data.
TRAINING_DATA = (f"{TRAINED}data", SCENES)
Key = TypeVar("Key", bound=Hashable)
Settings = dict[str, str]
Variant = tuple[tuple[str, str], ...]
Pools = dict[Setting, list[Run]]


def matches(run: Run, selection: Selection) -> bool:
    """Return whether every named parameter has the selected value, or one of ``first|second``.

    Numbers compare as numbers. A plain name is what was scored, ``trained.<name>`` what was trained. An evaluation
    matches only a selection that asks for evaluations.
    """
    if run.kind == "evaluation" and not asks_for_evaluations(selection):
        return False
    return all(any(_has(run, name, v) for v in value.split("|")) for name, value in selection.items())


def _has(run: Run, name: str, requested: str) -> bool:
    value = run.parameter(name)
    if value is not None and name.endswith("data.scenes"):
        return in_order(value) == in_order(requested)
    return _same(value, requested)


def asks_for_evaluations(selection: Selection) -> bool:
    """Return whether a selection reads evaluations beside trainings: it relates what was scored to the training."""
    return any(name == SCENES or name.startswith(TRAINED) for name in selection)


def pools_for(choice: Choice, selections: Iterable[Selection], prefer: Selection) -> list[tuple[Setting, list[Run]]]:
    """Return the pools that can fill any of the selections, those of the preferred parameters first.

    If the selections differ in the task (``task.scale`` 2 and 4), no data set holds them all: then the pools of one
    preset, its scenes and one budget count as one, with a data set for each task. If they differ in the training data
    (``trained.data.camera``, ``test.scenes``), the pools of one test data set count as one. Of pools with evaluations
    those come first that fill most selections.
    """
    requested = list(selections)
    tested = any(map(asks_for_evaluations, requested))
    pools = choice.tested if tested else choice.pools
    if _differ(requested, TRAINING_DATA):
        pools = _across_trainings(pools)
    if _differ(requested, ("task.",)):
        pools = _across_tasks(pools)
    counts = {
        setting: sum(any(matches(run, selection) for run in runs) for selection in requested)
        for setting, runs in pools.items()
    }
    candidates = [item for item in pools.items() if counts[item[0]]]
    if tested:
        candidates.sort(key=lambda item: -counts[item[0]])
    candidates.sort(key=lambda item: not all(matches(run, prefer) for run in item[1]))
    return candidates


def _differ(selections: Iterable[Selection], beginnings: tuple[str, ...]) -> bool:
    """Return whether the selections name different values of parameters that begin so."""
    named = [{item for item in selection.items() if item[0].startswith(beginnings)} for selection in selections]
    return any(items != named[0] for items in named)


def _across_trainings(pools: Pools) -> Pools:
    groups: dict[Setting, dict[Setting, list[Run]]] = defaultdict(dict)
    for setting, runs in pools.items():
        groups[replace(setting, trained="")][setting] = runs
    joined: Pools = {}
    for setting, members in groups.items():
        trained = "; or with ".join(member.trained for member in members if member.trained)
        by_id = {run.id: run for runs in members.values() for run in runs}
        joined[replace(setting, trained=trained)] = list(by_id.values())
    return joined


def _across_tasks(pools: Pools) -> Pools:
    groups: dict[tuple[str, str, str], dict[tuple[tuple[str, str], ...], Setting]] = defaultdict(dict)
    for setting, runs in pools.items():
        task = tuple(sorted(item for item in runs[0].params.items() if item[0].startswith("task.")))
        groups[setting.data, setting.scenes, setting.trained].setdefault(task, setting)
    return {
        joined(list(members.values())): [run for setting in members.values() for run in pools[setting]]
        for members in groups.values()
    }


def joined(settings: Sequence[Setting]) -> Setting:
    """Return several settings as one that names the data sets, scales and mip biases of all."""

    def listed(values: Iterable[str]) -> str:
        return ", ".join(dict.fromkeys(values))

    return replace(
        settings[0],
        dataset=listed(s.dataset for s in settings),
        scale=listed(sorted(s.scale for s in settings)),
        mip_bias=listed(s.mip_bias for s in settings),
        # All are of one budget, or untrained.
        budget=max(s.budget for s in settings),
    )


@dataclass(frozen=True)
class SelectedRuns(Generic[Key]):
    """One configuration's runs (its seeds) for each cell, and the runs that match but differ in an unnamed setting."""

    cells: dict[Key, list[Run]]
    left_out: list[Run]


def choose_runs(runs: Sequence[Run], selections: Mapping[Key, Selection]) -> SelectedRuns[Key]:
    """Return the runs of one configuration for every cell; configurations of a model agree in all that no cell selects.

    The configuration that fills most cells leads; a cell takes another one only if it contradicts the leader in no
    setting that both have.
    """
    swept = {name for selection in selections.values() for name in selection}
    # A name that every cell leaves open in the same way is as good as unnamed.
    swept -= {
        name for name in swept if len(values := {s.get(name) for s in selections.values()}) == 1 and "|" in str(values)
    }
    if _differ(selections.values(), ("task.",)):
        swept |= FOLLOWS_TASK
    if _differ(selections.values(), TRAINING_DATA):
        swept.add(f"{TRAINED}data")
    candidates = {key: [run for run in runs if matches(run, selection)] for key, selection in selections.items()}
    leaders = _leaders(candidates, swept)
    cells: dict[Key, list[Run]] = {}
    left_out: dict[str, Run] = {}
    for key, members in candidates.items():
        fitting = [run for run in members if _agree(settings(run, swept), leaders[run.model])]
        groups = configurations(fitting)
        lead = [group for group in groups if settings(group[0], swept) == leaders[group[0].model]]
        cells[key] = newest_per_seed((lead or groups)[0]) if groups else []
        left_out.update({run.id: run for run in members if run not in cells[key]})
    return SelectedRuns(cells, list(left_out.values()))


def configurations(runs: Iterable[Run], without: Iterable[str] = ()) -> list[list[Run]]:
    """Return the runs grouped by all settings but the seed, the largest group first, the newest among equals."""
    groups: dict[Variant, list[Run]] = defaultdict(list)
    skipped = set(without)
    for run in runs:
        groups[tuple(sorted({**settings(run, skipped), "model": run.model}.items()))].append(run)
    return sorted(groups.values(), key=lambda group: (-len(group), -newest(group), group[0].id))


def settings(run: Run, without: Iterable[str] = ()) -> Settings:
    """Return the parameters that can change a result of the run's model, those that an exchange replaced included.

    Left out are the names in ``without`` and what belongs to them (``name.x``); runs of one model agree in ``model.x``
    also if ``model`` is named.
    """
    skipped = tuple(without)
    inner = tuple(f"{name}." for name in skipped if name != "model")
    return {
        name: value
        for name, value in sorted(run.params.items())
        if name.startswith(COMPARED) and name not in skipped and not name.startswith(inner)
    }


def loss_numbers(run: Run) -> Settings:
    """Return the numbers that the run's loss has as direct parameters, such as ``loss.theta``.

    No option's name tells them, so that labels do. Numbers of a sum's terms (``loss.weights.ssim``) are no direct ones.
    """
    direct = {k: v for k, v in settings(run).items() if k.startswith("loss.") and k.count(".") == 1}
    return {k: v for k, v in direct.items() if _is_number(v)}


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def newest_per_seed(runs: Sequence[Run]) -> list[Run]:
    """Return the newest run of each seed, by seed."""
    by_seed = {run.seed: run for run in sorted(runs, key=lambda run: (run.ended, run.id))}
    return [by_seed[seed] for seed in sorted(by_seed, key=lambda seed: (len(seed), seed))]


def _leaders(candidates: Mapping[Key, Sequence[Run]], swept: set[str]) -> dict[str, Settings]:
    """Return each model's unswept settings that fill most cells, then have most runs, then the newest."""
    cells: dict[tuple[str, Variant], set[Key]] = defaultdict(set)
    count: Counter[tuple[str, Variant]] = Counter()
    ended: dict[tuple[str, Variant], int] = defaultdict(int)
    for key, runs in candidates.items():
        for run in runs:
            variant = (run.model, tuple(settings(run, swept).items()))
            cells[variant].add(key)
            count[variant] += 1
            ended[variant] = max(ended[variant], run.ended)
    ranked = sorted(cells, key=lambda variant: (len(cells[variant]), count[variant], ended[variant], variant[1]))
    return {model: dict(variant) for model, variant in ranked}


def _agree(first: Settings, second: Settings) -> bool:
    """Return whether two runs have no setting in which both differ; what was trained is what was scored unless it is
    named."""
    names = first.keys() | second.keys()
    pairs = [(_value(first, name), _value(second, name)) for name in names]
    return all(_same(a, b) for a, b in pairs if a is not None and b is not None)


def _value(settings: Settings, name: str) -> str | None:
    return settings.get(name, settings.get(name.removeprefix(TRAINED)))


def _same(value: str | None, requested: str) -> bool:
    if value is None or value == requested:
        return value is not None
    try:
        return float(value) == float(requested)
    except ValueError:
        return False
