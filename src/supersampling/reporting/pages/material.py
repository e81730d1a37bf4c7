"""What reports are made from: which runs each paper's cells, claims and figures take, and those runs' scores.

Runs are chosen by their parameters alone, so that scores are downloaded for the chosen ones only, once for all papers.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import pandas as pd

from supersampling.reporting.figures import plots
from supersampling.reporting.pages import overview
from supersampling.reporting.pages.gaps import gaps
from supersampling.reporting.pages.overview import Method
from supersampling.reporting.pages.sheet import Sheet
from supersampling.reporting.papers import claims, tables
from supersampling.reporting.papers.schema import Paper
from supersampling.reporting.settings import Choice
from supersampling.runs.estimates import indexed
from supersampling.runs.store import Experiment, Run, Store

MAX_METHODS = 24


@dataclass(frozen=True)
class PaperRuns:
    """A paper and the runs that its tables, claims and figures take."""

    paper: Paper
    tables: list[tables.TableRuns]
    claims: list[claims.Chosen]
    figures: list[plots.FigureRuns]

    @classmethod
    def of(cls, paper: Paper, choice: Choice) -> "PaperRuns":
        return cls(
            paper,
            [tables.choose_table(table, choice) for table in paper.tables],
            [claims.choose_claim(claim, choice) for claim in paper.claims],
            [plots.choose_figure(figure, choice) for figure in paper.figures],
        )

    @property
    def runs(self) -> list[Run]:
        found = [run for table in self.tables for runs in table.cells.values() for run in runs]
        found += [run for claim in self.claims for runs in claim.runs.values() for run in runs]
        return found + [run for figure in self.figures for run in figure_runs(figure)]


@dataclass(frozen=True)
class Material:
    """Everything that was read. ``found`` are the methods of the chosen setting; where they are too many for a table, the
    leading configuration of each model."""

    store: Store
    experiment: Experiment
    choice: Choice
    papers: list[PaperRuns]
    found: list[Method]
    configurations: int
    clips: dict[str, pd.DataFrame]
    frames: dict[str, pd.DataFrame]
    crops: dict[str, Path]
    epipolar: dict[str, Path]
    states: dict[str, Path]

    @property
    def leading(self) -> list[Method]:
        return [method for method in self.found if method.leading]

    @cached_property
    def summary(self) -> Sheet:
        return overview.summary(self.found, self.clips)

    @cached_property
    def judged(self) -> dict[str, list[claims.Judged]]:
        """Each paper's claims, by the paper's name."""
        return {one.paper.paper: [claims.judge(claim, self.clips) for claim in one.claims] for one in self.papers}


def gather(
    papers: Sequence[Paper], known: Sequence[Paper], store: Store, experiment: Experiment, choice: Choice
) -> Material:
    """Choose the runs of ``papers`` and download their scores. All ``known`` papers have a say in which configuration
    leads its model, so that a report of one paper holds what it holds among all."""
    chosen = [PaperRuns.of(paper, choice) for paper in papers]
    every = overview.methods(choice.pools[choice.setting], known)
    found = every if len(every) <= MAX_METHODS else [method for method in every if method.leading]
    leading = [run for method in found if method.leading for run in method.runs]
    over_frames = [run for one in chosen for figure in one.figures if figure.over_frames for run in figure_runs(figure)]
    used = unique([run for method in found for run in method.runs] + [run for one in chosen for run in one.runs])
    clips = {run: indexed(table) for run, table in store.tables(used, "clips").items()}
    for run_id, why in gaps(used, clips).items():
        store.note(run_id, why)
    return Material(
        store,
        experiment,
        choice,
        chosen,
        found,
        len(every),
        clips=clips,
        frames=store.tables(unique(leading + over_frames), "frames"),
        crops=store.folders(leading, "crops"),
        epipolar=store.folders(leading, "epipolar"),
        states=store.folders(leading, "state"),
    )


def figure_runs(figure: plots.FigureRuns) -> list[Run]:
    return [run for points in figure.points.values() for runs in points.values() for run in runs]


def unique(runs: Iterable[Run]) -> list[Run]:
    """Each run once, by id."""
    found = {run.id: run for run in runs}
    return [found[key] for key in sorted(found)]
