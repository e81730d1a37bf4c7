"""The material of reports: the runs that each paper's cells, claims and figures take, and these runs' scores.

Runs are selected by their parameters, so that scores are downloaded for the selected ones only, once for all papers.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import pandas as pd

from supersampling.reporting.methods import Method, list_methods
from supersampling.reporting.pages.gaps import gaps
from supersampling.reporting.papers import claims, figures, pictures, tables, times
from supersampling.reporting.papers.effects import RunScores
from supersampling.reporting.papers.schema import Paper
from supersampling.reporting.settings import Choice
from supersampling.runs.estimates import indexed
from supersampling.runs.measurements import Measurement, read_measurements
from supersampling.runs.store import FinishedRuns, Run, Store

MAX_METHODS = 24


@dataclass(frozen=True)
class PaperRuns:
    """A paper and the runs that its tables, claims, figures and pictures take."""

    paper: Paper
    tables: list[tables.TableRuns]
    claims: list[claims.ClaimRuns]
    figures: list[figures.FigureRuns]
    pictures: list[pictures.PictureRuns]

    @classmethod
    def of(cls, paper: Paper, choice: Choice, measurements: Sequence[Measurement] = ()) -> "PaperRuns":
        return cls(
            paper,
            [
                replace(tables.choose_table(table, choice), times=times.table_times(table, paper.metrics, measurements))
                for table in paper.tables
            ],
            [claims.choose_claim(claim, choice, measurements) for claim in paper.claims],
            [figures.choose_figure(figure, choice) for figure in paper.figures],
            [pictures.choose_picture(picture, choice) for picture in paper.pictures],
        )

    @property
    def runs(self) -> list[Run]:
        """The runs whose scores are shown; those of pictures only have none there."""
        cells = [run for table in self.tables for runs in table.cells.values() for run in runs]
        sides = [run for claim in self.claims for runs in claim.runs.values() for run in runs]
        sides = [run for run in sides if run.kind != "benchmark"]
        return [*cells, *sides, *(run for figure in self.figures for run in figure.runs)]

    @property
    def over_frames(self) -> list[Run]:
        """The runs whose scores by frame a figure or a claim needs."""
        figured = [run for figure in self.figures if figure.over_frames for run in figure.runs]
        claimed = [claim for claim in self.claims if claim.claim.over_frames]
        return [*figured, *(run for claim in claimed for runs in claim.runs.values() for run in runs)]


@dataclass(frozen=True, kw_only=True)
class Material:
    """Everything that was read.

    Attributes:
        methods: of the selected setting; if they are too many for a table, the leading configuration of each model.
        configurations: how many there are in all.
        clips, frames: tables of scores by run id.
    """

    store: Store
    experiment: FinishedRuns
    choice: Choice
    papers: list[PaperRuns]
    methods: list[Method]
    configurations: int
    clips: dict[str, pd.DataFrame]
    frames: dict[str, pd.DataFrame]
    _pictures: dict[str, dict[str, Path | None]] = field(default_factory=dict)

    @property
    def leading(self) -> list[Method]:
        return [method for method in self.methods if method.leading]

    @cached_property
    def judged(self) -> dict[str, list[claims.Judged]]:
        """Each paper's claims, by the paper's name."""
        scores = RunScores(self.clips, self.frames)
        return {item.paper.paper: [claims.judge(claim, scores) for claim in item.claims] for item in self.papers}

    def pictures(self, name: str) -> Mapping[str, Path]:
        """Return the artifact folder ``name`` of the leading methods' runs by run id."""
        return self.folders([run for method in self.leading for run in method.runs], name)

    def folders(self, runs: Iterable[Run], name: str) -> Mapping[str, Path]:
        """Return the artifact folder ``name`` by run id, each downloaded once for all reports; runs without it are
        left out."""
        known, requested = self._pictures.setdefault(name, {}), unique(runs)
        missing = [run for run in requested if run.id not in known]
        folders = self.store.folders(missing, name)
        known.update({run.id: folders.get(run.id) for run in missing})
        return {run.id: folder for run in requested if (folder := known[run.id]) is not None}

    def first_folders(self, series: Mapping[str, Sequence[Run]], name: str) -> dict[str, Path]:
        """Return by label the artifact folder ``name`` of the first run of a series that has it.

        Seeds show the same, so the others are not downloaded.
        """
        folders: dict[str, Path] = {}
        for turn in range(max(map(len, series.values()), default=0)):
            runs = {label: runs[turn] for label, runs in series.items() if label not in folders and turn < len(runs)}
            downloaded = self.folders(runs.values(), name)
            folders |= {label: downloaded[run.id] for label, run in runs.items() if run.id in downloaded}
        return {label: folders[label] for label in series if label in folders}


def gather(
    papers: Sequence[Paper], known: Sequence[Paper], store: Store, experiment: FinishedRuns, choice: Choice
) -> Material:
    """Choose the runs of ``papers`` and download their scores.

    All ``known`` papers decide which configuration leads its model, so that a paper's report does not depend on the
    number of papers that are reported.
    """
    measurements = read_measurements(store, experiment.id)
    selected = [PaperRuns.of(paper, choice, measurements) for paper in papers]
    configurations = list_methods(choice.pools[choice.setting], known)
    leading = [method for method in configurations if method.leading]
    methods = configurations if len(configurations) <= MAX_METHODS else leading
    over_frames = [run for item in selected for run in item.over_frames]
    used = unique([run for method in methods for run in method.runs] + [run for item in selected for run in item.runs])
    clips = {run: indexed(table) for run, table in store.tables(used, "clips").items()}
    for run_id, reason in gaps(used, clips).items():
        store.note(run_id, reason)
    return Material(
        store=store,
        experiment=experiment,
        choice=choice,
        papers=selected,
        methods=methods,
        configurations=len(configurations),
        clips=clips,
        frames=store.tables(unique([run for method in leading for run in method.runs] + over_frames), "frames"),
    )


def unique(runs: Iterable[Run]) -> list[Run]:
    """Return each run once, by id."""
    by_id = {run.id: run for run in runs}
    return [by_id[key] for key in sorted(by_id)]
