"""The runs of a figure, the drawn values, and reproducible bytes."""

from dataclasses import replace
from functools import partial
from pathlib import Path

import matplotlib
import pandas as pd
import pytest
from example_runs import example_run
from matplotlib.figure import Figure
from pypdf import PdfReader

from supersampling.reporting.figures import published
from supersampling.reporting.figures.training import by_epoch, training_curves
from supersampling.reporting.papers.figures import FigureRuns, choose_figure
from supersampling.reporting.papers.schema import PublishedFigure, Series
from supersampling.reporting.settings import choose
from supersampling.runs.store import Run

matplotlib.use("pdf")


run = partial(example_run, model="nsrr", budget="laptop", metrics={"model/parameters": 1000.0})


RUNS = [run(f"p{n}", model__previous=n) for n in (10, 2, 0)] + [run("d", model="dlctus")]


def frames(level: float) -> pd.DataFrame:
    places = [(scene, clip, frame) for scene in ("arena", "bar") for clip in (0, 1) for frame in range(3)]
    table = pd.DataFrame(places, columns=["scene", "clip", "frame"])
    return table.assign(psnr=level + table.frame + 4.0 * (table.scene == "bar"))


FRAMES = {example.id: frames(20.0 + index) for index, example in enumerate(RUNS)}
CLIPS = {name: table.groupby(["scene", "clip"])["psnr"].mean().reset_index() for name, table in FRAMES.items()}
HISTORY = {
    "val/psnr": [(100, 20.0), (200, 22.5), (300, 24.0)],
    "epoch": [(100, 0.0), (200, 1.0), (300, 2.0)],
    "train/loss": [(100, 0.5), (300, 0.25)],
}


def history(example: Run, metric: str) -> list[tuple[int, float]]:
    return HISTORY.get(metric, []) if example.id == "d" else []


SCORES = published.Scores(CLIPS, FRAMES, history)
BOTH = [Series("NSRR", {"model": "nsrr"}), Series("DLCTUS", {"model": "dlctus"}), Series("none", {"model": "edsr"})]


def figure(kind: str, x: str | None = None, series: list[Series] = BOTH, metric: str = "psnr") -> PublishedFigure:
    return PublishedFigure(
        number="7",
        section="4",
        page=8,
        title="A figure.",
        kind=kind,
        metric="val/psnr" if kind == "training" else metric,
        series=series,
        x=x,  # type: ignore[arg-type]
    )


def choose_example(published_figure: PublishedFigure) -> FigureRuns:
    return choose_figure(published_figure, choose(RUNS, None, None))


def test_a_parameters_values_are_points_in_the_order_of_numbers() -> None:
    result = choose_example(figure("curve", "model.previous", BOTH[:1]))
    assert {x: [r.name for r in runs] for x, runs in result.points["NSRR"].items()} == {
        "0": ["p0"],
        "2": ["p2"],
        "10": ["p10"],
    }
    ax = Figure().subplots()
    assert published._curve(ax, result, "psnr", CLIPS) == 1
    assert list(ax.lines[0].get_xdata()) == [0, 2, 10]
    assert list(ax.lines[0].get_ydata()) == [25.0, 24.0, 23.0]


def test_frames_are_means_over_clips() -> None:
    result = choose_example(figure("curve", "frame", BOTH[1:2]))
    assert result.over_frames
    ax = Figure().subplots()
    assert published._frame_curve(ax, result, "psnr", FRAMES) == 1
    assert list(ax.lines[0].get_ydata()) == [25.0, 26.0, 27.0]


def test_boxes_over_frames_have_every_frame_of_every_clip() -> None:
    """Clip means are 24 and 28; frames lie one below and one above them."""
    one_series = published._box_values(choose_example(figure("box", "frame", BOTH[1:2])), "psnr", SCORES)
    assert {scene: sorted(values) for scene, values in one_series.items()} == {
        "arena": [23.0, 23.0, 24.0, 24.0, 25.0, 25.0],
        "bar": [27.0, 27.0, 28.0, 28.0, 29.0, 29.0],
    }
    several = published._box_values(choose_example(figure("box", "frame")), "psnr", SCORES)
    assert len(several["DLCTUS"]) == 12
    clips = published._box_values(choose_example(figure("box", None)), "psnr", SCORES)
    assert sorted(clips["DLCTUS"]) == [24.0, 24.0, 28.0, 28.0]
    ax = Figure().subplots()
    assert published._boxes(ax, one_series) == 2
    assert [line.get_ydata()[0] for line in ax.lines if len(set(line.get_ydata())) == 1][-1] == 28.0


def test_training_curves_are_by_epoch_and_a_run_without_them_counts_its_values() -> None:
    ax = Figure().subplots()
    series = {"DLCTUS": [run("d", model="dlctus")], "none": [run("e")]}
    assert training_curves(ax, series, "val/psnr", history) == 1
    assert [list(line.get_xdata()) for line in ax.lines] == [[1, 2, 3]]
    assert [list(line.get_ydata()) for line in ax.lines] == [[20.0, 22.5, 24.0]]
    # The second value is of the third epoch.
    assert by_epoch(run("d"), "train/loss", history) == [(1, 0.5), (3, 0.25)]
    without = {"train/loss": [(10, 3.0), (20, 2.0)]}
    assert by_epoch(run("d"), "train/loss", lambda _, name: without.get(name, [])) == [(1, 3.0), (2, 2.0)]


def test_a_panel_for_each_metric_and_none_for_one_that_no_run_logged(tmp_path: Path) -> None:
    series = [Series("DLCTUS", {"model": "dlctus"})]
    drawn = replace(figure("training", series=series, metric="val/psnr"), more=["train/loss", "val/ssim"])
    result = choose_example(drawn)
    drawn_metrics = published.draw(result, SCORES, ["PSNR", "loss", "SSIM"], tmp_path / "a.pdf")
    assert drawn_metrics == ["val/psnr", "train/loss"]
    text = PdfReader(tmp_path / "a.pdf").pages[0].extract_text()
    assert "PSNR" in text
    assert "loss" in text
    assert "SSIM" not in text


@pytest.mark.parametrize(
    ("kind", "x"),
    [
        ("box", None),
        ("box", "frame"),
        ("bars", None),
        ("curve", "frame"),
        ("curve", "model.previous"),
        ("front", "model/parameters"),
        ("training", None),
    ],
)
def test_every_kind_is_drawn_the_same_twice_and_says_what_is_missing(tmp_path: Path, kind: str, x: str | None) -> None:
    result = choose_example(figure(kind, x))
    assert result.missing == ["none"]
    assert all(published.draw(result, SCORES, ["PSNR (dB)"], tmp_path / name) for name in ("a.pdf", "b.pdf"))
    assert (tmp_path / "a.pdf").read_bytes() == (tmp_path / "b.pdf").read_bytes()


def test_nothing_is_written_where_nothing_was_run(tmp_path: Path) -> None:
    result = choose_example(figure("box", series=BOTH[2:]))
    assert not published.draw(result, SCORES, ["PSNR (dB)"], tmp_path / "a.pdf")
    assert list(tmp_path.iterdir()) == []
