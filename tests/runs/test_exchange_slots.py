"""Stages of every published model that can be exchanged after the training, and those that change its weights."""

import pytest
import torch
from hydra.utils import instantiate

from supersampling.errors import UserError
from supersampling.runs.checkpoint import KEY, metadata
from supersampling.runs.method import method_of


@pytest.fixture
def stored(entry, tmp_path):
    """Return a function that writes a checkpoint of random weights."""

    def write(*words):
        cfg = entry("train", "scene=atrium", *words)
        weights = {f"model.{name}": value for name, value in instantiate(cfg.model).state_dict().items()}
        path = tmp_path / "random.ckpt"
        torch.save({"state_dict": weights, KEY: metadata(cfg, {"ss.method": "m"}, {"model": "m"}, "r")}, path)
        return path

    return write


@pytest.mark.parametrize(
    ("model", "stage"),
    [
        ("dlctus", "reproject=bilinear"),
        ("dlctus", "dilate=closest"),
        ("nsrr", "upsample=bilinear"),
        ("enss_m", "motion_grid=bilinear"),
    ],
)
def test_the_other_stages_remain_as_trained(model, stage, entry, stored):
    slot, _, option = stage.partition("=")
    confined = [f"model={model}", *(["model/confine=clamp"] if model == "dlctus" else [])]
    path = stored(*confined)
    method = method_of(entry("evaluate", f"checkpoint={path}", f"model={model}", f"model/{stage}"), exchange=True)
    assert method.name == f"m, tested with {stage}"
    assert method.parameters[f"model.{slot}"] == option
    by_hand = instantiate(entry("train", "scene=atrium", *confined, f"model/{stage}").model)
    by_hand.load_state_dict({n.removeprefix("model."): v for n, v in torch.load(path)["state_dict"].items()})
    assert repr(method.model) == repr(by_hand)
    assert method.config["option"] == f"model={model.partition('_')[0]}"


@pytest.mark.parametrize("stage", ["motion_mask=none", "recur=none"])
def test_a_stage_with_other_weights_is_refused(stage, entry, stored):
    path = stored("model=nsrd", "model/demodulate=log_lighting")
    with pytest.raises(UserError, match=f"model/{stage} does not fit the weights of .*random.ckpt: .* is .* there and"):
        method_of(entry("evaluate", f"checkpoint={path}", "model=nsrd", f"model/{stage}"), exchange=True)
