"""A checkpoint needs nothing beside itself, says what contradicts it, and cannot have code called."""

import pytest
import torch
from hydra.core.hydra_config import HydraConfig
from hydra.utils import instantiate

from supersampling.errors import UserError
from supersampling.models.count import random_frame
from supersampling.runs.checkpoint import KEY, build, metadata, read_metadata
from supersampling.runs.experiment import open_experiment
from supersampling.runs.method import method_of
from supersampling.runs.naming import method_name
from supersampling.training.fit import fit


@pytest.fixture
def configure(entry):
    """Composes as a command line would: ``configure("evaluate", "checkpoint=...")``."""
    return lambda name, *overrides: entry(name, "scene=atrium", *overrides)


@pytest.fixture
def saved(configure, tmp_path):
    """A checkpoint file of a configured model with random weights, and the model."""

    def make(*overrides, carry=True):
        cfg = configure("train", *overrides)
        torch.manual_seed(0)
        model = instantiate(cfg.model)
        weights = {f"model.{k}": v for k, v in model.state_dict().items()}
        inside = {KEY: metadata(cfg, {"ss.method": "mine"}, {"seed": "7"}, "r1")} if carry else {}
        path = tmp_path / "some.ckpt"
        torch.save({"state_dict": weights, **inside}, path)
        return path, model

    return make


def same(a, b):
    frame = random_frame(a, 6, 5, "cpu")
    with torch.no_grad():
        return torch.equal(a.eval()(frame, None)[0], b.eval()(frame, None)[0])


def test_what_a_training_writes_is_all_that_it_takes(configure, make_file, tmp_path):
    files = {split: [make_file(tmp_path, split)] for split in ("train", "val", "test")}
    cfg = configure(
        "train", "budget=smoke", "budget.epochs=1", "workers=0", "trainer.enable_progress_bar=false",
        "model/accumulate=none", "task.mip_bias=sharp",
    )  # fmt: skip
    store = open_experiment(f"sqlite:///{tmp_path}/mlflow.db", "test", tmp_path / "artifacts")
    name = method_name(dict(HydraConfig.get().runtime.choices))
    run_id = store.start("a", {"ss.method": name, "ss.identity": "abc"}, None)
    store.log_params(run_id, {"seed": 0})
    trained = fit(cfg, files, tmp_path / "a", store, run_id)
    path = tmp_path / "a" / "last.ckpt"
    assert KEY in torch.load(path, weights_only=True)

    cfg = configure("evaluate", f"checkpoint={path}")
    method = method_of(cfg)
    assert same(trained, method.model)
    assert (method.name, method.parameters) == ("dlctus model/accumulate=none".replace("model/", ""), {"seed": "0"})
    assert (method.origin["run"], method.origin["identity"]) == (run_id, "abc")
    assert cfg.task.mip_bias == "sharp"


def test_the_scale_and_the_data_follow_the_checkpoint(saved, configure):
    path, model = saved("task.scale=2", "task.jitter=halton8")
    cfg = configure("evaluate", f"checkpoint={path}")
    method = method_of(cfg)
    assert method.model.scale == cfg.task.scale == cfg.data.scale == 2
    assert cfg.data.jitter == "halton8"
    assert same(model, method.model)


def test_what_the_command_line_may_still_say(saved, configure):
    path, model = saved("task.scale=2", "model/dilate=closest")
    cfg = configure("evaluate", f"checkpoint={path}", "task.mip_bias=sharp", "task.scale=2")
    assert same(model, method_of(cfg).model)
    assert cfg.task.mip_bias == "sharp"
    agreeing = configure("evaluate", f"checkpoint={path}", "model=dlctus", "model/dilate=closest")
    assert same(model, method_of(agreeing).model)


@pytest.mark.parametrize(
    ("override", "part"),
    [
        ("task.scale=3", "trained for scale 2, but task.scale=3"),
        ("task=qrisp", "trained for scale 2, but task.scale=4"),
        ("data=qrisp", "trained for scale 2, but task.scale=4"),
        ("model=tus", "holds model=dlctus, but the command line has model=tus"),
        ("model/accumulate=none", "model/accumulate=buffer, but the command line has model/accumulate=none"),
        ("model.reproject.a=-0.5", "model.reproject.a=-0.75, but the command line has model.reproject.a=-0.5"),
        ("model.scale=4", "model.scale=2, but the command line has model.scale=4"),
    ],
)  # fmt: skip
def test_what_contradicts_it(override, part, saved, configure):
    path, _ = saved("task.scale=2")
    with pytest.raises(UserError, match=part):
        method_of(configure("evaluate", f"checkpoint={path}", override))


def test_older_checkpoints_need_their_model(saved, configure):
    path, model = saved("model/accumulate=none", carry=False)
    assert read_metadata(path) is None
    method = method_of(configure("evaluate", f"checkpoint={path}", "model/accumulate=none"))
    assert same(model, method.model)
    assert method.name == "dlctus accumulate=none"
    with pytest.raises(UserError, match="set model="):
        method_of(configure("evaluate", f"checkpoint={path}"))


def test_files_that_are_none(configure, tmp_path):
    with pytest.raises(UserError, match="There is no checkpoint"):
        method_of(configure("evaluate", f"checkpoint={tmp_path}/none.ckpt"))
    (tmp_path / "text.ckpt").write_text("no checkpoint")
    with pytest.raises(UserError, match="is not a checkpoint"):
        method_of(configure("evaluate", f"checkpoint={tmp_path}/text.ckpt"))
    torch.save({"state_dict": {}, KEY: {"model": "x"}}, tmp_path / "broken.ckpt")
    with pytest.raises(UserError, match="broken"):
        read_metadata(tmp_path / "broken.ckpt")


@pytest.mark.parametrize(
    "target",
    [
        "builtins.open",
        "os.system",
        "supersampling.runs.experiment.platform.os.system",  # reached through our module
        "supersampling.models.dlctus.torch.hub.load",
        "supersampling.models.dlctus.nn.Conv2d",
        "supersampling.models.dlctus.check_scale",  # a function
        "supersampling.losses.perceptual.Perceptual",  # neither model nor stage
        "supersampling.models.",
        "hydra.utils.get_method",
        "backends=native",
        "optimizer=adam",
        ["a"],
    ],
)
@pytest.mark.parametrize("where", ["top", "stage", "list"])
@pytest.mark.parametrize("key", ["_target_", "option"])
def test_nothing_but_models_and_stages_is_called(key, target, where, saved, configure, tmp_path):
    path, _ = saved()
    file = torch.load(path, weights_only=True)
    made = tmp_path / "made"
    bad = {key: target, "_args_": [str(made), "w"]}
    model = file[KEY]["model"]
    file[KEY]["model"] = {
        "top": bad, "stage": {**model, "confine": bad}, "list": {**model, "confine": [{"inside": [bad]}]},
    }[where]  # fmt: skip
    torch.save(file, path)
    with pytest.raises(UserError) as caught:
        method_of(configure("evaluate", f"checkpoint={path}"))
    assert str(target) in str(caught.value)
    assert not made.exists()


def test_nothing_is_interpolated():
    with pytest.raises(UserError, match="interpolation"):
        build({"_target_": "supersampling.models.jau.JAU", "scale": "${oc.env:HOME}"}, "f")


def test_a_model_of_another_version_says_so():
    with pytest.raises(UserError, match="use the version that wrote it"):
        build({"_target_": "supersampling.models.jau.JAU", "scale": 2, "gone": 1}, "f")
    with pytest.raises(UserError, match="describes a Zeros, not a method"):
        build({"_target_": "supersampling.stages.pad.Zeros"}, "f")
