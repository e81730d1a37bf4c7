"""Settings of ``trainer.`` as people set them elsewhere: each works, or is refused in a sentence before any work."""

from pathlib import Path

import pytest
import torch
from mlflow.tracking import MlflowClient

from supersampling.training.module import Training

USE_EPOCHS = "use budget.epochs, and budget.steps for the steps of each epoch."


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
    answer = command("train", *data, f"trainer.precision={precision}", "budget.epochs=1")
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
    return [run.data.metrics["test/psnr"] for run in runs if "test/psnr" in run.data.metrics]


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
        (
            "log_every_n_steps=1",
            "use budget.steps: losses are logged once per epoch, which has budget.steps steps.",
        ),
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
        (["trainer.limit_train_batches=1"], 2),
        (["trainer.limit_train_batches=0.5"], 2),
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
    """Each process makes one step: the limit is over at once."""
    root = [word for word in data if not word.startswith("paths.root=")]
    command("train", *root, f"paths.root={tmp_path / 'whole'}", "budget.steps=3")
    limit = [*root, f"paths.root={tmp_path / 'cut'}", "budget.steps=3", "trainer.max_time=00:00:00:01"]
    times = iter(range(0, 100000, 2))
    monkeypatch.setattr("supersampling.training.time_limit.monotonic", lambda: next(times))
    steps = []
    step = Training.training_step

    def recorded(self, clip, batch_index):
        steps.append((self.current_epoch, batch_index))
        return step(self, clip, batch_index)

    monkeypatch.setattr(Training, "training_step", recorded)
    for number in range(1, 6):
        answer = command("train", *limit)
        assert answer.status == 124, answer.text
        assert answer.last_line == (
            f"Stopped by trainer.max_time=0:00:01 in epoch {number // 3}, after {number} of 6 steps: the same command "
            "continues from here."
        )
        assert statuses(tmp_path / "cut") == ["KILLED"]
    assert command("train", *limit).status == 0
    assert statuses(tmp_path / "cut") == ["FINISHED"]
    assert steps == [(epoch, batch) for epoch in range(2) for batch in range(3)]
    whole, cut = (checkpoint(tmp_path / name)["state_dict"] for name in ("whole", "cut"))
    assert all(torch.equal(whole[name], cut[name]) for name in whole)
    row("11", "trainer.max_time=00:00:00:01", "stops with status 124 and a checkpoint; continues to the same weights")
