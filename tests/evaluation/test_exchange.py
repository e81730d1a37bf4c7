"""Stages exchanged after a training, and scenes that it has not seen: by ``evaluate.py``, and in a report."""

from dataclasses import replace
from pathlib import Path

import pytest
import torch
from hydra.utils import instantiate

from supersampling.commands.evaluate import evaluate
from supersampling.commands.train import train
from supersampling.errors import UserError
from supersampling.evaluation import result
from supersampling.reporting.papers.claims import choose_claim
from supersampling.reporting.papers.published import load_paper
from supersampling.reporting.papers.tables import choose_table
from supersampling.reporting.settings import choose
from supersampling.runs.relation import relation
from supersampling.runs.store import Store

PUBLISHED = Path(__file__).resolve().parents[2] / "reports" / "published"
QUIET = ["threads=1", "workers=0", "metrics=fast"]
TRAINING = ["budget=smoke", "budget.epochs=1", "trainer.enable_progress_bar=false", "baselines=[]", "loss=l1"]


@pytest.fixture
def stored(tmp_path):
    """Return the finished runs of the store, by name."""

    def read():
        store = Store(f"sqlite:///{tmp_path}/mlflow.db", tmp_path / "copies")
        return {run.name: run for run in store.experiment("supersampling", ("job", "evaluation")).runs}

    return read


@pytest.fixture
def where(tmp_path):
    return [f"paths.root={tmp_path}", f"tracking_uri=sqlite:///{tmp_path}/mlflow.db"]


@pytest.fixture
def trained(entry, where, make_file, tmp_path, stored):
    """A training on analytic clips, with another stage than the published one: the words of its data, and its id."""
    files = [f"data.{split}=[{make_file(tmp_path, split, frames=6)}]" for split in ("train", "val", "test")]
    data = ["data=files", "scene=atrium", *files, *where]
    train(entry("train", *data, *QUIET, *TRAINING, "model/confine=clamp"))
    (run,) = stored().values()
    return [*data, "threads=1", "metrics=fast", f"run={run.id}"]


def by_hand(cfg, folder, stage):
    """The mean PSNR of the trained weights in a model that is composed with another stage from the beginning."""
    (checkpoint,) = (folder / "outputs" / "checkpoints").glob("*/last.ckpt")
    weights = torch.load(checkpoint, weights_only=True)["state_dict"]
    model = instantiate(cfg.model)
    assert type(model.reproject).__name__.lower().startswith(stage)
    model.load_state_dict({name.removeprefix("model."): value for name, value in weights.items()})
    files = instantiate(cfg.data).files(["test"], model.requires | {"target"})["test"]
    clips = result.evaluate(model, instantiate(cfg.metrics), instantiate(cfg.protocol), files).clips
    return float(clips["psnr"].mean())


def test_the_trained_weights_are_scored_with_another_stage_and_on_an_unseen_scene(entry, where, stored, tmp_path):
    base = ["data=smoke", *where]
    train(entry("train", *base, *QUIET, *TRAINING, "scene=atrium", "data.camera=stops"))
    (training,) = stored().values()
    words = [*base, "threads=1", "metrics=fast", f"run={training.id}"]
    evaluate(entry("evaluate", *words, "scene=atrium", "data.camera=stops", "model/reproject=bilinear"))
    cfg = entry("train", *base, *QUIET, *TRAINING, "scene=atrium", "data.camera=stops", "model/reproject=bilinear")
    exchanged = stored()["evaluate dlctus, tested with reproject=bilinear"]
    assert exchanged.metrics["test/psnr"] == by_hand(cfg, tmp_path, "bilinear")
    assert exchanged.metrics["test/psnr"] != training.metrics["test/psnr"]
    assert exchanged.dataset == training.dataset

    evaluate(entry("evaluate", *words, "scene=market"))
    unseen = stored()["evaluate dlctus"]
    values = {name: unseen.parameter(name) for name in ("data.scenes", "trained.data.scenes", "data.camera")}
    assert values == {"data.scenes": "market", "trained.data.scenes": "atrium", "data.camera": "walk"}
    assert unseen.parameter("trained.data.camera") == "stops"
    assert (unseen.parameter("test.scenes"), exchanged.parameter("test.scenes")) == ("unseen", "same")

    thesis, nsrd = (load_paper(PUBLISHED / f"{name}.yaml") for name in ("dlctus", "nsrd"))
    runs = [training, exchanged, unseen]
    claim = next(claim for claim in thesis.claims if claim.id == "dlctus-6")
    chosen = choose_claim(claim, choose(runs, None, None)).runs
    assert {label: [run.id for run in members] for label, members in chosen.items()} == {
        "a": [training.id],
        "b": [exchanged.id],
    }
    # The same evaluations, were they NSRD's: only the unseen scene is in the table and the claim on generalisation.
    claim = next(claim for claim in nsrd.claims if claim.id == "nsrd-16")
    table = next(table for table in nsrd.tables if table.number == "4")
    runs = [replace(run, params={**run.params, **claim.a, "model.demodulate": "lighting"}) for run in runs]
    assert [run.id for run in choose_claim(claim, choose(runs, None, None)).runs["a"]] == [unseen.id]
    assert choose_claim(claim, choose(runs[:2], None, None)).runs["a"] == []
    cells = choose_table(table, choose(runs, None, None)).cells
    assert {place: [run.id for run in members] for place, members in cells.items()} == {(0, 3): [unseen.id]}
    assert choose_table(table, choose(runs[:2], None, None)).cells == {}


def test_an_evaluation_has_the_parameters_of_what_was_scored_and_of_what_was_trained(entry, trained, stored, tmp_path):
    before = dict(stored())
    evaluate(entry("evaluate", *trained, "model/reproject=bicubic5", "protocol.warm_up=2", "task.mip_bias=sharp"))
    (name,) = stored().keys() - before.keys()
    assert name == "evaluate dlctus confine=clamp, tested with reproject=bicubic5"
    run, (training,) = stored()[name], before.values()
    assert (run.kind, run.params["trained.run"], run.params["protocol.warm_up"]) == ("evaluation", training.id, "2")
    assert run.params["model.reproject"] == "bicubic5"
    assert {key: value for key, value in run.params.items() if key.startswith("trained.")} == {
        "trained.run": training.id,
        "trained.model.reproject": "bicubic9",
        "trained.task.mip_bias": "matched",
    }
    assert {key: run.params[key] for key in ("model.confine", "budget", "loss", "seed", "test.scenes")} == {
        "model.confine": "clamp", "budget": "smoke", "loss": "l1", "seed": "0", "test.scenes": "same",
    }  # fmt: skip


MISFITS = {
    "model/accumulate=none": "model/accumulate=none does not fit the weights of Run .*: network.down.weight is "
    "32x8x4x4 there and 32x7x4x4 in the exchanged model: train that model, or exchange a stage",
    "model=tus": "holds model=dlctus, but the command line has model=tus",
    "+model/rectify=none": "holds model=dlctus, which has no .*model/rectify: exchange one of accumulate, confine",
}


def test_a_stage_as_trained_is_no_exchange_and_what_does_not_fit_is_one_sentence(entry, trained, stored):
    before = set(stored())
    for word, message in MISFITS.items():
        with pytest.raises(UserError, match=message):
            evaluate(entry("evaluate", *trained, word))
    assert set(stored()) == before
    evaluate(entry("evaluate", *trained, "model=dlctus", "model/reproject=bicubic9"))
    (name,) = stored().keys() - before
    assert name == "evaluate dlctus confine=clamp"
    assert not any(key.startswith("trained.model") for key in stored()[name].params)


@pytest.mark.parametrize(
    ("scored", "trained", "name"),
    [("ab", "ba", "same"), ("a", "ab", "subset"), ("c", "ab", "unseen"), ("ac", "ab", "partly"), ("a", "", "unknown")],
)
def test_scenes_of_test_and_training(scored, trained, name):
    assert relation(set(scored), set(trained)) == name
