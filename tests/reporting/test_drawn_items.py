"""Every figure and picture of the four papers is drawn if its runs are there, and says otherwise which are missing."""

import math
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from example_runs import example_run
from PIL import Image

from supersampling.reporting.figures import compared, published
from supersampling.reporting.pages.material import Material, PaperRuns
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Gallery, Section
from supersampling.reporting.pages.section import Picture as Printed
from supersampling.reporting.papers.published import load_papers, name_of
from supersampling.reporting.papers.schema import Paper, Picture, PublishedFigure, Selection
from supersampling.reporting.selection import matches
from supersampling.reporting.settings import choose
from supersampling.runs.relation import SCENES as RELATION
from supersampling.runs.relation import TRAINED
from supersampling.runs.store import FinishedRuns, Run

PAPERS = {paper.paper: paper for paper in load_papers(Path(__file__).parents[2] / "reports" / "published", None)}
UNTRAINED = ("bicubic", "jau", "tus", "bilinear", "jau_bicubic")
SCENES = ("atrium", "market", "sundial")
STATES = ("accumulation", "reprojected", "candidate", "mask", *(f"reweighting_{k}" for k in (1, 2, 3, 4)))
SIDE = 16


def items(paper: Paper) -> list[Picture | PublishedFigure]:
    return [*paper.pictures, *paper.figures]


def selections(item: Picture | PublishedFigure) -> dict[str, Selection]:
    return {series.label: {**item.base, **series.select} for series in item.series}


def run_of(selection: Selection) -> Run:
    """A run with the first of each selected value; runs of one task and its scenes share a data set.

    It is an evaluation if what is scored is not what was trained.
    """
    params = {name: value.split("|")[0] for name, value in selection.items()}
    params = {"task.scale": "4", "task.mip_bias": "matched", **params}
    if params["model"] not in UNTRAINED:
        params |= {"budget": "laptop", "seed": "0"}
    trained = {name: value for name, value in params.items() if name.startswith(TRAINED)}
    same = {name for name, value in trained.items() if params[name.removeprefix(TRAINED)] == value}
    params = {name: value for name, value in params.items() if name not in same}
    evaluation = len(same) < len(trained) or RELATION in params
    if evaluation:
        params = {RELATION: "same", **params}
    if params.get(RELATION) == "unseen":
        params["trained.data.scenes"] = "arena"
    name = " ".join(f"{key}={value}" for key, value in sorted(params.items()))
    tested = [value for key, value in sorted(params.items()) if key.startswith(("task.", "data."))]
    dataset = " ".join(tested)
    metrics = {"test/psnr": 30.0, "model/parameters": 1000.0, "train/minutes": 3.0}
    run = example_run(name, dataset=dataset, metrics=metrics)
    kind = "evaluation" if evaluation else "job"
    return Run(**{**vars(run), "params": {**run.params, **params}, "kind": kind})


def runs_of(paper: Paper) -> list[Run]:
    every = [run_of(selection) for item in items(paper) for selection in selections(item).values()]
    return list({run.id: run for run in every}.values())


class Pictures:
    """A store of pictures: each run's are of one level of grey, its number among the runs; the target is white."""

    def __init__(
        self, folder: Path, runs: Sequence[Run], kinds: Sequence[str] = ("crops", "epipolar", "state", "steps")
    ):
        self.folder, self.kinds = folder, kinds
        self.level = {run.id: 10 + 3 * index for index, run in enumerate(runs)}
        self.problems: dict[str, str] = {}

    def folders(self, runs: Iterable[Run], name: str) -> dict[str, Path]:
        return {run.id: self._folder(run, name) for run in runs} if name in self.kinds else {}

    def _folder(self, run: Run, name: str) -> Path:
        folder = self.folder / str(self.level[run.id]) / name
        if folder.is_dir():
            return folder
        folder.mkdir(parents=True)
        suffixes = {"": 0, "_target": 255, "_input": 7} if name in ("crops", "epipolar") else {}
        suffixes |= dict.fromkeys([f"_{state}" for state in STATES], 0) if name == "state" else {}
        suffixes |= {"_mask": 0} if name == "steps" else {}
        for index, scene in enumerate(SCENES):
            for suffix, level in suffixes.items():
                image = np.full((SIDE, SIDE, 3), level or self.level[run.id], np.uint8)
                Image.fromarray(image).save(folder / f"{index}_{scene}{suffix}.png")
        return folder

    def history(self, run: Run, metric: str) -> list[tuple[int, float]]:
        return [(10 * epoch, 30.0 - 1 / epoch) for epoch in (1, 2, 3)] if metric != "epoch" else []


def tables(runs: Sequence[Run]) -> dict[str, pd.DataFrame]:
    places = [(scene, 0, frame) for scene in SCENES for frame in range(3)]
    frame_table = pd.DataFrame(places, columns=["scene", "clip", "frame"])
    names = {metric for paper in PAPERS.values() for figure in paper.figures for metric in figure.metrics}
    return {run.id: frame_table.assign(**dict.fromkeys(sorted(names), 0.5 + frame_table.frame)) for run in runs}


def report_of(paper: Paper, runs: Sequence[Run], store: Any, build: Path) -> Report:
    choice = choose(runs, None, None)
    frames = tables(runs)
    clips = {name: table.groupby(["scene", "clip"], as_index=False).mean() for name, table in frames.items()}
    subject = PaperRuns.of(paper, choice)
    material = Material(
        store=store,
        experiment=FinishedRuns(list(runs), 0, "0"),
        choice=choice,
        papers=[subject],
        methods=[],
        configurations=0,
        clips=clips,
        frames=frames,
    )
    report = Report(material, subject, build)
    report.folder.mkdir(parents=True)
    return report


def made(maker: Any, report: Report) -> Section:
    section = maker(report)
    assert section is not None
    return section


def texts(report: Report, paper: Paper) -> dict[str, str]:
    """What the list of pictures says of ours, by number."""
    section = made(compared.section, report)
    return {item.number: row[-1].text for item, row in zip(paper.pictures, section.sheets[0].rows, strict=True)}


def gallery_of(item: Picture, section: Section) -> Gallery | None:
    pattern = re.compile(rf"\b{re.escape(name_of(item.number))}(?!\w)")
    return next((gallery for gallery in section.galleries if pattern.search(gallery.caption[0].text)), None)


@pytest.mark.parametrize("paper", PAPERS.values(), ids=PAPERS)
def test_every_item_is_drawn_if_its_runs_are_there(paper: Paper, tmp_path: Path) -> None:
    runs = runs_of(paper)
    store = Pictures(tmp_path / "store", runs)
    report = report_of(paper, runs, store, tmp_path / "build")
    section = made(compared.section, report)
    for item, row in zip(paper.pictures, section.sheets[0].rows, strict=True):
        if item.counterpart == "none":
            assert row[-1].text == "not drawn"
            assert item.note in row[2].text
            continue
        assert row[-1].text == f"below: {', '.join(series.label for series in item.series)}", item.number
        gallery = gallery_of(item, section)
        assert gallery is not None, item.number
        assert gallery.rows
        for line in (line for row in gallery.rows for line in row.lines):
            for part in line:
                assert not isinstance(part, Printed) or (report.folder / part.picture).is_file()
    if paper.figures:
        for drawn in made(published.section, report).figures:
            assert (report.folder / drawn.file).stat().st_size > 0
            assert "Not " not in drawn.caption


@pytest.mark.parametrize("paper", PAPERS.values(), ids=PAPERS)
def test_each_label_has_the_pictures_of_its_own_run(paper: Paper, tmp_path: Path) -> None:
    """Levels of grey in the galleries against the runs that match a label's selection and no more."""
    runs = runs_of(paper)
    store = Pictures(tmp_path / "store", runs)
    report = report_of(paper, runs, store, tmp_path / "build")
    section = made(compared.section, report)
    checked = 0
    for item in paper.pictures:
        gallery = gallery_of(item, section)
        if gallery is None or len(item.series) < 2 or item.counterpart in ("mask_over_time", "blending"):
            continue
        for label, selection in selections(item).items():
            column = gallery.heads.index(label)
            part = gallery.rows[0].lines[0][column]
            assert isinstance(part, Printed)
            # The centre: a rectangle marks the detail of a crop.
            level = int(np.asarray(Image.open(report.folder / part.picture))[-1, -1, 0])
            shown = next(run for run in runs if store.level[run.id] == level)
            assert matches(shown, selection), (item.number, label)
            others = [other for name, other in selections(item).items() if name != label]
            assert not any(matches(shown, other) for other in others), (item.number, label)
            checked += 1
        assert gallery.heads[-1] == "target"
    assert checked >= 4


@pytest.mark.parametrize("paper", PAPERS.values(), ids=PAPERS)
def test_every_item_without_runs_names_them(paper: Paper, tmp_path: Path) -> None:
    runs = [example_run("other", model="nearest")]
    report = report_of(paper, runs, Pictures(tmp_path / "store", runs), tmp_path / "build")
    for item, text in zip(paper.pictures, texts(report, paper).values(), strict=True):
        if item.counterpart == "none":
            continue
        sweep = f" (sweeps={item.sweep})" if item.sweep else ""
        assert text == f"not run: {', '.join(series.label for series in item.series)}{sweep}", item.number
    assert not made(compared.section, report).galleries
    if paper.figures:
        for figure, drawn in zip(paper.figures, made(published.section, report).figures, strict=True):
            assert drawn.file == ""
            assert f"Not run: {', '.join(series.label for series in figure.series)}" in drawn.caption


@pytest.mark.parametrize("paper", PAPERS.values(), ids=PAPERS)
def test_one_missing_run_of_a_comparison_is_named_and_the_rest_is_drawn(paper: Paper, tmp_path: Path) -> None:
    every = runs_of(paper)
    for number, item in enumerate(item for item in paper.pictures if len(item.series) > 1):
        *_, (label, selection) = selections(item).items()
        runs = [run for run in every if not matches(run, selection)]
        report = report_of(paper, runs, Pictures(tmp_path / f"store{number}", runs), tmp_path / f"build{number}")
        text = texts(report, paper)[item.number]
        rest = [series.label for series in item.series if series.label != label]
        assert text.startswith(f"below: {', '.join(rest)}; not run: {label}"), (item.number, text)


@pytest.mark.parametrize("paper", PAPERS.values(), ids=PAPERS)
def test_runs_without_pictures_or_scores_are_named(paper: Paper, tmp_path: Path) -> None:
    runs = runs_of(paper)
    report = report_of(paper, runs, Pictures(tmp_path / "store", runs, kinds=()), tmp_path / "build")
    for item, text in zip(paper.pictures, texts(report, paper).values(), strict=True):
        labels = ", ".join(series.label for series in item.series)
        assert item.counterpart == "none" or text.endswith(f"so score again: {labels}"), (item.number, text)
    report.material.frames.clear()
    report.material.clips.clear()
    report.material.store.history = lambda run, metric: []  # type: ignore[method-assign]
    if paper.figures:
        for figure, drawn in zip(paper.figures, made(published.section, report).figures, strict=True):
            assert drawn.file == ""
            assert f"Not drawn: the runs did not log {', '.join(figure.metrics)}." in drawn.caption


def test_a_scene_that_a_picture_names_is_drawn_alone(tmp_path: Path) -> None:
    paper = PAPERS["nsrd"]
    runs = runs_of(paper)
    report = report_of(paper, runs, Pictures(tmp_path / "store", runs), tmp_path / "build")
    galleries = made(compared.section, report).galleries
    shadows = next(gallery for gallery in galleries if "S-figure 7" in gallery.caption[0].text)
    assert [row.label for row in shadows.rows] == ["sundial"]
    assert math.isfinite(float(shadows.rows[0].lines[-1][1].text))  # type: ignore[union-attr]
