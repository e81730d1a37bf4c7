"""The command ``benchmark``: errors, logged tables, and the times of finished jobs."""

import math
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from omegaconf import OmegaConf, open_dict

from supersampling.commands import benchmark
from supersampling.commands.benchmark import check_settings, timing_of
from supersampling.errors import UserError
from supersampling.profiling.ceiling import Ceiling
from supersampling.profiling.interleave import Outcome
from supersampling.profiling.traffic import Workload
from supersampling.profiling.worker import Case
from supersampling.runs.experiment import open_experiment
from supersampling.runs.measurements import read_measurements
from supersampling.runs.store import Store
from supersampling.runs.subjects import subjects_by_name, subjects_of_run
from supersampling.runs.timing import read
from supersampling.runs.timing_log import log_times_of_jobs

ROOT = Path(__file__).resolve().parents[2]
BICUBIC = {"_target_": "supersampling.models.bicubic.Bicubic", "scale": 4}
CASE = Case(
    method="bicubic",
    model=BICUBIC,
    scale=4,
    jitter="thesis",
    size=(1920, 1080),
    backend="eager",
    backend_config={},
    precision="float32",
    device="cpu",
    threads=1,
)


@pytest.fixture
def inside():
    """Return a function: ``inside("methods=[tus]")`` is the configuration inside the entry point, with Hydra set up."""
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):

        def configure(*overrides):
            cfg = compose("benchmark", list(overrides), return_hydra_config=True)
            HydraConfig.instance().set_config(cfg)
            with open_dict(cfg):
                del cfg["hydra"]
            return cfg

        yield configure
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
    ("override", "message"),
    [
        ("rounds=0", "Invalid rounds=0:"),
        ("frames=1.5", "Invalid frames=1.5:"),
        ("depth=-1", "Invalid depth=-1:"),
        ("seconds=0", "Invalid seconds=0:"),
        ("precisions=[int4]", "Unknown precision int4 in precisions: use float32, bfloat16, float16"),
        ("precisions=[]", "Invalid precisions=[], which leaves nothing to time"),
        ("sizes=[[1920]]", "Invalid size [1920] in sizes"),
        ("sizes=[1920,1080]", "Invalid size 1920 in sizes"),
        ("sizes=[[1920,0]]", "Invalid size [1920, 0] in sizes"),
        ("sizes=[[1921,1080]]", "Invalid size [1921, 1080] in sizes, no multiple of the scale 4: use [1920,1080]"),
        ("scales=[4,7]", "no multiple of the scale 7"),
        ("scales=[0]", "Invalid scale 0 in scales"),
    ],
)
def test_invalid_settings(inside, override, message):
    with pytest.raises(UserError, match=re.escape(message)):
        check_settings(inside(override))


def test_run_excludes_methods(inside):
    with pytest.raises(UserError, match="exclude each other"):
        check_settings(inside("run=1234", "methods=[tus]"))


def test_methods_by_name(inside):
    inside("model=nsrr", "model.previous=2", "model/reweight=none", "task.jitter=none")
    tus, nsrr = subjects_by_name(["tus", "nsrr"], [2])
    assert (tus.name, nsrr.name, tus.scale, tus.model["scale"], tus.jitter) == ("tus", "nsrr", 2, 2, "none")
    assert nsrr.model["previous"] == 4  # as published: switches of the command line apply to its model only
    (composed,) = subjects_by_name([], [4])
    assert composed.name == "nsrr reweight=none"
    assert composed.model["previous"] == 2
    assert composed.architecture != nsrr.architecture
    with pytest.raises(UserError, match=r"Unknown method dlss in methods: use bicubic, bilinear"):
        subjects_by_name(["dlss"], [4])


def test_methods_with_switches(inside):
    inside("model=dlctus", "model/reproject=bicubic5")
    names = ["nsrr previous=2 reweight=none", "nsrr previous=0", "dlctus reproject=bilinear", "dlctus"]
    both, none, bilinear, published = subjects_by_name(names, [4])
    assert (both.name, both.model["previous"], none.model["previous"]) == ("nsrr previous=2 reweight=none", 2, 0)
    parameters = {"model": "nsrr", "model.previous": "2", "model.reweight": "none", "task.scale": "4"}
    assert both.parameters.items() >= parameters.items()
    assert none.parameters["model.reweight"] == "learned"
    assert [s.parameters["model.reproject"] for s in (bilinear, published)] == ["bilinear", "bicubic9"]
    assert len({s.architecture for s in (both, none, bilinear, published)}) == 4
    with pytest.raises(UserError, match="Invalid switch fast of nsrr in methods: use slot=option or setting=value"):
        subjects_by_name(["nsrr fast"], [4])
    with pytest.raises(UserError, match=r"model\.frames=2"):
        subjects_by_name(["nsrr frames=2"], [4])


def test_unknown_run(experiment):
    with pytest.raises(UserError, match="There is no run 123"):
        subjects_of_run(experiment, "123")


def test_times_of_finished_jobs(experiment, capsys):
    same, smaller = job(experiment, BICUBIC, 4), job(experiment, {**BICUBIC, "scale": 2}, 2)
    unfinished = job(experiment, BICUBIC, 4, status="FAILED")
    sanity = job(experiment, BICUBIC, 4, kind="sanity")
    measured = {"peak": 5e6, "ceiling": Ceiling(1e9, 1e9)}
    outcomes = [
        Outcome(case=CASE, seconds=[0.004, 0.002, 0.003], **measured),
        Outcome(case=replace(CASE, size=(3840, 2160)), seconds=[9.0], **measured),
        Outcome(case=replace(CASE, precision="bfloat16"), seconds=[8.0], **measured),
        Outcome(case=replace(CASE, backend="onnxruntime"), reason="It cannot."),
    ]
    timings = [timing_of(outcome, Workload(0, 6e6, 1e6)) for outcome in outcomes]
    assert log_times_of_jobs(experiment, timings) == 1
    jobs = {r: experiment.client.get_run(r).data for r in (same, smaller, unfinished, sanity)}
    times = {r: {k: v for k, v in d.metrics.items() if k.startswith("time/")} for r, d in jobs.items()}
    assert times == {same: {"time/eager/ms": 3.0}, smaller: {}, unfinished: {}, sanity: {}}
    assert jobs[same].tags["ss.timed_on"] == timings[0].machine
    assert "ss.timed_on" not in jobs[smaller].tags
    assert {s.scale for s in subjects_of_run(experiment, "all")} == {2, 4}
    (subject,) = subjects_of_run(experiment, smaller)
    expected = ("bicubic", {**BICUBIC, "scale": 2}, 2, "none")
    assert (subject.name, subject.model, subject.scale, subject.jitter) == expected


def test_shares_of_the_ceilings():
    """6e6 MACs in 3 ms are 2e9 per second, of 8e9; 1.5e6 bytes are 5e8, of 1e9."""
    outcome = Outcome(case=CASE, seconds=[0.003, 0.003], peak=5e6, ceiling=Ceiling(8e9, 1e9))
    timing = timing_of(outcome, Workload(7, 6e6, 1.5e6))
    assert (timing.of_product, timing.of_copy) == pytest.approx((0.25, 0.5))
    assert (timing.ms, timing.frames, timing.peak_mb) == (3.0, 2, 5.0)
    assert (timing.gmac, timing.gbytes) == (0.006, 0.0015)
    missing = timing_of(Outcome(case=CASE, reason="It cannot."), Workload(7, 6e6, 1.5e6))
    assert (missing.runs, missing.reason, math.isnan(missing.of_copy)) == (False, "It cannot.", True)


def test_size_that_the_scale_of_a_run_does_not_divide():
    assert "no multiple of its scale, 7" in benchmark._missing(replace(CASE, scale=7), None, None)


@pytest.mark.slow
def test_command(tmp_path):
    """Time two methods with two backends, one of which is missing: the tables are in MLflow, and the parts add up."""
    settings = [
        "methods=[bicubic,dlctus]",
        "sizes=[[32,32]]",
        "rounds=2",
        "frames=2",
        "threads=1",
        "depth=2",
        "device=cpu",
    ]
    store = [f"paths.root={tmp_path}", f"tracking_uri=sqlite:///{tmp_path}/mlflow.db"]
    command = [sys.executable, "benchmark.py", *settings, "backends=[eager,tensorrt]", *store]
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
    ms = stages[stages.method == "dlctus"].set_index("part").ms
    assert ms[[n for n in ms.index if "." not in n and n != "total"]].sum() == pytest.approx(ms.total)


@pytest.mark.slow
def test_command_with_rendering_and_what_reports_read_of_it(tmp_path):
    """A switch in a method's name, a backend of one method only, and the renderer's own time, read back."""
    uri = f"sqlite:///{tmp_path}/mlflow.db"
    settings = ["sizes=[[32,32]]", "rounds=1", "frames=2", "seconds=0.1", "threads=1", "depth=2", "device=cpu"]
    settings += ["rendering=true", "scene=turntable", f"paths.root={tmp_path}", f"tracking_uri={uri}"]
    methods = 'methods=["dlctus reproject=bilinear",jau]'
    command = [sys.executable, "benchmark.py", methods, "backends=[eager,thesis_1]", *settings]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert "jau x4 32x32 thesis_1 float32: The thesis_1 backend runs DLCTUS only, not JAU" in done.stdout
    experiment = open_experiment(uri, "supersampling", tmp_path)
    measurements = read_measurements(Store(uri, tmp_path / "copies"), experiment.id)
    items = {(item.run.params["model"], item.run.params["backend"]): item for item in measurements}
    assert set(items) == {(m, b) for m in ("dlctus", "none") for b in ("eager", "thesis_1")} | {("jau", "eager")}
    plain = items["dlctus", "eager"]
    assert plain.run.params["model.reproject"] == "bilinear"
    parts = ("prepare_input", "network", "construct", "(its own)")
    assert plain.value("ms", " + ".join(parts)) == pytest.approx(plain.value("ms", "total"))
    assert plain.value("parameters", "network.blocks") == 4 * (2 * 32 * 32 * 9 + 64)
    assert 0 < plain.value("ms", "render.g_buffers") < plain.value("ms", "render")
    full = items["none", "eager"]
    assert full.run.params["size"] == "32x32"
    assert full.value("ms", "render + whole") == full.value("ms", "render") > 0
    assert "OpenGL" in full.renderer


def test_unknown_backend(tmp_path):
    command = [sys.executable, "benchmark.py", "backends=[eager,cudnn]", f"paths.root={tmp_path}"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode != 0
    assert "Unknown option backends=cudnn: use" in done.stderr
    assert "Traceback" not in done.stderr
