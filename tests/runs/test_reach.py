"""Runs and experiments that were deleted, moved, or logged by another program."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy
from mlflow import MlflowClient
from mlflow.exceptions import MlflowException

from supersampling.errors import UserError
from supersampling.runs.experiment import Experiment, open_experiment
from supersampling.runs.location import VARIABLE, uri_of_file
from supersampling.runs.store import Store


@pytest.fixture
def project(database: Path) -> Path:
    return database.parent


def opened(project: Path, name: str = "runs") -> Experiment:
    return open_experiment(uri_of_file(project / "mlflow.db"), name, project / "mlartifacts")


def refusal(call: Callable[[], Any]) -> str:
    with pytest.raises(UserError) as error:
        call()
    return str(error.value)


def test_a_deleted_run_and_one_that_does_not_exist(project: Path) -> None:
    experiment = opened(project)
    run = experiment.start("a run", {"ss.kind": "job"}, None)
    experiment.client.delete_run(run)
    sentence = refusal(lambda: experiment.run(run))
    assert f"mlflow runs restore --run-id {run}" in sentence
    assert "There is no run 123" in refusal(lambda: experiment.run("123"))


@pytest.mark.parametrize(
    ("tags", "status", "part"),
    [
        ({}, "FINISHED", "another program logged it"),
        ({"ss.kind": "evaluation"}, "FINISHED", "it is of kind evaluation"),
        ({"ss.kind": "job"}, "RUNNING", "its status is RUNNING"),
        ({"ss.kind": "job"}, "FINISHED", "bring its files back to file:///"),
    ],
)
def test_a_run_without_the_wanted_file(project: Path, tags: dict[str, str], status: str, part: str) -> None:
    experiment = opened(project)
    run = experiment.start("a run", tags, None)
    experiment.client.update_run(run, status=status)
    sentence = refusal(lambda: experiment.required_artifact(experiment.run(run), "config.yaml"))
    assert sentence.startswith(f"Run {run} has no config.yaml")
    assert part in sentence


def finished(experiment: Experiment) -> str:
    run = experiment.start("a rün, 日本", {"ss.kind": "job"}, None)
    experiment.client.log_text(run, "scale: 2", "config.yaml")
    experiment.finish(run)
    return run


def test_a_project_that_was_moved_says_how_its_files_are_found_again(project: Path, tmp_path: Path) -> None:
    former, latter = tmp_path / "former", tmp_path / "latter's"
    former.mkdir()
    shutil.move(project / "mlflow.db", former / "mlflow.db")
    run = finished(opened(former))
    former.rename(latter)
    for sentence in (
        refusal(lambda: opened(latter)),
        refusal(lambda: Store(uri_of_file(latter / "mlflow.db"), tmp_path).experiment("runs")),
    ):
        assert f"are not in {former}/mlartifacts" in sentence
    assert not former.exists()
    assert os.system(sentence.partition("with ")[2].removesuffix(".")) == 0
    assert opened(latter).artifact(run, "config.yaml").read_text() == "scale: 2"
    assert [run.name for run in Store(uri_of_file(latter / "mlflow.db"), tmp_path).experiment("runs").runs] == [
        "a rün, 日本"
    ]


def test_the_next_project_of_a_process_does_not_take_the_store_of_the_last(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    opened(project)
    assert VARIABLE not in os.environ
    monkeypatch.setenv(VARIABLE, "")
    opened(project)
    assert os.environ[VARIABLE] == ""


def test_an_experiment_that_another_process_creates_meanwhile_is_taken(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened(project)
    create = MlflowClient.create_experiment

    def late(client: MlflowClient, *arguments: Any, **more: Any) -> str:
        create(client, *arguments, **more)
        return create(client, *arguments, **more)

    monkeypatch.setattr(MlflowClient, "create_experiment", late)
    assert opened(project, "at once").id


def test_a_name_that_mlflow_refuses(project: Path) -> None:
    assert "experiment_name=" in refusal(lambda: opened(project, ""))
    assert "experiment_name=nnn" in refusal(lambda: opened(project, "n" * 600))


def test_a_store_that_fails_while_it_is_used_is_told_and_errors_of_ours_pass(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    experiment = opened(project)

    def fail(message: str) -> Callable[..., None]:
        def call(*arguments: Any, **more: Any) -> None:
            raise MlflowException("wrapped") from sqlalchemy.exc.OperationalError("SQL", {}, Exception(message))

        return call

    monkeypatch.setattr(MlflowClient, "log_metric", fail("database is locked"))
    assert "mlflow.db is locked" in refusal(lambda: experiment.log_metrics("run", {"a": 1.0}))
    monkeypatch.setattr(MlflowClient, "log_metric", fail("no such column: value"))
    with pytest.raises(MlflowException):
        experiment.log_metrics("run", {"a": 1.0})
