"""The methods of one setting: each configuration with its runs, its label, and the one that leads its model."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from supersampling.reporting.papers.schema import Paper
from supersampling.reporting.selection import configurations, loss_numbers, matches, newest_per_seed, settings
from supersampling.reporting.settings import is_trained
from supersampling.runs.estimates import ClipTables, estimate
from supersampling.runs.store import Run


@dataclass(frozen=True)
class Method:
    """One configuration and its runs, one run per seed. ``leading`` marks the configuration that represents its
    model."""

    label: str
    runs: list[Run]
    leading: bool

    @property
    def classical(self) -> bool:
        """Whether none of its runs was trained."""
        return not any(map(is_trained, self.runs))

    def average(self, metric: str) -> float:
        """Return the mean over seeds of a logged metric, NaN if no run logged it."""
        values = [run.metrics[metric] for run in self.runs if metric in run.metrics]
        return float(np.mean(values)) if values else math.nan


def list_methods(runs: Sequence[Run], papers: Sequence[Paper]) -> list[Method]:
    """Return the configurations of one setting, classical ones first, the worst of them at the top.

    A label names what differs from the model's leading configuration.
    """
    methods: list[Method] = []
    for model in sorted({run.model for run in runs}):
        groups = configurations(run for run in runs if run.model == model)
        leader = _leader(groups, papers)
        labels = {group[0].id: _label(group[0], leader[0]) for group in groups}
        numbers = _varied_numbers(leader, groups)
        for group in sorted(groups, key=lambda group: (group is not leader, labels[group[0].id])):
            label = ", ".join([labels[group[0].id], *(numbers if group is leader else [])])
            methods.append(Method(label, newest_per_seed(group), group is leader))
    return sorted(methods, key=lambda method: (not method.classical, method.classical and method.average("test/psnr")))


def _leader(groups: Sequence[list[Run]], papers: Sequence[Paper]) -> list[Run]:
    """Return the configuration that stands in a paper's first table, else the one nearest to the most common
    settings."""
    tables = [paper.tables[0] for paper in papers]
    selections = [{**table.base, **c.select} for table in tables for c in table.columns if c.select]
    common = Counter(item for group in groups for item in settings(group[0]).items())

    def rank(group: list[Run]) -> tuple[bool, int]:
        in_paper = any(matches(group[0], selection) for selection in selections)
        return in_paper, sum(common[item] for item in settings(group[0]).items())

    return max(groups, key=rank)


def _label(run: Run, leader: Run) -> str:
    first, second = settings(run), settings(leader)
    differing = [f"{name.removeprefix('model.')}={value}" for name, value in first.items() if second.get(name) != value]
    return ", ".join([leader.method, *differing])


def _varied_numbers(leader: Sequence[Run], groups: Sequence[list[Run]]) -> list[str]:
    """Return the leader's loss numbers that other configurations have otherwise: its own label would omit them."""
    numbers = [loss_numbers(group[0]) for group in groups]
    return [f"{k}={v}" for k, v in loss_numbers(leader[0]).items() if any(item.get(k) != v for item in numbers)]


def short_labels(labels: Sequence[str]) -> list[str]:
    """Return the labels' first words if these are distinct, else the labels."""
    words = [label.split(" ")[0].rstrip(",") for label in labels]
    return words if len(set(words)) == len(words) else list(labels)


def best_classical(methods: Sequence[Method], tables: ClipTables) -> Method | None:
    """Return the classical method with the highest mean PSNR over clips, None without any."""
    scores = [(estimate(m.runs, "psnr", tables), m) for m in methods if m.classical]
    scored = [(value.mean, method) for value, method in scores if value is not None]
    return max(scored, key=lambda pair: pair[0])[1] if scored else None
