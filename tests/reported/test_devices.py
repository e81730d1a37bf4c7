"""Training on several devices: two processes on the processor, which exchange gradients as graphics cards do."""

import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
import torch
from answers import ROOT, Answer, run_script
from capture_files import make_source
from mlflow.entities import Run
from mlflow.tracking import MlflowClient
from omegaconf import OmegaConf

from supersampling.data.clips import WholeClips
from supersampling.training.devices import devices_of

TOLERANCE = 1e-5  # of weights and metrics: gradients are added in another order
LONG = ("budget.epochs=12", "budget.steps=4")


def project(data: Sequence[str], root: Path) -> list[str]:
    """Return the overrides of a training, in a project of its own with three validation clips: an odd number."""
    val = make_source(root / "val", split="val", clips=3)
    kept = [word for word in data if not word.startswith(("data.val=", "paths.root="))]
    # MLflow puts the store of a command in this process into the environment.
    return [*kept, f"data.val=[{val}]", f"paths.root={root}", f"tracking_uri=sqlite:///{root}/mlflow.db"]


def weights_of(root: Path) -> dict[str, torch.Tensor]:
    """Return the weights in the checkpoint of a project's run."""
    (path,) = (root / "mlartifacts").rglob("last.ckpt")
    return torch.load(path, weights_only=True)["state_dict"]


def runs_of(root: Path) -> list[Run]:
    client = MlflowClient(f"sqlite:///{root}/mlflow.db")
    return list(client.search_runs([e.experiment_id for e in client.search_experiments()], order_by=["start_time"]))


def check_same(root: Path, reference: Path) -> None:
    """Check that two projects have the same runs with the same metrics, and the same weights."""
    weights, expected = weights_of(root), weights_of(reference)
    assert weights.keys() == expected.keys()
    for name, values in expected.items():
        torch.testing.assert_close(weights[name], values, atol=TOLERANCE, rtol=0, msg=name)
    pairs = list(zip(runs_of(root), runs_of(reference), strict=True))
    for run, other in pairs:
        assert run.info.status == other.info.status == "FINISHED"
        assert run.data.metrics.keys() == other.data.metrics.keys()
        for name in run.data.metrics.keys() - {"train/minutes"}:
            assert run.data.metrics[name] == pytest.approx(other.data.metrics[name], abs=100 * TOLERANCE), name
    assert {"train/loss", "val/psnr", "train/minutes"} <= pairs[-1][0].data.metrics.keys()


@pytest.fixture
def one_device(command: Callable[..., Answer], data: list[str], tmp_path: Path) -> Path:
    """Return the project of a finished training on one device."""
    root = tmp_path / "one"
    assert command("train", *project(data, root), "trainer.devices=1").status == 0
    return root


def check_strategy(command, data, one_device, root, *strategy):
    answer = command("train", *project(data, root), "trainer.devices=2", *strategy)
    assert answer.status == 0, answer.text
    (line,) = answer.text.splitlines()  # of the one process that does the job
    assert line.startswith("dlctus theta=0.1 seed=0 x2: run ")
    check_same(root, one_device)


def test_two_devices(command, data, one_device, tmp_path, row):
    check_strategy(command, data, one_device, tmp_path / "two")
    row("1", "trainer.devices=2", "trains; weights and metrics are those of one device up to rounding")


def test_all_starts_are_the_same(files, row):
    """The slow test below trains with them."""
    starts = ("ddp", "ddp_spawn", "ddp_fork", "ddp_notebook")
    trainers = [{"accelerator": "cpu", "devices": 2, "strategy": start} for start in starts]
    results = [devices_of(OmegaConf.create({"budget": {"batch": 2}, "trainer": trainer})) for trainer in trainers]
    assert [(r.count, r.arguments["strategy"]) for r in results] == [(2, "ddp_find_unused_parameters_true")] * 4
    clips = WholeClips([files["test"]], frozenset({"color"}))
    copy = pickle.loads(pickle.dumps(clips))
    assert len(copy) == len(clips)
    assert copy[1]["color"].equal(clips[1]["color"])
    row("1b", "trainer.devices=2 +trainer.strategy=ddp_spawn", "trains, as do ddp, ddp_fork and ddp_notebook")


@pytest.mark.slow
@pytest.mark.parametrize("strategy", ["ddp", "ddp_spawn"])
def test_strategies(command, data, one_device, tmp_path, strategy):
    check_strategy(command, data, one_device, tmp_path / strategy, f"+trainer.strategy={strategy}")


@pytest.mark.parametrize(
    ("overrides", "sentence"),
    [
        (["trainer.devices=3"], "budget.batch=2 cannot be dealt out equally to 3 devices (trainer.devices=3)"),
        (["trainer.devices=2", "+trainer.strategy=fsdp"], "trainer.strategy=fsdp is not supported: use ddp, ddp_spawn"),
        (["+trainer.num_nodes=2"], "trainer.num_nodes=2 is not supported: a job trains on one machine"),
    ],
)
def test_refused_before_anything_is_written(command, data, tmp_path, row, overrides, sentence):
    answer = command("train", *data, *overrides)
    assert (answer.status, answer.last_line.startswith(f"error: {sentence}")) == (2, True), answer.text
    assert not (tmp_path / "mlflow.db").exists()
    row("1", " ".join(overrides), answer.last_line)


def begin(arguments: Sequence[str]) -> subprocess.Popen[str]:
    """Start a training, and wait until it has written a checkpoint."""
    process = subprocess.Popen(
        [sys.executable, "train.py", *arguments],
        cwd=ROOT,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    (root,) = (Path(word.removeprefix("paths.root=")) for word in arguments if word.startswith("paths.root="))
    while not list(root.rglob("last.ckpt")):
        assert process.poll() is None, process.communicate()[0]
        time.sleep(0.05)
    return process


def members(process: subprocess.Popen[str]) -> list[int]:
    """Return the numbers of the processes of a training's devices, by rank."""
    tasks = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    return [int(n) for n in tasks if b"spawn_main" in Path(f"/proc/{n}/cmdline").read_bytes()]


def wait_until_gone(numbers: Sequence[int]) -> None:
    end = time.monotonic() + 30
    while any(Path(f"/proc/{n}").exists() for n in numbers):
        assert time.monotonic() < end, "a process of a device outlives the training"
        time.sleep(0.1)


@pytest.mark.slow
@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_all_and_one_device_continues(command, data, tmp_path, signum):
    root = tmp_path / "two"
    arguments = [*project(data, root), *LONG]
    process = begin([*arguments, "trainer.devices=2"])
    numbers = members(process)
    assert len(numbers) == 2
    process.send_signal(signum)
    text, _ = process.communicate(timeout=120)
    assert process.returncode == 130, text
    assert "Traceback" not in text
    wait_until_gone(numbers)
    assert runs_of(root)[-1].info.status == "KILLED"
    # The same job, on another number of devices.
    assert command("train", *arguments, "trainer.devices=1").status == 0
    reference = tmp_path / "one"
    assert command("train", *project(data, reference), *LONG, "trainer.devices=1").status == 0
    check_same(root, reference)


@pytest.mark.slow
@pytest.mark.parametrize("rank", [0, 1])
def test_a_process_that_is_killed_ends_all(data, tmp_path, rank):
    arguments = [*project(data, tmp_path), "budget.epochs=500", "trainer.devices=2"]
    process = begin(arguments)
    numbers = members(process)
    os.kill(numbers[rank], signal.SIGKILL)
    text, _ = process.communicate(timeout=120)
    assert process.returncode == 1, text
    assert f"process {rank} terminated with signal SIGKILL" in text
    wait_until_gone(numbers)
    assert runs_of(tmp_path)[-1].info.status == "FAILED"


@pytest.mark.slow
def test_nothing_stays_behind_a_command_that_is_killed(data, tmp_path):
    process = begin([*project(data, tmp_path), "budget.epochs=500", "trainer.devices=2"])
    numbers = members(process)
    process.kill()
    process.communicate(timeout=120)
    wait_until_gone(numbers)


@pytest.mark.slow
def test_the_jobs_of_a_multirun(data, tmp_path):
    arguments = [*project(data, tmp_path), "seed=0,1", "trainer.devices=2", "+trainer.strategy=ddp_notebook", "-m"]
    answer = run_script("train", arguments, timeout=600)
    assert answer.status == 0, answer.text
    assert [run.info.status for run in runs_of(tmp_path)] == ["FINISHED"] * 5  # the sweep, two sanity rows, two jobs
    assert len(answer.text.splitlines()) == 2, answer.text
