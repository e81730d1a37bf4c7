"""The command: what it refuses, what it logs, and what finished jobs get."""

import math
import re
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from omegaconf import OmegaConf, open_dict

from supersampling.commands import benchmark as benchmark
from supersampling.commands.benchmark import check_settings, timing_of
from supersampling.errors import UserError
from supersampling.profiling.ceiling import Ceiling
from supersampling.profiling.interleave import Outcome
from supersampling.profiling.traffic import Work
from supersampling.profiling.worker import Case
from supersampling.runs.experiment import open_experiment
from supersampling.runs.subjects import subjects_by_name, subjects_of_run
from supersampling.runs.timing import read
from supersampling.runs.timing_log import log_times_of_jobs

ROOT = Path(__file__).resolve().parents[2]
BICUBIC = {"_target_": "supersampling.models.bicubic.Bicubic", "scale": 4}
CASE = Case("bicubic", BICUBIC, 4, "thesis", (1920, 1080), "eager", {}, "float32", "cpu", 1)


@pytest.fixture
def inside():
    """As within the entry point: ``inside("methods=[tus]")`` is its configuration, and Hydra composes more."""
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):

        def make(*overrides):
            cfg = compose("benchmark", list(overrides), return_hydra_config=True)
            HydraConfig.instance().set_config(cfg)
            with open_dict(cfg):
                del cfg["hydra"]
            return cfg

        yield make
    HydraConfig.instance().cfg = None


@pytest.fixture(scope="module")
def experiment(tmp_path_factory):
    folder = tmp_path_factory.mktemp("store")
    return open_experiment(f"sqlite:///{folder}/mlflow.db", "supersampling", folder / "artifacts")


def job(experiment, model, scale, kind="job", status="FINISHED"):
    run_id = experiment.start("a job", {"ss.kind": kind, "ss.method": "bicubic"}, None)
    text = OmegaConf.to_yaml({"model": model, "task": {"scale": scale, "jitter": "none"}})
    experiment.client.log_text(run_id, text, "config.yaml")
    experiment.finish(run_id, status)
    return run_id


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("rounds=0", "rounds=0 is not possible"),
        ("frames=1.5", "frames=1.5 is not possible"),
        ("depth=-1", "depth=-1 is not possible"),
        ("seconds=0", "seconds=0 is not possible"),
        ("precisions=[int4]", "precisions=int4 is not known: use float32, bfloat16, float16"),
        ("precisions=[]", "precisions=[] leaves nothing"),
        ("sizes=[[1920]]", "sizes=[1920] is not possible"),
        ("sizes=[1920,1080]", "sizes=1920 is not possible"),
        ("sizes=[[1920,0]]", "sizes=[1920, 0] is not possible"),
        ("sizes=[[1921,1080]]", "sizes=[1921, 1080] is no multiple of the scale 4: use [1920,1080]"),
        ("scales=[4,7]", "is no multiple of the scale 7"),
        ("scales=[0]", "scales=0 is not possible"),
    ],
)
def test_settings_that_cannot_be(inside, override, said):
    with pytest.raises(UserError, match=re.escape(said)):
        check_settings(inside(override))


def test_a_run_and_methods_exclude_each_other(inside):
    with pytest.raises(UserError, match="exclude each other"):
        check_settings(inside("run=1234", "methods=[tus]"))


def test_methods_by_name(inside):
    inside("model=nsrr", "model.previous=2", "model/reweight=none", "task.jitter=none")
    tus, nsrr = subjects_by_name(["tus", "nsrr"], [2])
    assert (tus.name, nsrr.name, tus.scale, tus.model["scale"], tus.jitter) == ("tus", "nsrr", 2, 2, "none")
    assert nsrr.model["previous"] == 4  # as published: the command line's switches are those of its model
    (own,) = subjects_by_name([], [4])
    assert own.name == "nsrr reweight=none"
    assert own.model["previous"] == 2
    assert own.architecture != nsrr.architecture
    with pytest.raises(UserError, match=r"methods=dlss is not known: use bicubic, dlctus"):
        subjects_by_name(["dlss"], [4])


def test_an_unknown_run(experiment):
    with pytest.raises(UserError, match="There is no run 123"):
        subjects_of_run(experiment, "123")


def test_finished_jobs_get_their_time(experiment, capsys):
    same, other = job(experiment, BICUBIC, 4), job(experiment, {**BICUBIC, "scale": 2}, 2)
    unfinished, sanity = (
        job(experiment, BICUBIC, 4, status="FAILED"),
        job(experiment, BICUBIC, 4, kind="sanity"),
    )
    slow = Outcome(CASE, [0.004, 0.002, 0.003], 5e6, ceiling=Ceiling(1e9, 1e9))
    larger = Outcome(Case(**{**vars(CASE), "size": (3840, 2160)}), [9.0], 5e6, ceiling=Ceiling(1e9, 1e9))
    half = Outcome(Case(**{**vars(CASE), "precision": "bfloat16"}), [8.0], 5e6, ceiling=Ceiling(1e9, 1e9))
    graph = Outcome(Case(**{**vars(CASE), "name": "onnxruntime"}), why="It cannot.")
    timings = [timing_of(o, Work(0, 6e6, 1e6)) for o in (slow, larger, half, graph)]
    assert log_times_of_jobs(experiment, timings) == 1
    found = {r: experiment.client.get_run(r).data for r in (same, other, unfinished, sanity)}
    times = {r: {k: v for k, v in d.metrics.items() if k.startswith("time/")} for r, d in found.items()}
    assert times == {same: {"time/eager/ms": 3.0}, other: {}, unfinished: {}, sanity: {}}
    assert found[same].tags["ss.timed_on"] == timings[0].machine
    assert "ss.timed_on" not in found[other].tags
    assert {s.scale for s in subjects_of_run(experiment, "all")} == {2, 4}
    (one,) = subjects_of_run(experiment, other)
    assert (one.name, one.model, one.scale, one.jitter) == ("bicubic", {**BICUBIC, "scale": 2}, 2, "none")


def test_a_timing_s_shares_of_the_ceilings():
    """6e6 MACs in 3 ms are 2e9 a second, of 8e9; 1.5e6 bytes are 5e8, of 1e9."""
    timing = timing_of(Outcome(CASE, [0.003, 0.003], 5e6, ceiling=Ceiling(8e9, 1e9)), Work(7, 6e6, 1.5e6))
    assert (timing.of_product, timing.of_copy) == pytest.approx((0.25, 0.5))
    assert (timing.ms, timing.frames, timing.peak_mb, timing.gmac, timing.gbytes) == (
        3.0,
        2,
        5.0,
        0.006,
        0.0015,
    )
    none = timing_of(Outcome(CASE, why="It cannot."), Work(7, 6e6, 1.5e6))
    assert (none.runs, none.why, math.isnan(none.of_copy)) == (False, "It cannot.", True)


def test_a_scale_of_a_run_that_the_size_does_not_fit(inside):
    case = Case(**{**vars(CASE), "scale": 7})
    assert "no multiple of its scale, 7" in benchmark._why(case, None, None)


@pytest.mark.slow
def test_the_command(tmp_path):
    """Two methods and two backends, one of which is not there; the tables are in MLflow, and the parts add up."""
    given = [
        "methods=[bicubic,dlctus]",
        "sizes=[[32,32]]",
        "rounds=2",
        "frames=2",
        "threads=1",
        "depth=2",
        "device=cpu",
    ]
    store = [f"paths.root={tmp_path}", f"tracking_uri=sqlite:///{tmp_path}/mlflow.db"]
    command = [sys.executable, "benchmark.py", *given, "backends=[eager,tensorrt]", *store]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert "TensorRT needs an NVIDIA GPU." in done.stdout
    (path,) = tmp_path.glob("mlartifacts/*/artifacts/timings.json")
    timings = read(path)
    assert [(t.method, t.backend, t.runs, t.frames) for t in timings] == [
        ("bicubic", "eager", True, 4),
        ("bicubic", "tensorrt", False, 0),
        ("dlctus", "eager", True, 4),
        ("dlctus", "tensorrt", False, 0),
    ]
    dlctus = timings[2]
    assert (dlctus.parameters, dlctus.threads, dlctus.width, dlctus.height) == (78_112, 1, 32, 32)
    assert dlctus.low <= dlctus.ms <= dlctus.high
    stages = pd.read_json(path.with_name("stages.json"), orient="split")
    of_one = stages[stages.method == "dlctus"].set_index("part").ms
    assert of_one[[n for n in of_one.index if "." not in n and n != "total"]].sum() == pytest.approx(of_one.total)


def test_an_unknown_backend(tmp_path):
    command = [sys.executable, "benchmark.py", "backends=[eager,cudnn]", f"paths.root={tmp_path}"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode != 0
    assert "Could not load 'backends/cudnn'" in done.stderr
    assert "Traceback" not in done.stderr
