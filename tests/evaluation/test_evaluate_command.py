"""``evaluate.py`` and scoring again, on analytic clips and an MLflow store for each test."""

import numpy as np
import pytest
from image_files import write_png
from mlflow.tracking import MlflowClient

from supersampling.commands.evaluate import evaluate
from supersampling.commands.train import train
from supersampling.data.dataset_file import DatasetFile
from supersampling.errors import UserError

SMOKE = ["budget=smoke", "workers=0", "trainer.enable_progress_bar=false", "baselines=[]", "budget.epochs=1"]


@pytest.fixture
def settings(make_file, tmp_path):
    files = [f"data.{s}=[{make_file(tmp_path, s, frames=6)}]" for s in ("train", "val", "test")]
    tracking = f"tracking_uri=sqlite:///{tmp_path}/mlflow.db"
    return ["data=files", "scene=atrium", "threads=1", f"paths.root={tmp_path}", tracking, *files]


@pytest.fixture
def runs(tmp_path):
    def find(kind):
        client = MlflowClient(f"sqlite:///{tmp_path}/mlflow.db")
        known = client.get_experiment_by_name("supersampling").experiment_id
        return client.search_runs([known], f"tags.`ss.kind` = '{kind}'", order_by=["start_time ASC"])

    return find


@pytest.fixture
def frames(settings, tmp_path):
    """The output of another program for the test clips: half as bright as the targets."""
    path = settings[-1].partition("=[")[2][:-1]
    store = DatasetFile(path)
    for clip in range(store.clips):
        folder = tmp_path / "other" / str(clip)
        folder.mkdir(parents=True)
        for t, image in enumerate(store.read("target", clip, slice(None)).transpose(0, 2, 3, 1)):
            write_png(folder / f"{t:04d}.png", np.rint(image * 127).astype(np.uint8))
    return tmp_path / "other"


def test_frames_of_another_program_become_baseline_once(entry, settings, runs, frames, capsys):
    overrides = [*settings, f"frames={frames}", "name=theirs", "metrics=fast"]
    evaluate(entry("evaluate", *overrides))
    (run,) = runs("job")
    assert run.data.tags["ss.method"] == "theirs"
    store = DatasetFile(settings[-1].partition("=[")[2][:-1])
    values = []
    for clip in range(store.clips):
        target = store.read("target", clip, slice(None)).astype(np.float64)
        error = target - np.rint(target * 127) / 255
        values.append(np.mean(-10 * np.log10(np.square(error).mean(axis=(1, 2, 3)))))
    assert run.data.metrics["test/psnr"] == pytest.approx(np.mean(values), abs=1e-3)
    assert run.data.params["protocol"] == "continuous"
    capsys.readouterr()
    evaluate(entry("evaluate", *overrides))
    assert "theirs: scored before" in capsys.readouterr().out
    assert len(runs("job")) == 1


def test_sanity_rows(entry, settings, runs, capsys):
    evaluate(entry("evaluate", *settings, "model=bicubic", "metrics=capture"))
    sanity = {run.data.tags["ss.method"]: run.data.metrics for run in runs("sanity")}
    reference, raw = sanity["reference"], sanity["raw input"]
    assert reference["test/psnr"] == 100.0
    for name in ("ssim", "ssim_uniform11", "ssim_zero_pad11"):
        assert reference[f"test/{name}"] == pytest.approx(1.0, abs=1e-5)
    for name in ("spatial", "temporal", "strred"):
        assert reference[f"test/{name}"] == 0.0
    assert reference["test/warping_error_photometric_ratio"] == 1.0
    (run,) = runs("evaluation")
    assert raw["test/psnr"] < run.data.metrics["test/psnr"] < 100.0
    printed = capsys.readouterr().out
    assert "raw input" in printed
    assert "reference" in printed
    assert "evaluate" not in {run.data.tags["ss.kind"] for run in runs("job")}


def test_finished_job_is_scored_again_for_a_missing_metric(entry, settings, runs, tmp_path, capsys):
    small = [*settings, *SMOKE]
    train(entry("train", *small, "metrics=fast"))
    (first,) = runs("job")
    (weights,) = (tmp_path / "outputs" / "checkpoints").glob("*/last.ckpt")
    written = weights.stat().st_mtime_ns
    train(entry("train", *small, "metrics=fast"))
    assert "finished before" in capsys.readouterr().out
    train(entry("train", *small, "metrics=capture"))
    (again,) = runs("job")
    assert again.info.run_id == first.info.run_id
    assert again.info.status == "FINISHED"
    assert "test/vmaf" in again.data.metrics
    assert "test/vmaf" not in first.data.metrics
    assert again.data.metrics["test/psnr"] == first.data.metrics["test/psnr"]
    assert weights.stat().st_mtime_ns == written
    assert again.data.metrics["train/minutes"] == first.data.metrics["train/minutes"]


def test_another_protocol_is_another_run_of_the_same_weights(entry, settings, runs, tmp_path):
    small = [*settings, *SMOKE, "metrics=fast"]
    train(entry("train", *small))
    (weights,) = (tmp_path / "outputs" / "checkpoints").glob("*/last.ckpt")
    written = weights.stat().st_mtime_ns
    train(entry("train", *small, "protocol=eight_bit"))
    first, second = runs("job")
    assert (first.data.params["protocol"], second.data.params["protocol"]) == ("continuous", "eight_bit")
    assert second.data.metrics["test/psnr"] == pytest.approx(first.data.metrics["test/psnr"], abs=0.05)
    assert second.data.metrics["test/psnr"] != first.data.metrics["test/psnr"]
    assert weights.stat().st_mtime_ns == written


def test_choices_that_exclude_each_other(entry, settings):
    with pytest.raises(UserError, match="run=1 and frames=there exclude each other"):
        evaluate(entry("evaluate", *settings, "run=1", "frames=there"))
    with pytest.raises(UserError, match="Invalid space=log: use display or radiance"):
        evaluate(entry("evaluate", *settings, "frames=there", "space=log", "metrics=fast"))
