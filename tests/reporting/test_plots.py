"""The runs of a figure, the drawn values, and reproducible bytes."""

from functools import partial
from pathlib import Path

import matplotlib
import pandas as pd
import pytest
from example_runs import example_run
from matplotlib.figure import Figure

from supersampling.reporting.figures import published
from supersampling.reporting.papers.figures import FigureRuns, choose_figure
from supersampling.reporting.papers.schema import PublishedFigure, Series
from supersampling.reporting.settings import choose

matplotlib.use("pdf")


run = partial(example_run, model="nsrr", budget="laptop", metrics={"model/parameters": 1000.0})


RUNS = [run(f"p{n}", model__previous=n) for n in (10, 2, 0)] + [run("d", model="dlctus")]


def frames(level: float) -> pd.DataFrame:
    places = [(scene, clip, frame) for scene in ("arena", "bar") for clip in (0, 1) for frame in range(3)]
    table = pd.DataFrame(places, columns=["scene", "clip", "frame"])
    return table.assign(psnr=level + table.frame + 4.0 * (table.scene == "bar"))


FRAMES = {example.id: frames(20.0 + index) for index, example in enumerate(RUNS)}
CLIPS = {name: table.groupby(["scene", "clip"])["psnr"].mean().reset_index() for name, table in FRAMES.items()}
BOTH = [Series("NSRR", {"model": "nsrr"}), Series("DLCTUS", {"model": "dlctus"}), Series("none", {"model": "edsr"})]


def figure(kind: str, x: str | None = None, series: list[Series] = BOTH) -> PublishedFigure:
    return PublishedFigure(
        number="7",
        section="4",
        page=8,
        title="A figure.",
        kind=kind,
        metric="psnr",
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
    assert published._curve(ax, result, CLIPS) == 1
    assert list(ax.lines[0].get_xdata()) == [0, 2, 10]
    assert list(ax.lines[0].get_ydata()) == [25.0, 24.0, 23.0]


def test_frames_are_means_over_clips() -> None:
    result = choose_example(figure("curve", "frame", BOTH[1:2]))
    assert result.over_frames
    ax = Figure().subplots()
    assert published._frame_curve(ax, result, FRAMES) == 1
    assert list(ax.lines[0].get_ydata()) == [25.0, 26.0, 27.0]


@pytest.mark.parametrize(
    ("kind", "x"),
    [("box", None), ("bars", None), ("curve", "frame"), ("curve", "model.previous"), ("front", "model/parameters")],
)
def test_every_kind_is_drawn_the_same_twice_and_says_what_is_missing(tmp_path: Path, kind: str, x: str | None) -> None:
    result = choose_example(figure(kind, x))
    assert result.missing == ["none"]
    assert all(published.draw(result, CLIPS, FRAMES, "PSNR (dB)", tmp_path / name) for name in ("a.pdf", "b.pdf"))
    assert (tmp_path / "a.pdf").read_bytes() == (tmp_path / "b.pdf").read_bytes()


def test_nothing_is_written_where_nothing_was_run(tmp_path: Path) -> None:
    result = choose_example(figure("box", series=BOTH[2:]))
    assert not published.draw(result, CLIPS, FRAMES, "PSNR (dB)", tmp_path / "a.pdf")
    assert list(tmp_path.iterdir()) == []
