"""``stress.py`` from its configuration to the MLflow run, and its messages for mistakes."""

import json
from pathlib import Path

import pytest
import torch
from mlflow.tracking import MlflowClient

from supersampling.commands.stress import TOLERANCE_STATUS, stress
from supersampling.config import group_options
from supersampling.errors import UserError
from supersampling.runs import tables
from supersampling.runs.checkpoint import KEY
from supersampling.stress import precision
from supersampling.stress.cell import COLUMNS
from supersampling.stress.memory import estimate_gigabytes, explain_too_large
from supersampling.stress.plan import EXTREMES, GROUPS, SPECIAL_GROUPS, select_extremes
from supersampling.stress.source import select_models


@pytest.fixture
def overrides(tmp_path):
    store = f"tracking_uri=sqlite:///{tmp_path}/mlflow.db"
    return ["threads=1", "device=cpu", "size=[6,5]", f"paths.root={tmp_path}", store]


def table_of(tmp_path):
    client = MlflowClient(f"sqlite:///{tmp_path}/mlflow.db")
    experiment = client.get_experiment_by_name("supersampling").experiment_id
    (run,) = client.search_runs([experiment])
    path = Path(client.download_artifacts(run.info.run_id, tables.STRESS, str(tmp_path)))
    return run, json.loads(path.read_text())


def test_table_is_logged_and_printed(entry, overrides, tmp_path, capsys):
    models = "models=[jau,'tus model/reproject=bilinear']"
    extremes = "extremes=[motion,gate,recovery]"
    assert stress(entry("stress", *overrides, models, extremes, "precisions=[float32]")) == 0
    run, table = table_of(tmp_path)
    assert table["columns"] == COLUMNS
    rows = [dict(zip(table["columns"], row)) for row in table["data"]]
    assert {row["model"] for row in rows} == {"jau", "tus model/reproject=bilinear"}
    assert {row["extreme"].split("/")[0] for row in rows} == {"motion", "gate", "recovery"}
    assert {row["verdict"] for row in rows} == {"holds"}
    assert not any(
        row["extreme"].startswith("motion") for row in rows if row["model"] == "jau"
    )  # it does not read motion
    assert run.data.tags["ss.kind"] == "stress"
    assert run.data.tags["ss.machine"]
    assert run.info.status == "FINISHED"
    assert run.data.metrics["stress/fails"] == 0
    out = capsys.readouterr().out
    assert f"{len(rows)} cells hold, 0 fail, 0 were not tried" in out
    assert "recovery/state NaN" in out


def test_failed_verdict_is_printed_and_sets_the_status(entry, overrides, monkeypatch, tmp_path, capsys):
    strict = precision.Precision(name="float32", largest=1e-30, mean=1e-30, reason="")
    monkeypatch.setitem(precision.PRECISIONS, "float32", strict)
    cfg = entry("stress", *overrides, "models=[jau]", "extremes=[scale]", "precisions=[float32]")
    assert stress(cfg) == TOLERANCE_STATUS
    out = capsys.readouterr().out
    assert "fails" in out
    assert "above 1e-30" in out
    assert table_of(tmp_path)[0].data.metrics["stress/fails"] > 0


@pytest.mark.parametrize(
    ("mistake", "message"),
    [
        (["extremes=[velocity]"], "Unknown extreme velocity"),
        (["extremes=[motion/sideways]"], "motion/sideways"),
        (["precisions=[float8]"], "Unknown precision float8"),
        (["models=[dlss]"], "model=dlss task.scale=4 cannot be composed"),
        (["effort=huge"], "effort=huge"),
        (["size=[0,5]"], r"size=\[0, 5\]"),
        (["size=[5]"], r"size=\[5\]"),
        (["device=tpu"], "device=tpu"),
        (["run=a", "checkpoint=b"], "exclude each other"),
        (["checkpoint=nowhere.ckpt"], "nowhere.ckpt"),
    ],
)
def test_mistakes(entry, overrides, mistake, message):
    with pytest.raises(UserError, match=message) as error:
        stress(entry("stress", *overrides, *mistake))
    assert "\n" not in str(error.value)


def test_missing_precision(entry, overrides, monkeypatch):
    def fail(*args, **kwargs):
        raise RuntimeError("not implemented for 'Half'")

    monkeypatch.setattr(torch.nn.Conv2d, "forward", fail)
    with pytest.raises(UserError, match=r"Precision float16 is not available: cpu has no float16 convolution"):
        stress(entry("stress", *overrides, "precisions=[float16]"))


@pytest.fixture
def checkpoint(entry, tmp_path):
    """A checkpoint of DLCTUS at 2x2, as training writes it."""
    from hydra.utils import instantiate
    from omegaconf import OmegaConf

    cfg = entry("stress", "model=dlctus", "task.scale=2")
    model = instantiate(cfg.model)
    metadata = {
        "model": OmegaConf.to_container(cfg.model, resolve=True),
        "task": OmegaConf.to_container(cfg.task, resolve=True),
        "method": "dlctus",
    }
    path = tmp_path / "last.ckpt"
    weights = {f"model.{k}": v for k, v in model.state_dict().items()}
    torch.save({"state_dict": weights, KEY: metadata}, path)
    return path


def test_trained_weights_are_tried_at_their_scale_only(entry, overrides, checkpoint, tmp_path):
    cfg = entry("stress", *overrides, f"checkpoint={checkpoint}", "extremes=[scale]", "precisions=[float32]")
    assert stress(cfg) == 0
    _, table = table_of(tmp_path)
    rows = [dict(zip(table["columns"], row)) for row in table["data"]]
    assert {row["model"] for row in rows} == {"dlctus"}
    tried = [row for row in rows if row["verdict"] == "holds"]
    assert [row["extreme"] for row in tried] == ["scale/2"]
    assert {row["why"] for row in rows if row not in tried} == {"its weights are for scale 2"}


def test_checkpoint_of_another_architecture(entry, overrides, checkpoint):
    with pytest.raises(UserError, match="DLCTUS.*TUS|leave model") as error:
        stress(entry("stress", *overrides, f"checkpoint={checkpoint}", "model=tus"))
    assert "\n" not in str(error.value)


def test_selection_of_extremes():
    full = select_extremes(None, True)
    assert full.extremes == EXTREMES
    assert full.groups == SPECIAL_GROUPS
    quick = select_extremes(None, False)
    assert {e.name for e in full.extremes} - {e.name for e in quick.extremes} == {
        "size/8K target", "size/8K input", "size/8K input at scale 1", "scale/5", "scale/6", "scale/7",
    }  # fmt: skip
    named = select_extremes(["jitter/NaN", "depth", "rollout", "size/8K target"], False)
    assert {e.group for e in named.extremes} == {"jitter", "depth", "size"}
    assert [e.name for e in named.extremes if e.group == "jitter"] == ["jitter/NaN"]
    assert "size/8K target" in {e.name for e in named.extremes}
    assert named.groups == ("rollout",)
    assert set(SPECIAL_GROUPS) < set(GROUPS)


def test_memory_is_estimated_from_shapes(entry):
    from hydra.utils import instantiate

    model = instantiate(entry("stress", "model=jau", "task.scale=4").model)
    # Input and output of 3 channels and positions of 2, in float32, doubled and compared: within a small factor.
    pixels = 400 * 300 * 16
    assert 4 * 3 * pixels * 3 / 1e9 < estimate_gigabytes(model, 400, 300) < 4 * 30 * pixels * 3 / 1e9
    assert estimate_gigabytes(model, 800, 600) == pytest.approx(4 * estimate_gigabytes(model, 400, 300), rel=0.01)
    assert not explain_too_large(model, (4, 3), "cpu")
    assert "GB are free" in explain_too_large(model, (2**15, 2**15), "cpu")


def test_models_of_each_effort(entry):
    quick = select_models(entry("stress"), full=False)
    assert select_models(entry("stress"), full=True) == group_options("model")
    assert {name.split()[0] for name in quick} < set(group_options("model"))
    assert select_models(entry("stress", "models=[jau]"), full=True) == ["jau"]
