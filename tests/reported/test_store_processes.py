"""Stores in whole copies of the project, and the commands that sentences print, in processes of their own."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from answers import ROOT
from mlflow import MlflowClient

from supersampling.errors import UserError
from supersampling.runs.experiment import open_experiment
from supersampling.runs.location import VARIABLE, uri_of_file
from supersampling.runs.store import Store

SKIPPED = shutil.ignore_patterns(
    *(".*", "__pycache__", "*.egg-info", "*.db", "mlartifacts", "datasets", "outputs", "out", "docs", "tests")
)


def run(folder: Path, *words: str) -> str:
    """Run a script of a copy of the project; return what it printed."""
    environment = {name: value for name, value in os.environ.items() if name not in (VARIABLE, "SUPERSAMPLING_ROOT")}
    environment |= {"PYTHONPATH": str(folder / "src"), "OMP_NUM_THREADS": "1"}
    result = subprocess.run(
        [sys.executable, *words], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


@pytest.mark.slow
@pytest.mark.parametrize("name", ["a%20b", "100% é#1 (v2), x=1"])
def test_a_checkout_in_a_folder_with_special_characters(name: str, files: dict[str, Path], tmp_path: Path) -> None:
    project = tmp_path / "projects" / name
    shutil.copytree(ROOT, project, ignore=SKIPPED)
    splits = [f"data.{split}=[{path}]" for split, path in files.items()]
    data = ["data=files", *splits, "scene=atrium", "task.scale=2", "metrics=fast", "threads=1", "model=jau"]
    run(project, "evaluate.py", *(word for word in data if not word.startswith(("data.train", "data.val"))))
    run(project, "train.py", *data, "budget=smoke", "baselines=[]", "workers=0", "trainer.accelerator=cpu")
    (job,) = Store(uri_of_file(project / "mlflow.db"), tmp_path).experiment("supersampling").runs
    run(project, "report.py")
    assert (project / "reports" / "out" / "overview.pdf").is_file()
    assert job.metrics["test/psnr"] > 20
    assert [path.name for path in project.parent.iterdir()] == [name]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["plain", "a%20b's"])
def test_the_printed_commands_work(name: str, new_database: Path, tmp_path: Path) -> None:
    folder = tmp_path / name
    folder.mkdir()
    uri = uri_of_file(shutil.copy(new_database, folder / "mlflow.db"))
    experiment = open_experiment(uri, "runs", folder / "files")
    client = MlflowClient(uri)
    client.delete_experiment(experiment.id)
    with pytest.raises(UserError) as error:
        Store(uri, tmp_path).experiment("runs")
    command = str(error.value).partition("restore it with ")[2].partition(", or set")[0]
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    subprocess.run(command, shell=True, check=True, env={**os.environ, "PATH": path})
    assert open_experiment(uri, "runs", folder / "files").id == experiment.id
    assert [path.name for path in tmp_path.iterdir()] == [name]
