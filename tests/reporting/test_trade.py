"""Benchmarks in the overview: from runs in a temporary MLflow store to its tables, figure and page."""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
import pytest
from example_runs import example_run
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from pypdf import PdfReader
from stored_runs import SCENES, Log, config

from supersampling.commands.report import report
from supersampling.reporting.trade import plot as trade_plot
from supersampling.reporting.trade.front import Candidate, Place
from supersampling.reporting.trade.sheets import Trade, best_of
from supersampling.runs import timing
from supersampling.runs.statistics import Estimate
from supersampling.runs.timing import Timing, architecture

matplotlib.use("pdf")
MACHINE = "Linux x86_64, 2 threads, torch 2.14.1"
METHODS = {"bicubic": (29.99, 3.0), "jau": (31.83, 9.0), "tus": (33.68, 40.0), "dlctus": (34.37, 300.0)}
FACTOR = {"eager": 1.0, "openvino": 0.6}


def example_timing(method: str, backend: str, precision: str = "float32", ms: float = 1.0, **more: Any) -> Timing:
    defaults: dict[str, Any] = {
        "method": method,
        "architecture": architecture({"_target_": method}, 4),
        "scale": 4,
        "width": 1920,
        "height": 1080,
        "backend": backend,
        "precision": precision,
        "device": "cpu",
        "threads": 2,
        "machine": MACHINE,
        "ms": ms,
        "low": 0.95 * ms,
        "high": 1.1 * ms,
        "frames": 20,
        "peak_mb": 100.0,
        "parameters": 80034,
        "gmac": 12.5,
        "gbytes": 0.1,
        "of_product": 0.4,
        "of_copy": 0.2,
    }
    return Timing(**{**defaults, **more})


def log_benchmark(log: Log, timings: list[Timing], **tables: pd.DataFrame) -> None:
    tags = {"ss.kind": "benchmark", "ss.machine": MACHINE, "ss.version": "0.1.0"}
    run = log.client.create_run(log.experiment, run_name="benchmark", tags=tags).info.run_id
    log.client.log_table(run, timing.table(timings), timing.TABLE)
    for name, table in tables.items():
        log.client.log_table(run, table, f"{name}.json")
    log.client.set_terminated(run)


def log_trainings(log: Log) -> None:
    for method, (psnr, _) in METHODS.items():
        for seed in range(2 if method == "dlctus" else 1):
            run = log.run(method, psnr, f"{method} {seed} x4", params={"seed": seed} if method == "dlctus" else {})
            log.client.log_text(run, f"model: {{_target_: {method}}}\ntask: {{scale: 4}}\n", "config.yaml")


def precision_losses(method: str, loss: float) -> pd.DataFrame:
    """``loss`` and a hundredth of it a frame, another for every scene."""
    rows = [
        {
            "method": method,
            "architecture": architecture({"_target_": method}, 4),
            "backend": "openvino",
            "precision": "int8",
            "machine": MACHINE,
            "scene": scene,
            "clip": 0,
            "frame": t,
            "psnr": 30.0 + k,
            "changed": 30.0 + k - loss * (1 + 0.1 * k) - 0.01 * loss * t,
            "largest": 0.02 * (t + 1),
        }
        for k, scene in enumerate(SCENES)
        for t in range(11)
    ]
    return pd.DataFrame(rows)


@pytest.fixture(scope="module")
def reports(tmp_path_factory: pytest.TempPathFactory) -> Path:
    log = Log(tmp_path_factory.mktemp("store"))
    log_trainings(log)
    older = [example_timing("dlctus", "eager", ms=9999.0), example_timing("elsewhere", "eager", ms=0.1)]
    log_benchmark(log, older, precision=precision_losses("dlctus", 3.0).assign(method="by another name"))
    timings = [example_timing(m, b, ms=ms * f) for m, (_, ms) in METHODS.items() for b, f in FACTOR.items()]
    timings += [example_timing("dlctus", "openvino", "int8", 120.0), example_timing("tus", "openvino", "int8", 20.0)]
    timings += [example_timing(m, "compile", ms=np.nan, reason="There is no compiler.") for m in METHODS]
    parts = [("network", 200.0, 0.667), ("warp", 90.0, 0.3), ("(its own)", 10.0, 0.033)]
    keys = ["method", "architecture", "width", "height", "backend", "precision", "machine"]
    same = {key: getattr(example_timing("dlctus", "eager"), key) for key in keys}
    stages = [
        {**same, "part": p, "kind": "Sequential", "ms": ms, "low": ms, "high": ms, "share": s} for p, ms, s in parts
    ]
    log_benchmark(log, timings, stages=pd.DataFrame(stages), precision=precision_losses("dlctus", 0.3))
    output = tmp_path_factory.mktemp("out")
    report(config(log, output, paper=None))
    return output


def table(reports: Path, name: str) -> pd.DataFrame:
    return pd.read_csv(reports / f"overview_{name}.csv", keep_default_na=False)


def test_the_front_is_the_newest_times_with_the_runs_quality(reports: Path) -> None:
    rows = table(reports, "trade")
    shown = {(row.method, row.backend, row.precision): row for row in rows.itertuples()}
    on = [key for key, row in shown.items() if row[7] == "front"]
    assert on == [
        ("bicubic", "openvino", "float32"),
        ("jau", "openvino", "float32"),
        ("tus", "openvino", "float32"),
        ("dlctus", "openvino", "int8"),
        ("dlctus", "openvino", "float32"),
    ]
    assert "elsewhere" not in set(rows.method)
    assert ("tus", "openvino", "int8") not in shown  # its cost in quality is unknown
    times = [float(text.partition(" ")[0]) for text in rows["ms a frame"]]
    assert times == sorted(times)
    assert max(times) == 300.0  # not the older 9999
    truth = pd.read_csv(reports / "overview_overview.csv").set_index("method")["PSNR (dB)"]
    assert shown["dlctus", "eager", "float32"][5] == truth["dlctus"]
    long = pd.read_csv(reports / "overview_trade_long.csv").set_index(["method", "backend", "precision"])
    exact, coarse = (long.loc[("dlctus", "openvino", precision)] for precision in ("float32", "int8"))
    assert coarse.psnr - exact.psnr == pytest.approx(-0.3 * 1.1 - 0.01 * 0.3 * 5)
    assert coarse.precision_cost == pytest.approx(coarse.psnr - exact.psnr)
    assert len(exact.runs.split()) == 2


def test_what_precision_costs_and_what_a_frame_is_made_of(reports: Path) -> None:
    ((_, row),) = table(reports, "precision").iterrows()
    assert row["Δ PSNR (dB)"].startswith("−0.34")
    assert row["drift (dB a frame)"].startswith("−0.003")
    assert float(row["largest difference"]) == 0.22
    assert int(row["frames"]) == 33
    parts = table(reports, "stages")
    assert list(parts["part"]) == ["network", "warp", "(its own)"]
    assert list(parts["share"]) == ["67%", "30%", "3%"]
    missing = table(reports, "not_timed")
    assert list(missing["why"]) == ["There is no compiler."]
    assert missing["methods"][0] == ", ".join(METHODS)


def test_the_page_names_the_machine(reports: Path) -> None:
    text = " ".join(page.extract_text() for page in PdfReader(reports / "overview.pdf").pages)
    text = re.sub(r"\s+", " ", text)
    for expected in ("Quality against time", "1920x1080 on cpu, 2 threads", MACHINE, "There is no compiler."):
        assert expected in text
    assert len(PdfReader(reports / "overview_trade_figure1.pdf").pages) == 1
    for paper in ("dlctus", "nsrr"):
        pages = PdfReader(reports / f"{paper}.pdf").pages
        assert "Quality against time" not in " ".join(page.extract_text() for page in pages)


def test_a_store_without_benchmarks_says_so_in_one_line(tmp_path: Path) -> None:
    log = Log(tmp_path)
    log_trainings(log)
    report(config(log, tmp_path / "out", paper=None))
    text = " ".join(page.extract_text() for page in PdfReader(tmp_path / "out" / "overview.pdf").pages)
    assert "python benchmark.py run=all" in re.sub(r"\s+", " ", text)
    assert not list((tmp_path / "out").glob("*trade*"))


def test_a_broken_benchmark_is_told_and_the_rest_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = Log(tmp_path)
    log_trainings(log)
    log_benchmark(log, [example_timing(m, "eager", ms=ms) for m, (_, ms) in METHODS.items()])
    run = log.client.create_run(log.experiment, run_name="broken", tags={"ss.kind": "benchmark"}).info.run_id
    log.client.log_text(run, "[1, 2", timing.TABLE)
    log.client.set_terminated(run)
    report(config(log, tmp_path / "out", paper=None))
    assert f"run {run[:12]}: timings.json cannot be read" in capsys.readouterr().out
    assert len(table(tmp_path / "out", "trade")) == len(METHODS)


def test_tables_survive_json() -> None:
    """NaN and infinity are null there."""
    item = example_timing("a", "compile", ms=np.nan, low=np.nan, high=np.nan, reason="No.")
    raw = json.loads(timing.table([item]).to_json(orient="split"))
    (again,) = timing.timings_of(pd.DataFrame(raw["data"], columns=raw["columns"]))
    assert np.isnan(again.ms)
    assert replace(again, ms=0.0, low=0.0, high=0.0) == replace(item, ms=0.0, low=0.0, high=0.0)


def crowd() -> Trade:
    """Twelve methods, three of which share a point."""
    rng = np.random.default_rng(0)
    candidates = []
    for k in range(12):
        ms, mean = (20.0, 30.0) if k < 3 else (float(10 ** rng.uniform(0.5, 3)), float(rng.uniform(25, 33)))
        name = f"method_{k} with stage=other"
        run = example_run(name, method=name, model=name)
        quality = Estimate(mean, mean - 1, mean + 1, 9, 9)
        candidates.append(
            Candidate(label=name, runs=(run,), quality=quality, timing=example_timing(name, "eager", ms=ms))
        )
    timings = [c.timing for c in candidates]
    return Trade(candidates=candidates, timings=timings, stages=pd.DataFrame(), changes=[], clips={})


def test_labels_cover_no_mark_and_no_other_label() -> None:
    trade = crowd()
    figure = Figure(figsize=(trade_plot.WIDTH, trade_plot.HEIGHT))
    figure.canvas = FigureCanvasAgg(figure)
    ax = figure.subplots()
    ax.set_xscale("log")
    for item in trade.candidates:
        ax.plot(item.ms, item.quality.mean, "o", markersize=4.5)
    ax.margins(0.12)
    figure.draw_without_rendering()
    names = {c.label: c.label.split()[0] for c in trade.candidates}
    trade_plot._add_names(ax, trade.candidates, names, dict.fromkeys(names, "black"))
    boxes = [text.get_window_extent() for text in ax.texts]
    assert len(boxes) == 12
    for k, box in enumerate(boxes):
        assert not any(box.overlaps(rival.padded(-0.5)) for rival in boxes[:k])
        for item in trade.candidates:
            x, y = ax.transData.transform((item.ms, item.quality.mean))
            assert not (box.x0 < x < box.x1 and box.y0 < y < box.y1)


def test_the_same_times_give_the_same_bytes(tmp_path: Path) -> None:
    trade = crowd()
    (place,) = trade.places
    assert place == Place.of(trade.timings[0])
    for name in ("a.pdf", "b.pdf"):
        assert trade_plot.draw(trade, place, tmp_path / name)
    assert (tmp_path / "a.pdf").read_bytes() == (tmp_path / "b.pdf").read_bytes()
    assert not trade_plot.draw(trade, replace(place, width=1), tmp_path / "none.pdf")


def test_of_equals_the_fastest_is_the_best() -> None:
    candidates = crowd().candidates[:3]
    quick = replace(candidates[1], timing=replace(candidates[1].timing, ms=1.0))
    assert best_of([candidates[0], quick, candidates[2]]) is quick


def test_differences_to_the_best_are_paired(reports: Path) -> None:
    """The scenes differ by decibels, the methods' differences hardly."""
    rows = table(reports, "trade").set_index(["method", "backend", "precision"])
    assert rows.loc[("dlctus", "eager", "float32"), "Δ to the best (dB)"] == "best"
    mean, half = map(
        float, rows.loc[("bicubic", "eager", "float32"), "Δ to the best (dB)"].replace("−", "-").split(" ± ")
    )
    assert mean == pytest.approx(29.99 - 34.37, abs=0.15)
    assert half < 0.2
    assert float(rows.loc[("bicubic", "eager", "float32"), "PSNR (dB)"].split(" ± ")[1]) > 0.5
