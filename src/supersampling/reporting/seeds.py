"""Runs that differ in their seed alone, and how a user names them."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from supersampling.errors import UserError
from supersampling.reporting.selection import configurations, matches, one_per_seed, settings
from supersampling.reporting.settings import Setting
from supersampling.runs.store import Run

SHORT = 8


@dataclass(frozen=True)
class Group:
    """One configuration's runs in one setting, a run a seed."""

    setting: Setting
    runs: list[Run]

    @property
    def seeds(self) -> list[str]:
        """The seeds of trained runs; empty for a method that is not trained."""
        return [run.seed for run in self.runs if run.seed]

    @property
    def label(self) -> str:
        """The method, with the loss's weight where it has one."""
        theta = self.runs[0].params.get("loss.theta")
        return self.runs[0].method + (f" theta={theta}" if theta is not None else "")


def seed_groups(runs: Iterable[Run]) -> list[Group]:
    """Runs that differ in seed alone: the same data set, setting and every parameter that can change a result."""
    by_setting: dict[Setting, list[Run]] = defaultdict(list)
    for run in runs:
        by_setting[Setting.of(run)].append(run)
    return [
        Group(setting, one_per_seed(group))
        for setting, members in sorted(by_setting.items())
        for group in configurations(members)
    ]


def find_groups(runs: Sequence[Run], key: str, wanted: str) -> list[Group]:
    """The groups that ``wanted`` names: a run's id (that run alone), or a method or model, and settings ``name=value``.

    ``dlctus``, ``dlctus loss.theta=0.1``, ``tus rectify=none``, ``3ad14ce7``. A method's name means its published
    stages where such a run exists, and jobs alone: an evaluation is named by its id. ``key`` is what the user set, for the
    message.

    Raises:
        UserError: nothing has that name; the beginning of an id that several runs share.
    """
    jobs = [run for run in runs if run.kind == "job"]
    known = sorted({run.method for run in jobs})
    if wanted in known:
        return seed_groups(run for run in jobs if run.method == wanted)
    words = wanted.split()
    names = [word for word in words if "=" not in word]
    pairs = [word.partition("=") for word in words if "=" in word]
    if len(names) > 1:
        raise UserError(f"{key}='{wanted}' names {len(names)} methods: give one, and settings name=value")
    found = [run for run in jobs if all(_has(run, name, value) for name, _, value in pairs)]
    if not names:
        groups = seed_groups(found) if pairs else []
    elif any(run.method == names[0] for run in found):
        groups = seed_groups(run for run in found if run.method == names[0])
    elif any(run.model == names[0] for run in found):
        groups = seed_groups(run for run in found if run.model == names[0])
    else:
        groups = [] if pairs else _by_id(runs, key, names[0])
    if not groups:
        choice = f"choose one of {', '.join(known)}, or a run's id" if known else "give a run's id"
        raise UserError(f"{key}='{wanted}' is no finished run or method: {choice}")
    return groups


def _has(run: Run, name: str, value: str) -> bool:
    return matches(run, {name: value}) or matches(run, {f"model.{name}": value})


def _by_id(runs: Sequence[Run], key: str, start: str) -> list[Group]:
    found = [run for run in runs if run.id.startswith(start)]
    if len(found) > 1:
        ids = ", ".join(run.id for run in found)
        raise UserError(f"{key}='{start}' begins the ids of several runs ({ids}): give more of it")
    return [Group(Setting.of(run), [run]) for run in found]


def pair(ours: Sequence[Group], theirs: Sequence[Group]) -> tuple[Group, Group]:
    """The one pair of groups that share test data and scale, and the mip bias where any do.

    Raises:
        UserError: no such pair, or several; the sentence says what tells them apart.
    """
    shared = [(a, b) for a in ours for b in theirs if _data(a) == _data(b) and a.runs[0].id != b.runs[0].id]
    pairs = [(a, b) for a, b in shared if a.setting.mip_bias == b.setting.mip_bias] or shared
    if len(pairs) == 1:
        return pairs[0]
    if not pairs:
        raise UserError(
            f"a ({_named(ours)}) and b ({_named(theirs)}) share no test data: compare runs of one data set and scale"
        )
    several = {"a": [a for a, _ in pairs], "b": [b for _, b in pairs]}
    key, groups = max(several.items(), key=lambda item: len({group.runs[0].id for group in item[1]}))
    distinct = list({group.runs[0].id: group for group in groups}.values())
    raise UserError(
        f"{key} names {len(distinct)} configurations that can be compared ({_differences(distinct)}): add settings "
        f"name=value, dataset=, or give a run's id"
    )


def _data(group: Group) -> tuple[str, str]:
    return group.setting.dataset, group.setting.scale


def _named(groups: Sequence[Group]) -> str:
    return "; ".join(f"{group.label} on {group.setting}" for group in groups)


def _differences(groups: Sequence[Group]) -> str:
    """Each group's first run's id with the settings in which the groups differ."""
    each = [{**settings(g.runs[0]), "dataset": g.setting.dataset, "budget": g.setting.budget} for g in groups]
    names = [name for name in sorted({n for one in each for n in one}) if len({one.get(name) for one in each}) > 1]
    return "; ".join(
        " ".join([g.runs[0].id[:SHORT], *(f"{name}={one.get(name)}" for name in names)]) for g, one in zip(groups, each)
    )
