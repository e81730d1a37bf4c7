"""``stress.py`` from its configuration to the MLflow run, and what it says to mistakes."""

import json

import pytest
import torch
from mlflow.tracking import MlflowClient

from supersampling.commands.stress import stress
from supersampling.errors import UserError
from supersampling.runs.checkpoint import KEY
from supersampling.stress import precision
from supersampling.stress.cell import COLUMNS
from supersampling.stress.memory import gigabytes, too_large
from supersampling.stress.plan import EXTREMES, GROUPS, OTHERS, choose


@pytest.fixture
def given(tmp_path):
    store = f"tracking_uri=sqlite:///{tmp_path}/mlflow.db"
    return ["threads=1", "device=cpu", "size=[6,5]", f"paths.root={tmp_path}", store]


def table_of(tmp_path):
    client = MlflowClient(f"sqlite:///{tmp_path}/mlflow.db")
    known = client.get_experiment_by_name("supersampling").experiment_id
    (run,) = client.search_runs([known])
    held = json.loads(open(client.download_artifacts(run.info.run_id, "stress.json", str(tmp_path))).read())  # noqa: SIM115
    return run, held


def test_a_table_is_logged_and_printed(entry, given, tmp_path, capsys):
    models = "models=[jau,'tus model/reproject=bilinear']"
    wanted = "extremes=[motion,gate,recovery]"
    assert stress(entry("stress", *given, models, wanted, "precisions=[float32]"))
    run, table = table_of(tmp_path)
    assert table["columns"] == COLUMNS
    rows = [dict(zip(table["columns"], row)) for row in table["data"]]
    assert {row["model"] for row in rows} == {"jau", "tus model/reproject=bilinear"}
    assert {row["extreme"].split("/")[0] for row in rows} == {"motion", "gate", "recovery"}
    assert {row["verdict"] for row in rows} == {"holds"}
    assert not any(row["extreme"].startswith("motion") for row in rows if row["model"] == "jau")  # it reads none
    assert run.data.tags["ss.kind"] == "stress"
    assert run.data.tags["ss.machine"]
    assert run.info.status == "FINISHED"
    assert run.data.metrics["stress/fails"] == 0
    out = capsys.readouterr().out
    assert f"{len(rows)} cells hold, 0 fail, 0 were not tried" in out
    assert "recovery/state NaN" in out


def test_a_failed_verdict_is_shown_and_decides(entry, given, monkeypatch, tmp_path, capsys):
    strict = precision.Precision("float32", 1e-30, 1e-30, "")
    monkeypatch.setitem(precision.PRECISIONS, "float32", strict)
    assert not stress(entry("stress", *given, "models=[jau]", "extremes=[scale]", "precisions=[float32]"))
    out = capsys.readouterr().out
    assert "fails" in out
    assert "above 1e-30" in out
    assert table_of(tmp_path)[0].data.metrics["stress/fails"] > 0


@pytest.mark.parametrize(
    ("overrides", "part"),
    [
        (["extremes=[velocity]"], "extremes holds velocity"),
        (["extremes=[motion/sideways]"], "motion/sideways"),
        (["precisions=[float8]"], "precisions holds float8"),
        (["models=[dlss]"], "models holds dlss"),
        (["effort=huge"], "effort=huge"),
        (["size=[0,5]"], r"size=\[0, 5\]"),
        (["size=[5]"], r"size=\[5\]"),
        (["device=tpu"], "device=tpu"),
        (["run=a", "checkpoint=b"], "both"),
        (["checkpoint=nowhere.ckpt"], "nowhere.ckpt"),
    ],
)
def test_mistakes(entry, given, overrides, part):
    with pytest.raises(UserError, match=part) as caught:
        stress(entry("stress", *given, *overrides))
    assert "\n" not in str(caught.value)


def test_a_precision_that_the_device_lacks(entry, given, monkeypatch):
    def refuse(*args, **kwargs):
        raise RuntimeError("not implemented for 'Half'")

    monkeypatch.setattr(torch.nn.Conv2d, "forward", refuse)
    with pytest.raises(UserError, match=r"precisions=float16 is not possible: cpu has no float16 convolution"):
        stress(entry("stress", *given, "precisions=[float16]"))


@pytest.fixture
def checkpoint(entry, tmp_path):
    """Of DLCTUS at 2x2, as training writes them."""
    from hydra.utils import instantiate
    from omegaconf import OmegaConf

    cfg = entry("stress", "model=dlctus", "task.scale=2")
    model = instantiate(cfg.model)
    said = {
        "model": OmegaConf.to_container(cfg.model, resolve=True),
        "task": OmegaConf.to_container(cfg.task, resolve=True),
        "method": "dlctus",
    }
    path = tmp_path / "last.ckpt"
    weights = {f"model.{k}": v for k, v in model.state_dict().items()}
    torch.save({"state_dict": weights, KEY: said}, path)
    return path


def test_trained_weights_are_tried_at_their_own_scale(entry, given, checkpoint, tmp_path):
    assert stress(entry("stress", *given, f"checkpoint={checkpoint}", "extremes=[scale]", "precisions=[float32]"))
    rows = [dict(zip(*pair)) for pair in [(table_of(tmp_path)[1]["columns"], r) for r in table_of(tmp_path)[1]["data"]]]
    assert {row["model"] for row in rows} == {"dlctus"}
    tried = [row for row in rows if row["verdict"] == "holds"]
    assert [row["extreme"] for row in tried] == ["scale/2"]
    assert {row["why"] for row in rows if row not in tried} == {"its weights are for scale 2"}


def test_a_checkpoint_of_another_architecture(entry, given, checkpoint):
    with pytest.raises(UserError, match="DLCTUS.*TUS|leave model") as caught:
        stress(entry("stress", *given, f"checkpoint={checkpoint}", "model=tus"))
    assert "\n" not in str(caught.value)


def test_the_choice():
    every = choose(None, True)
    assert every.extremes == EXTREMES
    assert every.others == OTHERS
    quick = choose(None, False)
    assert {e.name for e in every.extremes} - {e.name for e in quick.extremes} == {
        "size/8K target", "size/8K input", "size/8K input at scale 1", "scale/5", "scale/6", "scale/7",
    }  # fmt: skip
    some = choose(["jitter/NaN", "depth", "rollout", "size/8K target"], False)
    assert {e.group for e in some.extremes} == {"jitter", "depth", "size"}
    assert [e.name for e in some.extremes if e.group == "jitter"] == ["jitter/NaN"]
    assert "size/8K target" in {e.name for e in some.extremes}
    assert some.others == ("rollout",)
    assert set(OTHERS) < set(GROUPS)


def test_memory_is_counted_from_shapes(entry):
    from hydra.utils import instantiate

    model = instantiate(entry("stress", "model=jau", "task.scale=4").model)
    # In and out, 3 channels; positions, 2; at float32, doubled and held: within a small factor.
    pixels = 400 * 300 * 16
    assert 4 * 3 * pixels * 3 / 1e9 < gigabytes(model, 400, 300) < 4 * 30 * pixels * 3 / 1e9
    assert gigabytes(model, 800, 600) == pytest.approx(4 * gigabytes(model, 400, 300), rel=0.01)
    assert not too_large(model, (4, 3), "cpu")
    assert "GB are free" in too_large(model, (2**15, 2**15), "cpu")
