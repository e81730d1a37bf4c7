"""Random settings and random folder names: a sentence, or a store that gives back what was written."""

import random
import shutil
from pathlib import Path

import pytest
from fuzzing import trials

from supersampling.errors import UserError
from supersampling.runs.experiment import open_experiment
from supersampling.runs.location import VARIABLE, Location, read_location, uri_of_file
from supersampling.runs.store import Store

SETTINGS = (
    "sqlite:///mlflow.db",
    "sqlite:///a/b/mlflow.db?timeout=5",
    "sqlite+pysqlite:///a%20b/mlflow.db",
    "./mlruns",
    "file:///srv/mlruns",
    "http://user:password@127.0.0.1:9/mlflow",
    "https://127.0.0.1:9",
    "postgresql+psycopg2://user:password@127.0.0.1:9/runs",
    "databricks://profile",
    "127.0.0.1:9",
)
CHARACTERS = " %?#&=+:;@/\\'\"~$[]{}()<>|*!`^,.\n\t\r\0aé日\u00a0\u0301\ufffd\udcff"
PIECES = (*CHARACTERS, "%20", "%2F", "%00", "%zz", "..", "//", "${")
LONGEST = 40


def mutated(rng: random.Random, text: str) -> str:
    for _ in range(rng.randint(0, 4)):
        start = rng.randint(0, len(text))
        end = rng.choice([start, start, start + 1, start + rng.randint(0, 6)])
        text = text[:start] + rng.choice([rng.choice(PIECES), ""]) + text[end:]
    return text


def folder_name(rng: random.Random) -> str:
    """Return a name that the file system accepts."""
    pieces = [piece for piece in PIECES if "/" not in piece and piece not in ("\0", "..")]
    name = "".join(rng.choice(pieces) for _ in range(rng.randint(1, LONGEST)))
    return name if name.strip(".") else "a"


def written_and_read(setting: str, project: Path, value: float) -> None:
    """Write a value and a file to a store, and read both again by the same setting."""
    experiment = open_experiment(setting, "runs", project / "mlartifacts")
    run = experiment.start("a run", {"ss.kind": "job"}, None)
    experiment.log_metrics(run, {"value": value})
    experiment.client.log_text(run, str(value), "value.txt")
    experiment.finish(run)
    store = Store(setting, project / "copies")
    runs = store.experiment("runs").runs
    assert runs[-1].metrics["value"] == value
    assert store.folders(runs, "value.txt")[run].read_text() == str(value)


def usable(location: Location, folder: Path) -> bool:
    """Return whether a store is the test's own: nothing else is opened, for opening one creates it."""
    return location.file is not None and folder in location.file.parents and folder in location.file.resolve().parents


@pytest.mark.slow
def test_settings(new_database: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    opened = 0
    for seed in trials(share=1 / 2):
        rng = random.Random(seed)
        setting = mutated(rng, rng.choice(SETTINGS))
        folder = tmp_path / "work" / "inner"
        shutil.rmtree(tmp_path / "work", ignore_errors=True)
        folder.mkdir(parents=True)
        monkeypatch.chdir(folder)
        try:
            location = read_location(setting)
            if not usable(location, folder) or location.file is None:
                continue
            location.file.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(new_database, location.file)
            written_and_read(setting, folder, rng.random())
            opened += 1
        except UserError:
            pass
        except BaseException:
            (tmp_path / "setting.txt").write_text(repr(setting))
            print(f"seed {seed}: {setting!r}")
            raise
    assert opened


@pytest.mark.slow
def test_folder_names(new_database: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    opened = 0
    for seed in trials(share=1 / 2):
        rng = random.Random(seed)
        parent = tmp_path / str(seed)
        project = parent / folder_name(rng)
        project.mkdir(parents=True)
        shutil.copy(new_database, project / "mlflow.db")
        try:
            written_and_read(uri_of_file(project / "mlflow.db"), project, rng.random())
            assert list(parent.iterdir()) == [project]
            opened += 1
        except UserError:
            assert "\udcff" in project.name
        except BaseException:
            (tmp_path / "folder.txt").write_text(repr(project.name))
            print(f"seed {seed}: {project.name!r}")
            raise
        shutil.rmtree(parent)
    assert opened
