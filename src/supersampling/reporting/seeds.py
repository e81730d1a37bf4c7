"""Runs that differ only in their seed, and the names by which a user selects them."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from supersampling.errors import UserError
from supersampling.reporting.selection import configurations, loss_numbers, matches, newest_per_seed, settings
from supersampling.reporting.settings import Setting
from supersampling.runs.store import Run

SHORT = 8


@dataclass(frozen=True)
class Group:
    """One configuration's runs in one setting, one run per seed."""

    setting: Setting
    runs: list[Run]

    @property
    def seeds(self) -> list[str]:
        """The seeds of trained runs; empty for a method that is not trained."""
        return [run.seed for run in self.runs if run.seed]

    @property
    def label(self) -> str:
        """The method, with its loss's numbers if there are any."""
        numbers = loss_numbers(self.runs[0])
        return " ".join(
            [self.runs[0].method, *(f"{name.removeprefix('loss.')}={value}" for name, value in numbers.items())]
        )


def seed_groups(runs: Iterable[Run]) -> list[Group]:
    """Return groups of runs that differ only in seed.

    Those of a group share the data set, the setting and every parameter that can change a result.
    """
    by_setting: dict[Setting, list[Run]] = defaultdict(list)
    for run in runs:
        by_setting[Setting.of(run)].append(run)
    return [
        Group(setting, newest_per_seed(group))
        for setting, members in sorted(by_setting.items())
        for group in configurations(members)
    ]


def find_groups(runs: Sequence[Run], key: str, name: str) -> list[Group]:
    """Return the groups that a name selects: a run's id (only that run), or a method or model, and settings
    ``name=value``.

    ``dlctus``, ``dlctus loss.theta=0.1``, ``tus rectify=none``, ``3ad14ce7``. A method's name means its published
    stages if such a run exists, and only jobs: an evaluation is selected by its id.

    Args:
        key: the setting that holds the name, for messages.

    Raises:
        UserError: nothing has that name, or several runs' ids begin with it.
    """
    jobs = [run for run in runs if run.kind == "job"]
    known = sorted({run.method for run in jobs})
    if name in known:
        return seed_groups(run for run in jobs if run.method == name)
    words = name.split()
    methods = [word for word in words if "=" not in word]
    pairs = [word.partition("=") for word in words if "=" in word]
    if len(methods) > 1:
        raise UserError(f"{key}={name} names {len(methods)} methods: use one, and settings name=value.")
    candidates = [run for run in jobs if all(_has(run, setting, value) for setting, _, value in pairs)]
    if not methods:
        groups = seed_groups(candidates) if pairs else []
    elif any(run.method == methods[0] for run in candidates):
        groups = seed_groups(run for run in candidates if run.method == methods[0])
    elif any(run.model == methods[0] for run in candidates):
        groups = seed_groups(run for run in candidates if run.model == methods[0])
    else:
        groups = [] if pairs else _by_id(runs, key, methods[0])
    if not groups:
        remedy = f"choose one of {', '.join(known)}, or a run's id" if known else "use a run's id"
        raise UserError(f"No finished run or method is called {key}={name}: {remedy}.")
    return groups


def _has(run: Run, name: str, value: str) -> bool:
    return matches(run, {name: value}) or matches(run, {f"model.{name}": value})


def _by_id(runs: Sequence[Run], key: str, start: str) -> list[Group]:
    members = [run for run in runs if run.id.startswith(start)]
    if len(members) > 1:
        ids = ", ".join(run.id for run in members)
        raise UserError(f"The ids of several runs begin with {key}={start} ({ids}): use more characters.")
    return [Group(Setting.of(run), [run]) for run in members]


def pair(first: Sequence[Group], second: Sequence[Group]) -> tuple[Group, Group]:
    """Return the one pair of groups that share test data and scale, and the mip bias if any do.

    Raises:
        UserError: no such pair, or several; the message says what distinguishes them.
    """
    shared = [(a, b) for a in first for b in second if _data(a) == _data(b) and a.runs[0].id != b.runs[0].id]
    pairs = [(a, b) for a, b in shared if a.setting.mip_bias == b.setting.mip_bias] or shared
    if len(pairs) == 1:
        return pairs[0]
    if not pairs:
        raise UserError(
            f"a ({_describe(first)}) and b ({_describe(second)}) share no test data: compare runs of one data set and "
            "scale."
        )
    several = {"a": [a for a, _ in pairs], "b": [b for _, b in pairs]}
    key, groups = max(several.items(), key=lambda item: len({group.runs[0].id for group in item[1]}))
    distinct = list({group.runs[0].id: group for group in groups}.values())
    raise UserError(
        f"{key} names {len(distinct)} configurations that can be compared ({_differences(distinct)}): add settings "
        "name=value, dataset=, or use a run's id."
    )


def _data(group: Group) -> tuple[str, str]:
    return group.setting.dataset, group.setting.scale


def _describe(groups: Sequence[Group]) -> str:
    return "; ".join(f"{group.label} on {group.setting}" for group in groups)


def _differences(groups: Sequence[Group]) -> str:
    """Return the id of each group's first run with the settings in which the groups differ."""
    values = [{**settings(g.runs[0]), "dataset": g.setting.dataset, "budget": g.setting.budget} for g in groups]
    names = [name for name in sorted({n for v in values for n in v}) if len({v.get(name) for v in values}) > 1]
    return "; ".join(
        " ".join([g.runs[0].id[:SHORT], *(f"{name}={v.get(name)}" for name in names)]) for g, v in zip(groups, values)
    )
