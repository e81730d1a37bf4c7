"""The whole path: runs logged to a temporary MLflow store, as the trainer logs them, to a PDF and tables."""

import datetime
import json
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from mlflow import MlflowClient
from mlflow.entities import Metric, Param
from omegaconf import DictConfig, OmegaConf
from PIL import Image
from pypdf import PdfReader

from supersampling.errors import UserError
from supersampling.reporting.document import write_report

ROOT = Path(__file__).resolve().parents[2]
SCENES = ("atrium", "foundry", "stk/zengarden")
FINGERPRINT = "3fa9c07715d2e8b1"
CLASSICAL = {"bicubic": 29.99, "jau": 31.83, "tus": 33.68}
STAGES = {
    "reproject": "bicubic9", "dilate": "none", "accumulate": "buffer", "pad": "jitter_aligned",
    "confine": "straight_through", "initialise": "balanced",
}  # fmt: skip


class Log:
    """Logs one job's run with made-up numbers around a mean PSNR; every method sees the same hard and easy clips."""

    def __init__(self, folder: Path) -> None:
        self.uri = f"sqlite:///{folder / 'mlflow.db'}"
        self.folder = folder
        self.client = MlflowClient(self.uri)
        self.experiment = self.client.create_experiment("supersampling", (folder / "artifacts").as_uri())

    def run(
        self, model: str, psnr: float, name: str, status: str = "FINISHED", clips: int = 4, **other: Any
    ) -> str:
        params = {"model": model, "task.scale": 4, "task.mip_bias": "matched", "data": "laptop"}
        params["data.scenes"] = ",".join(SCENES)
        if model == "dlctus":
            params |= {f"model.{stage}": option for stage, option in STAGES.items()}
            params |= {"loss": "l1", "budget": "laptop", "seed": 0}
        if model == "tus":
            params |= {"model.reproject": "bicubic9", "model.dilate": "none", "model.rectify": "clamp_rgb"}
        params |= other.pop("params", {})
        tags = {
            "ss.kind": "job", "ss.identity": name, "ss.dataset": FINGERPRINT, "ss.method": model,
            "ss.machine": "Linux x86_64, 2 threads, torch 2.14.1", "ss.version": "0.1.0",
        } | other.pop("tags", {})  # fmt: skip
        run = self.client.create_run(self.experiment, run_name=name, tags=tags).info.run_id
        frames = _frames(psnr, clips, int(params.get("seed", 0)))
        table = (
            frames.groupby(["scene", "clip"], sort=False)[
                ["psnr", "ssim", "mssim_thesis", "spatial", "temporal"]
            ]
            .mean()
            .reset_index()
        )
        self.client.log_table(run, table, "clips.json")
        self.client.log_table(run, frames, "frames.json")
        metrics = [Metric("test/psnr", float(table.psnr.mean()), 0, 0)]
        metrics.append(Metric("model/parameters", 80034.0 if model == "dlctus" else 0.0, 0, 0))
        if model == "dlctus":
            metrics.append(Metric("train/minutes", 3.25, 0, 0))
            for epoch in range(6):
                metrics.append(Metric("train/loss", 0.05 / (1 + epoch), 0, epoch))
                metrics.append(Metric("val/psnr", psnr - 3 / (1 + epoch), 0, epoch))
        self.client.log_batch(run, metrics, [Param(key, str(value)) for key, value in params.items()])
        self._crops(run, psnr)
        self.client.set_terminated(run, status)
        return run

    def _crops(self, run: str, psnr: float) -> None:
        folder = self.folder / "crops"
        folder.mkdir(exist_ok=True)
        for index, scene in enumerate(SCENES):
            rng = np.random.default_rng(index)
            y, x = np.mgrid[0:96, 0:96] / 96
            wave = np.stack([np.sin(9 * x * (1 + c) + index) * np.cos(23 * y * x) for c in range(3)], axis=-1)
            target = 128 + 90 * wave
            noise = rng.normal(size=target.shape) * (x > 0.5)[..., None] * 255 * 10 ** (-psnr / 20)
            raw = target[::4, ::4].repeat(4, axis=0).repeat(4, axis=1)
            for suffix, image in (("", target + noise), ("_target", target), ("_input", raw)):
                path = folder / f"{index}_{scene.replace('/', '_')}{suffix}.png"
                Image.fromarray(np.clip(image, 0, 255).astype(np.uint8)).save(path)
        self.client.log_artifacts(run, str(folder), "crops")
        shutil.rmtree(folder)


def _frames(psnr: float, clips: int, seed: int) -> pd.DataFrame:
    rows = []
    for s, scene in enumerate(SCENES):
        for clip in range(clips):
            rng = np.random.default_rng([s, clip])
            hardness, rng = rng.normal(scale=2.5), np.random.default_rng([s, clip, seed, int(100 * psnr)])
            for frame in range(12):
                p = psnr + hardness + rng.normal(scale=0.2) + 2 * min(frame, 6) / 6 - 1.5
                ssim = 1 - 10 ** (-p / 30)
                rows.append(
                    (scene, clip, frame, p, ssim, ssim - 0.02, 10 ** (-p / 20), 0.3 * 10 ** (-p / 20))
                )
    return pd.DataFrame(
        rows, columns=["scene", "clip", "frame", "psnr", "ssim", "mssim_thesis", "spatial", "temporal"]
    )


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Log]:
    """A sweep's runs: classical methods, three seeds of DLCTUS, ablations, and runs that must not count."""
    log = Log(tmp_path_factory.mktemp("store"))
    for model, psnr in CLASSICAL.items():
        log.run(model, psnr, f"{model} x4")
    for seed in range(3):
        log.run("dlctus", 34.37, f"dlctus l1 seed={seed} x4", params={"seed": seed})
    log.run("dlctus", 33.00, "dlctus reproject=bilinear l1 seed=0 x4", params={"model.reproject": "bilinear"})
    log.run("dlctus", 34.31, "dlctus accumulate=none l1 seed=0 x4", params={"model.accumulate": "none"})
    for theta in (0.1, 0.5):
        params = {"loss": "spatiotemporal", "loss.theta": theta}
        log.run("dlctus", 34.3 - theta, f"dlctus theta={theta} seed=0 x4", params=params)
    log.run("dlctus", 99.0, "failed", status="FAILED", params={"model.dilate": "closest"})
    log.run("dlctus", 99.0, "sweep", tags={"ss.kind": "sweep"})
    log.run("dlctus", 55.0, "other budget", params={"budget": "smoke"})
    log.run("jau", 44.0, "jau x2", params={"task.scale": 2}, tags={"ss.dataset": "77aa00bb11cc22dd"})
    return log


def config(log: Log, output: Path, **more: Any) -> DictConfig:
    cfg = OmegaConf.load(ROOT / "conf" / "report.yaml")
    del cfg["defaults"], cfg["hydra"]
    return OmegaConf.merge(cfg, {"tracking_uri": log.uri, "output": str(output), "paper": "dlctus", **more})  # type: ignore[return-value]


@pytest.fixture(scope="module")
def report(log: Log, tmp_path_factory: pytest.TempPathFactory) -> Path:
    output = tmp_path_factory.mktemp("out")
    write_report(config(log, output))
    return output


def ours(report: Path, table: int) -> pd.DataFrame:
    return pd.read_csv(report / f"dlctus_table{table}.csv").set_index(["row", "column", "metric"])


def mean_of(log: Log, metric: str, names: tuple[str, ...]) -> float:
    """The truth of a cell, by hand: mean over the named runs of the mean over their clips."""
    runs = log.client.search_runs([log.experiment])
    paths = [
        log.client.download_artifacts(r.info.run_id, "clips.json") for r in runs if r.info.run_name in names
    ]
    assert len(paths) == len(names)
    tables = [json.loads(Path(path).read_text()) for path in paths]
    return float(np.mean([[row[t["columns"].index(metric)] for row in t["data"]] for t in tables]))


def test_a_cell_is_the_mean_over_clips_and_seeds(report: Path, log: Log) -> None:
    table = ours(report, 2)
    seeds = tuple(f"dlctus l1 seed={seed} x4" for seed in range(3))
    cell = table.loc["4×4/1", "DLCTUS", "PSNR"]
    assert cell.ours == pytest.approx(mean_of(log, "psnr", seeds), abs=1e-9)
    assert cell.seeds == 3
    assert cell.clips == 12
    assert cell.published == 35.49
    assert table.loc["4×4/1", "DLCTUS", "SSIM"].ours == pytest.approx(
        mean_of(log, "mssim_thesis", seeds), abs=1e-9
    )


def test_what_was_not_run_or_lacks_is_said(report: Path) -> None:
    assert ours(report, 2).loc["4×4/1", "Xiao et al.", "PSNR"].state == "not run"
    assert "not measured" in set(ours(report, 7).state)
    assert set(ours(report, 7).loc["1"].state) == {"not available"}
    assert ours(report, 2).loc["2×2/2", "DLCTUS", "PSNR"].state == "not run"
    assert ours(report, 14).loc["4×4/1", "dilated motion vectors", "PSNR"].state == "not run"


def test_another_data_set_fills_only_its_own_row_and_is_named(report: Path) -> None:
    cell = ours(report, 2).loc["2×2/1", "JAU", "PSNR"]
    assert 42 < cell.ours < 46
    assert "77aa00bb" in cell.setting
    assert "77aa00bb" in (report / "dlctus_table2.md").read_text()


def test_losses_are_found_by_theta_at_the_scale_that_was_run(report: Path, log: Log) -> None:
    table = ours(report, 10)
    percent = table.loc["θ = 0.5", "SSIM × 100", "SSIM × 100"]
    assert percent.ours == pytest.approx(100 * mean_of(log, "mssim_thesis", ("dlctus theta=0.5 seed=0 x4",)))
    assert percent.published == 93.58
    assert table.loc["θ = 0.9", "PSNR (dB)", "PSNR"].state == "not run"
    assert "4×4, matched, data=laptop (3fa9c077), budget=laptop" in table.iloc[0].setting


def test_the_lead_of_the_best_is_paired_over_clips(report: Path, log: Log) -> None:
    seeds = tuple(f"dlctus l1 seed={seed} x4" for seed in range(3))
    lead = mean_of(log, "psnr", seeds) - mean_of(log, "psnr", ("dlctus accumulate=none l1 seed=0 x4",))
    text = (report / "dlctus_table16.md").read_text()
    found = re.search(r"paired over clips: 4×4/1 ([\d.]+) \(([\d.]+) to ([\d.]+)\)", text)
    assert found is not None
    mean, low, high = map(float, found.groups())
    assert mean == pytest.approx(lead, abs=0.006)
    # Unpaired, the clips' spread of 2.5 dB would make this half-width about 1 dB.
    assert 0 < high - low < 0.3


def test_the_pdf_holds_the_report(report: Path) -> None:
    reader = PdfReader(report / "dlctus.pdf")
    text = " ".join(page.extract_text() for page in reader.pages)
    text = re.sub(r"\s+", " ", text)
    for expected in (
        FINGERPRINT,
        "Xiao et al.",
        "not run",
        "35.49",
        "unresolved",
        "dlctus l1 seed=2 x4",
        "Linux x86_64",
    ):
        assert expected in text
    assert "99.0" not in text
    assert len(reader.pages) <= 12


def test_the_same_runs_give_the_same_bytes(report: Path, log: Log, tmp_path: Path) -> None:
    write_report(config(log, tmp_path))
    names = sorted(path.name for path in report.iterdir())
    assert names == sorted(path.name for path in tmp_path.iterdir())
    assert not [name for name in names if name.startswith(".")]
    same_day = (
        datetime.datetime.now(datetime.UTC).date().isoformat()
        in PdfReader(report / "dlctus.pdf").pages[0].extract_text()
    )
    for name in names:
        if same_day or name != "dlctus.pdf":
            assert (report / name).read_bytes() == (tmp_path / name).read_bytes(), name


def test_a_claim_is_judged_on_paired_clips(report: Path, log: Log) -> None:
    claims = pd.read_csv(report / "dlctus_claims.csv").set_index("claim")
    told = claims[claims.statement.str.contains("ahead of jitter-aligned")].iloc[0]
    lead = mean_of(log, "psnr", ("tus x4",)) - mean_of(log, "psnr", ("jau x4",))
    assert told.verdict == "reproduced"
    assert told.ours == pytest.approx(lead)
    assert told.low_95 < lead < told.high_95
    assert told.holds_on == "atrium foundry stk/zengarden"
    assert "not run" in set(claims.verdict)


def test_all_papers_and_an_overview(log: Log, tmp_path: Path) -> None:
    papers = sorted(path.stem for path in (ROOT / "reports" / "published").glob("*.yaml"))
    written = write_report(config(log, tmp_path, paper=None))
    assert [path.name for path in written] == [*(f"{name}.pdf" for name in papers), "overview.pdf"]
    text = " ".join(page.extract_text() for page in PdfReader(tmp_path / "overview.pdf").pages)
    assert "All methods and all claims" in text
    assert FINGERPRINT in text
    claims = pd.read_csv(tmp_path / "overview_claims.csv").claim
    assert {name.split("-")[0] for name in claims} <= set(papers)
    assert {"overview_front.pdf", "overview_frames.pdf", "overview_training.pdf", "overview_dataset.csv"} <= {
        path.name for path in tmp_path.iterdir()
    }


def test_what_cannot_be_read_is_told_and_the_rest_is_reported(
    log: Log, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A table that is no table: its run shows the logged average, without an interval."""
    runs = log.client.search_runs([log.experiment])
    broken = next(run.info.run_id for run in runs if run.info.run_name == "jau x4")
    path = log.folder / "artifacts" / broken / "artifacts" / "clips.json"
    kept = path.read_text()
    try:
        path.write_text("{}")
        write_report(config(log, tmp_path))
    finally:
        path.write_text(kept)
    assert f"run {broken[:12]}: clips.json cannot be read" in capsys.readouterr().out
    cell = ours(tmp_path, 2).loc["4×4/1", "JAU", "PSNR"]
    assert 25 < cell.ours < 40
    assert np.isnan(cell.half_width_95)
    assert ours(tmp_path, 2).loc["4×4/1", "TUS", "PSNR"].half_width_95 > 0


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"experiment": "nothing"}, "nothing"),
        ({"tracking_uri": "sqlite:///no/such.db"}, "no/such.db"),
        ({"tracking_uri": "http://127.0.0.1:9"}, "127.0.0.1:9"),
        ({"dataset": "zz"}, "zz"),
        ({"budget": "paper"}, "paper"),
        ({"paper": "unknown"}, "unknown"),
    ],
)
def test_mistakes_are_told(log: Log, tmp_path: Path, change: dict[str, str], told: str) -> None:
    with pytest.raises(UserError, match=re.escape(told)):
        write_report(config(log, tmp_path / "out", **change))
    assert not (tmp_path / "out").exists()


def test_the_entry_point_tells_a_mistake_without_a_stack_trace(tmp_path: Path) -> None:
    command = [sys.executable, str(ROOT / "report.py"), f"tracking_uri=sqlite:///{tmp_path}/none.db"]
    result = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert result.returncode == 2
    assert "none.db" in result.stderr
    assert "Traceback" not in result.stderr
    assert list(tmp_path.iterdir()) == []
