"""Settings of ``trainer.`` as people set them elsewhere: each works, or is refused in a sentence before any work."""

from itertools import count
from pathlib import Path

import pytest
import torch
from mlflow.tracking import MlflowClient

USE_EPOCHS = "use budget.epochs, and budget.steps for the steps of each epoch."


@pytest.fixture(autouse=True)
def _own_store(monkeypatch):
    """MLflow puts the store of an earlier test into the environment."""
    monkeypatch.delenv("MLFLOW_TRACKING_URI", raising=False)


def checkpoint(folder: Path) -> dict:
    (path,) = folder.glob("outputs/checkpoints/*/last.ckpt")
    return torch.load(path, weights_only=True)


def statuses(folder: Path) -> list[str]:
    client = MlflowClient(f"sqlite:///{folder}/mlflow.db")
    runs = client.search_runs([e.experiment_id for e in client.search_experiments()], "tags.`ss.kind` = 'job'")
    return [run.info.status for run in runs]


@pytest.fixture
def refused(command, data, tmp_path):
    """Return a function that trains with these settings, and asserts on the sentence and that nothing was begun."""

    def check(*settings: str) -> str:
        answer = command("train", *data, *settings)
        assert answer.status == 2, answer.text
        assert not (tmp_path / "mlflow.db").exists()
        assert "Traceback" not in answer.text
        return answer.last_line.removeprefix("error: ")

    return check


@pytest.mark.parametrize("precision", ["64-true", "bf16-true"])
def test_other_precision_is_scored_in_float32(precision, command, data, tmp_path, files, row):
    answer = command("train", *data, f"trainer.precision={precision}", "budget.epochs=1", "budget.steps=1")
    assert answer.status == 0, answer.text
    (path,) = tmp_path.glob("outputs/checkpoints/*/last.ckpt")
    dtype = torch.float64 if precision == "64-true" else torch.bfloat16
    assert {weight.dtype for weight in checkpoint(tmp_path)["state_dict"].values()} == {dtype}
    test = [f"data.test=[{files['test']}]", "scene=atrium", "task.scale=2", "metrics=fast", "threads=1"]
    answer = command("evaluate", "data=files", *test, f"checkpoint={path}", f"paths.root={tmp_path}")
    assert answer.status == 0, answer.text
    values = scores(tmp_path)
    assert len(values) == 2  # of the training and of the checkpoint that it wrote
    assert values[0] == values[1]
    row("10", f"trainer.precision={precision}", "trains, is scored in float32; evaluate.py reads the checkpoint alike")


def scores(folder: Path) -> list[float]:
    client = MlflowClient(f"sqlite:///{folder}/mlflow.db")
    runs = client.search_runs([e.experiment_id for e in client.search_experiments()])
    return [run.data.metrics["test/psnr"] for run in runs if run.data.tags["ss.kind"] in ("job", "evaluation")]


def test_quick_run(refused, row):
    sentence = refused("+trainer.fast_dev_run=true")
    assert sentence == (
        "Invalid trainer.fast_dev_run=True: use budget=smoke for a quick run, or debug=one_step for a single step."
    )
    row("11", "+trainer.fast_dev_run=true", f"refused: {sentence}")


@pytest.mark.parametrize(
    ("setting", "advice"),
    [
        ("max_epochs=1", USE_EPOCHS),
        ("callbacks=[x]", "leave it out: a job sets its own callbacks."),
        ("enable_model_summary=True", "use count.py, which prints the size of a method."),
        ("logger=False", "use tracking_uri and experiment_name: a job logs to MLflow."),
        ("check_val_every_n_epoch=2", "use budget.validate_every."),
        ("log_every_n_steps=1", "use budget.steps: losses are logged once per epoch, which has budget.steps steps."),
        ("num_sanity_val_steps=2", "use debug=one_step to try the validation before a long training."),
    ],
)
def test_argument_that_a_job_sets_itself(setting, advice, refused, row):
    sentence = refused(f"+trainer.{setting}")
    assert sentence.replace("'", "") == f"Invalid trainer.{setting}: {advice}"
    row("12", f"+trainer.{setting}", f"refused: {sentence}")


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        (
            ("trainer.accelerator=gpu",),
            "Invalid trainer.accelerator=gpu (No supported gpu backend found): use auto or cpu.",
        ),
        (
            ("trainer.precision=fp16",),
            "Invalid trainer.precision=fp16: use 32-true, 64-true, bf16-true, bf16-mixed or 16-mixed.",
        ),
        (
            ("+trainer.enable_checkpointing=false",),
            "Invalid trainer.enable_checkpointing=False: leave it out: a job continues from its checkpoint and is "
            "scored by it.",
        ),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else "",
)
def test_value_that_is_not_there(settings, sentence, refused, row, monkeypatch):
    monkeypatch.setattr("torch.cuda.device_count", lambda: 0)
    assert refused(*settings) == sentence
    row("13", settings[0], f"refused: {sentence}")


@pytest.mark.parametrize(
    ("settings", "steps"),
    [
        (["+trainer.accumulate_grad_batches=2"], 2),
        (["budget.steps=5", "trainer.accumulate_grad_batches=2", "trainer.limit_train_batches=3"], 4),
    ],
    ids=str,
)
def test_schedule_ends_with_the_training(settings, steps, command, data, tmp_path, row):
    assert command("train", *data, *settings).status == 0
    state = checkpoint(tmp_path)
    (schedule,) = state["lr_schedulers"]
    assert state["global_step"] == schedule["last_epoch"] == schedule["total_steps"] == steps
    row("28", " ".join(settings), "the one-cycle schedule has as many steps as the training, and ends with it")


def test_time_limit_stops_with_a_checkpoint_and_continues(command, data, tmp_path, monkeypatch, row):
    """`tests/training/test_time_limit.py` compares the weights with those of an uninterrupted training."""
    clock = count(step=2)
    monkeypatch.setattr("supersampling.training.time_limit.monotonic", lambda: next(clock))
    settings = [*data, "budget.epochs=1", "trainer.max_time=00:00:00:01"]
    answer = command("train", *settings)
    sentence = (
        "Stopped by trainer.max_time=0:00:01 in epoch 0, after 1 of 2 steps: the same command continues from here."
    )
    assert (answer.status, answer.last_line) == (124, sentence)
    assert statuses(tmp_path) == ["KILLED"]
    assert checkpoint(tmp_path)["global_step"] == 1
    assert command("train", *settings).status == 0
    assert statuses(tmp_path) == ["FINISHED"]
    assert checkpoint(tmp_path)["global_step"] == 2
    row("12", "trainer.max_time=00:00:00:01", f"status 124, a checkpoint, and: {sentence}")
