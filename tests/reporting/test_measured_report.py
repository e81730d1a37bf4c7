"""Benchmarks in reports: from a store of MLflow to the files of a report, and claims about times."""

from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from made_up_benchmarks import MACHINE, MadeUpStore, number
from stored_runs import Log, config

from supersampling.commands.report import report
from supersampling.errors import UserError
from supersampling.reporting.papers.claims import choose_claim, judge
from supersampling.reporting.papers.published import load_paper
from supersampling.reporting.papers.schema import Claim
from supersampling.reporting.settings import Choice, Setting
from supersampling.resources import resources
from supersampling.runs.measurements import Measurement, read_measurements
from supersampling.runs.store import Store

PUBLISHED = resources() / "reports" / "published"
THESIS = "python benchmark.py methods=[dlctus] scales=[2,4] backends=[eager,thesis_1,thesis_1_2] depth=3"
SETTING = Setting(dataset="", data="", scenes="", scale="4", mip_bias="", budget="")


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Log:
    """A scored method, the thesis's benchmark, a later one without parameters (of an earlier version), one that
    failed."""
    log = Log(tmp_path_factory.mktemp("store"))
    log.run("jau", 31.0, "jau x4")
    (tables,) = MadeUpStore(THESIS).tables
    for status, left_out in (("FINISHED", ""), ("FINISHED", "parameters.json"), ("FAILED", "")):
        tags = {"ss.kind": "benchmark", "ss.machine": MACHINE}
        run = log.client.create_run(log.experiment, run_name="benchmark", tags=tags).info.run_id
        for name, table in tables.items():
            if name != left_out:
                log.client.log_table(run, table, name)
        log.client.set_terminated(run, status)
    return log


def test_measurements_of_a_store(log: Log, tmp_path: Path) -> None:
    items = read_measurements(Store(log.uri, tmp_path), log.experiment)
    assert len(items) == 6  # two scales, three backends
    (plain,) = [i for i in items if (i.run.params["task.scale"], i.run.params["backend"]) == ("2", "eager")]
    assert plain.run.params.items() >= {"model": "dlctus", "model.reproject": "bicubic9", "size": "1920x1080"}.items()
    at = ("dlctus", 2, "1920x1080", "eager", "float32")
    assert plain.value("ms") == number(*at, "whole")
    assert plain.value("ms", "network.up") == number(*at, "network.up")
    assert (plain.value("parameters"), plain.value("gmac")) == (7.0, 0.5)
    assert plain.where == f"float32, cpu, 2 threads; {MACHINE}"


def test_sums_and_alternatives_of_parts() -> None:
    (run,) = MadeUpStore(THESIS).runs
    item = Measurement(benchmark=run, run=run, quantities={"ms": {"whole": 9.0, "a": 4.0, "a.b": 1.0, "c-d": 0.5}})
    assert item.value("ms", "a - a.b + c-d") == 3.5
    assert item.value("ms", "missing|a.b") == 1.0
    assert item.value("ms", "a + missing|whole - a") == 5.0
    assert item.value("ms", "a + missing") is None
    assert item.value("gmac", "a") is None


def test_report_of_a_store(log: Log, tmp_path: Path) -> None:
    report(config(log, tmp_path, paper="dlctus"))
    table = pd.read_csv(tmp_path / "dlctus_table8.csv").set_index(["row", "column"])
    cell = table.loc["2×2/1 & 2", "Network Execution"]
    assert cell.ours == pytest.approx(1000 * number("dlctus", 2, "1920x1080", "thesis_1_2", "float32", "network"))
    assert (cell.published, cell.unit, cell.state) == (1674, "µs", "run")
    assert set(table.state) == {"run"}
    text = (tmp_path / "dlctus_table8.md").read_text()
    assert f"Measured by “{THESIS}”." in text
    assert f"Ours, measured: eager and thesis_1 and thesis_1_2, float32, cpu, 2 threads; {MACHINE}." in text
    assert "Of two machines' times only ratios compare." in text
    other = (tmp_path / "dlctus_table12.md").read_text()
    assert "not run" in other
    assert "Measured by “python benchmark.py 'methods=" in other
    assert "Ours, measured: thesis_1_2, float32" in other  # the third column is in the first benchmark too


def claim(**more: object) -> Claim:
    base = {"model": "dlctus", "task.scale": "4", "size": "1920x1080"}
    sides = {"a": {"backend": "thesis_1_2"}, "b": {"backend": "eager"}}
    fields = {"id": "x-1", "text": "It is faster.", "source": "Table 8", "kind": "less", "unit": "ms", **sides, **more}
    return Claim(metric="benchmark:ms", base=base, **fields)  # type: ignore[arg-type]


@pytest.mark.parametrize(("kind", "part"), [("less", "network"), ("more", "network"), ("less", ""), ("less", "total")])
def test_claims_about_two_backends(kind: str, part: str) -> None:
    measurements = read_measurements(MadeUpStore(THESIS), "0")  # type: ignore[arg-type]
    statement = claim(kind=kind)
    if part:
        statement = replace(statement, base={**statement.base, "part": part})
    result = judge(choose_claim(statement, Choice(SETTING, {}), measurements), {})
    a, b = (number("dlctus", 4, "1920x1080", name, "float32", part or "whole") for name in ("thesis_1_2", "eager"))
    assert result.effect is not None
    assert result.effect.mean == pytest.approx(a - b)
    assert result.verdict == ("reproduced" if (a < b) == (kind == "less") else "contradicted")


def test_claim_about_a_factor_and_about_nothing_measured() -> None:
    measurements = read_measurements(MadeUpStore(THESIS), "0")  # type: ignore[arg-type]
    a, b = (number("dlctus", 4, "1920x1080", name, "float32", "total") for name in ("thesis_1_2", "eager"))
    sides = {"a": {"backend": "eager", "part": "total"}, "b": {"backend": "thesis_1_2", "part": "total"}}
    if b > a:
        sides = {"a": sides["b"], "b": sides["a"]}
    for times, verdict in (
        (0.99 * max(a, b) / min(a, b), "reproduced"),
        (1.01 * max(a, b) / min(a, b), "contradicted"),
    ):
        selected = choose_claim(claim(times=times, **sides), Choice(SETTING, {}), measurements)
        assert judge(selected, {}).verdict == verdict
    same = claim(a={"backend": "eager"}, b={"backend": "eager", "threads": "2"})
    assert judge(choose_claim(same, Choice(SETTING, {}), measurements), {}).verdict == "unresolved"
    missing = judge(choose_claim(claim(b={"backend": "native"}), Choice(SETTING, {}), measurements), {})
    assert (missing.verdict, missing.reason) == ("not run", "no run with backend=native")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "size: 1920x1080, backend: eager",
            "backend: eager",
            r"table 6: Missing size of \['time \(µs\)'\] and Conv3x3",
        ),
        ("logged: benchmark:ms", "logged: benchmark:seconds", r"stage_time: Invalid logged=benchmark:seconds: use"),
        ("metric: run:time/onnxruntime/ms", "metric: benchmark:ms", "claim dlctus-22: Missing size of metric="),
        (f"    command: {THESIS}\n", "", "table 6: Missing command of a benchmark: metric"),
    ],
)
def test_mistakes_in_a_file(tmp_path: Path, old: str, new: str, message: str) -> None:
    text = (PUBLISHED / "dlctus.yaml").read_text()
    assert old in text
    (tmp_path / "dlctus.yaml").write_text(text.replace(old, new, 1))
    with pytest.raises(UserError, match=message):
        load_paper(tmp_path / "dlctus.yaml")
