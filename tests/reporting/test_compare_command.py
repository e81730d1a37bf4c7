"""``compare.py`` from its command line to what it prints, on a small store."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from mlflow import MlflowClient
from mlflow.entities import Param
from omegaconf import OmegaConf

from supersampling.commands.compare import compare
from supersampling.commands.typed import as_typed
from supersampling.errors import UserError
from supersampling.metrics.scores import FILE, Scores, write_scores

ROOT = Path(__file__).resolve().parents[2]
TASK = {"task.scale": "4", "task.mip_bias": "matched", "data": "laptop", "data.scenes": "atrium"}
TRAINED = {**TASK, "model": "dlctus", "loss": "spatiotemporal", "loss.theta": "0.1", "budget": "laptop"}
Command = Callable[..., str]


def clips(gain: float, scatter: np.random.Generator) -> pd.DataFrame:
    places = [(f"scene{s}", c) for s in range(9) for c in range(4)]
    hard = np.random.default_rng(0).normal(30, 5, 36)
    table = pd.DataFrame(places, columns=["scene", "clip"])
    return table.assign(psnr=hard + gain + scatter.normal(0, 0.1, 36), noise=scatter.normal(0, 1, 36))


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, dict[str, str]]:
    """A tracking address, and the ids of its runs: three seeds of ``dlctus``, ``tus``, an evaluation, a failed job."""
    folder, rng = tmp_path_factory.mktemp("store"), np.random.default_rng(1)
    uri = f"sqlite:///{folder}/mlflow.db"
    client = MlflowClient(uri)
    experiment = client.create_experiment("supersampling", (folder / "artifacts").as_uri())
    ids = {}
    for name, gain in (("s0", 0.9), ("s1", 1.0), ("s2", 1.1), ("tus", 0.0), ("evaluation", 0.5), ("failed", 9.0)):
        params = TRAINED | {"seed": name[1]} if name[0] == "s" else TASK | {"model": "tus"}
        tags = {"ss.kind": "job", "ss.identity": name, "ss.dataset": "4e12aaaa", "ss.method": params["model"]}
        if name == "evaluation":  # its parameters are those of the training, on other data
            tags["ss.kind"] = "evaluation"
            del tags["ss.identity"]
            params["data"] = "smoke"
        ids[name] = client.create_run(experiment, tags=tags).info.run_id
        client.log_batch(ids[name], params=[Param(key, value) for key, value in params.items()])
        scored = clips(gain, rng)
        if name == "s1":  # as runs of earlier versions are
            client.log_table(ids[name], scored, "clips.json")
        else:
            write_scores(folder / FILE, Scores.with_scene_means(scored.assign(frame=0), scored))
            client.log_artifact(ids[name], str(folder / FILE))
        client.set_terminated(ids[name], "FAILED" if name == "failed" else "FINISHED")
    return uri, ids


@pytest.fixture
def command(store: tuple[str, dict[str, str]], capsys: pytest.CaptureFixture[str]) -> Iterator[Command]:
    """What ``python compare.py`` prints with the given words behind it."""

    def run(*words: str) -> str:
        GlobalHydra.instance().clear()
        with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):
            overrides = [*words, f"tracking_uri={store[0]}"]
            cfg = compose("compare", overrides, return_hydra_config=True)
        HydraConfig.instance().set_config(cfg)
        compare(cfg)
        return capsys.readouterr().out

    yield run
    HydraConfig.instance().cfg = None


def test_seeds_are_one_row(command, store):
    printed = command("a=dlctus", "b=tus")
    ids = store[1]
    assert f"a: dlctus theta=0.1, seeds 0, 1, 2, runs {' '.join(ids[f's{i}'][:8] for i in range(3))}" in printed
    assert f"b: tus, not trained, run {ids['tus'][:8]}" in printed
    rows = {line.split()[0]: line for line in printed.splitlines() if line}
    assert rows["psnr"].count("±") == 2
    assert rows["psnr"].endswith("dlctus is better")
    assert rows["noise"].endswith("unresolved")


def test_metrics_may_be_one_or_a_list(command):
    for setting in ("metric=psnr", "metric=[psnr]"):
        printed = command("a=dlctus", "b=tus", setting)
        assert "noise" not in printed
        assert "of many metrics" not in printed


def test_an_evaluation_stands_beside_a_job(command, store):
    printed = command(f"a='{store[1]['evaluation'][:12]}'", "b=tus")
    assert (
        f"a: tus, not trained, evaluation {store[1]['evaluation'][:8]}; 4×4, matched, data=unknown (4e12aaaa)"
        in printed
    )
    assert "a is better" in printed


@pytest.mark.parametrize("start", ["95e41234", "3e7", "12345678", "0e12", "1_000"])
def test_beginnings_of_ids_that_look_like_numbers_stay_as_typed(command, start):
    with pytest.raises(
        UserError, match=f"No finished run or method is called a={start}: choose one of dlctus, tus, or"
    ):
        command(f"a={start}", "b=tus")


def test_so_do_those_of_fingerprints(command):
    assert "dlctus is better" in command("a=dlctus", "b=tus", "dataset=4e12")
    with pytest.raises(
        UserError, match="No data set of the experiment begins with dataset=5e12: choose one of 4e12aaaa"
    ):
        command("a=dlctus", "b=tus", "dataset=5e12")


def test_number_from_elsewhere_raises():
    assert as_typed(OmegaConf.create({"a": "3e7"}), "a") == "3e7"
    assert as_typed(OmegaConf.create({"a": None}), "a") is None
    with pytest.raises(UserError, match="a=30000000.0 was read as a number"):
        as_typed(OmegaConf.create({"a": 3e7}), "a")


def test_both_sides_are_required(command):
    with pytest.raises(UserError, match="Missing b: use compare.py a=RUN_OR_METHOD b=RUN_OR_METHOD"):
        command("a=dlctus")
