"""Reports of stores that are broken, or not there."""

import itertools
import json
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mlflow import MlflowClient
from mlflow.exceptions import MlflowException
from pypdf import PdfReader
from stored_runs import FINGERPRINT, ROOT, Log, config, ours

from supersampling.commands.report import report
from supersampling.errors import UserError


@contextmanager
def changed(path: Path, content: bytes | None) -> Iterator[None]:
    """Within, a file of other content, or none."""
    original = path.read_bytes()
    try:
        path.unlink() if content is None else path.write_bytes(content)
        yield
    finally:
        path.write_bytes(original)


def clips_of(log: Log, name: str) -> tuple[str, Path]:
    runs = log.client.search_runs([log.experiment])
    run = next(run.info.run_id for run in runs if run.info.run_name == name)
    return run, log.folder / "artifacts" / run / "artifacts" / "clips.json"


def words(report: Path) -> str:
    text = " ".join(page.extract_text() for page in PdfReader(report / "dlctus.pdf").pages)
    return re.sub(r"\s+", " ", text)


@pytest.mark.parametrize(
    ("content", "message"), [(b"{}", "clips.json cannot be read"), (None, "it has no table of its clips")]
)
def test_a_table_that_is_broken_or_missing_is_told_and_the_rest_is_reported(
    content: bytes | None, message: str, log: Log, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its run shows the logged average, without an interval."""
    broken, path = clips_of(log, "jau x4")
    with changed(path, content):
        report(config(log, tmp_path))
    assert f"run {broken[:12]}: {message}" in capsys.readouterr().out
    text = words(tmp_path)
    assert "1 of the runs lack values" in text
    assert message in text
    cell = ours(tmp_path, 2).loc["4×4/1", "JAU", "PSNR"]
    assert 25 < cell.ours < 40
    assert np.isnan(cell.half_width_95)
    assert ours(tmp_path, 2).loc["4×4/1", "TUS", "PSNR"].half_width_95 > 0


def test_a_value_that_is_not_a_number_leaves_its_clip_out_and_is_told(log: Log, tmp_path: Path) -> None:
    _, path = clips_of(log, "jau x4")
    table = json.loads(path.read_text())
    column = table["columns"].index("psnr")
    original = [row[column] for row in table["data"]]
    table["data"][5][column] = float("nan")
    with changed(path, json.dumps(table).encode()):
        report(config(log, tmp_path))
    assert "psnr has no value on clip 1 of foundry: left out" in words(tmp_path)
    cell = ours(tmp_path, 2).loc["4×4/1", "JAU", "PSNR"]
    assert cell.clips == 11
    assert cell.ours == pytest.approx(np.mean(original[:5] + original[6:]))


def test_a_store_that_goes_away_half_way_leaves_cells_without_intervals_and_says_so(
    log: Log, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    answer, calls = MlflowClient.download_artifacts, itertools.count()

    def gone(client: MlflowClient, *args: Any) -> str:
        if next(calls) >= 4:
            raise MlflowException("Connection refused")
        return answer(client, *args)

    def no_history(client: MlflowClient, *args: Any) -> None:
        raise MlflowException("Connection refused")

    monkeypatch.setattr(MlflowClient, "download_artifacts", gone)
    monkeypatch.setattr(MlflowClient, "get_metric_history", no_history)
    report(config(log, tmp_path, paper=None))
    assert "clips.json could not be downloaded (Connection refused)" in words(tmp_path)
    assert "Connection refused" in " ".join(page.extract_text() for page in PdfReader(tmp_path / "overview.pdf").pages)


def test_a_store_that_gives_nothing_at_all_is_an_error(
    log: Log, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def gone(client: MlflowClient, *args: Any) -> None:
        raise MlflowException("Connection refused")

    monkeypatch.setattr(MlflowClient, "download_artifacts", gone)
    with pytest.raises(UserError, match="gave no run's scores"):
        report(config(log, tmp_path / "out"))
    assert not (tmp_path / "out").exists()


def test_runs_of_another_version_fill_only_what_their_parameters_still_mean(tmp_path: Path) -> None:
    """An old run without the mip bias is of a task of its own; its version stands in the head of a report about it."""
    log = Log(tmp_path)
    for model in ("jau", "tus"):
        log.run(model, 31.0, f"{model} x4")
    log.run("jau", 44.0, "old", params={"task.mip_bias": ""}, tags={"ss.version": "0.0.1"})
    out = tmp_path / "out"
    report(config(log, out))
    assert ours(out, 2).loc["4×4/1", "JAU", "PSNR"].ours < 40
    assert "0.0.1" not in words(out)
    report(config(log, out, dataset=FINGERPRINT[:4]))
    assert "1 finished ones of other settings" in words(out)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"experiment_name": "nothing"}, "nothing"),
        ({"tracking_uri": "sqlite:///no/such.db"}, "no/such.db"),
        ({"tracking_uri": "http://127.0.0.1:9"}, "127.0.0.1:9"),
        ({"dataset": "zz"}, "zz"),
        ({"budget": "paper"}, "paper"),
        ({"paper": "unknown"}, "unknown"),
    ],
)
def test_mistakes_are_told(log: Log, tmp_path: Path, change: dict[str, str], message: str) -> None:
    with pytest.raises(UserError, match=re.escape(message)):
        report(config(log, tmp_path / "out", **change))
    assert not (tmp_path / "out").exists()


def test_the_entry_point_tells_a_mistake_without_a_stack_trace(tmp_path: Path) -> None:
    command = [sys.executable, str(ROOT / "report.py"), f"tracking_uri=sqlite:///{tmp_path}/none.db"]
    result = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert result.returncode == 2
    assert "none.db" in result.stderr
    assert "Traceback" not in result.stderr
    assert list(tmp_path.iterdir()) == []
