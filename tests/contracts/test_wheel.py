"""The wheel, installed into an empty environment, trains, scores and reports in an empty folder."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PARTS = ("conf", "sweeps", "reports", "src", "pyproject.toml", "setup.py", "MANIFEST.in", "README.md", "LICENSE")


def call(*line: str | Path, folder: Path, **environment: str) -> str:
    """Run a command and return what it prints."""
    clean = {k: v for k, v in os.environ.items() if not k.startswith(("SUPERSAMPLING", "PYTHONPATH", "MLFLOW"))}
    done = subprocess.run(
        [str(word) for word in line], cwd=folder, env=clean | environment, capture_output=True, text=True, timeout=1800
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Build the wheel from a copy, so that nothing is written into the checkout."""
    source, out = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("wheel")
    for name in PARTS:
        path = ROOT / name
        ignore = shutil.ignore_patterns("out", "*.egg-info", "__pycache__")
        shutil.copytree(path, source / name, ignore=ignore) if path.is_dir() else shutil.copy(path, source / name)
    call(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", out, source, folder=source)
    return next(out.glob("*.whl"))


@pytest.mark.slow
def test_it_carries_what_commands_read(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    for folder in ("conf", "sweeps", "reports/published", "reports/templates"):
        expected = {p.relative_to(ROOT).as_posix() for p in (ROOT / folder).rglob("*") if p.is_file()}
        assert {f"supersampling/resources/{name}" for name in expected} <= set(names)
    assert not [name for name in names if "/reports/out/" in name or name.startswith("tests")]


@pytest.mark.slow
def test_it_trains_scores_and_reports_in_an_empty_folder(wheel, tmp_path):
    venv, folder = tmp_path / "venv", tmp_path / "empty"
    folder.mkdir()
    call(sys.executable, "-m", "venv", venv, folder=tmp_path)
    call(venv / "bin" / "pip", "install", "--quiet", "-c", ROOT / "constraints.txt", wheel, folder=tmp_path)
    command = venv / "bin" / "supersampling"
    assert "advise" in call(command, folder=folder)
    small = [
        "data=smoke",
        "budget=smoke",
        "scene=foundry",
        "workers=0",
        "trainer.enable_progress_bar=false",
        "threads=1",
    ]
    printed = call(command, "train", *small, folder=folder)
    run = printed.rsplit(": run ", 1)[1].split()[0]
    call(command, "evaluate", f"run={run}", "data=smoke", "scene=foundry", "threads=1", folder=folder)
    call(command, "report", folder=folder)
    assert (folder / "reports" / "out" / "overview.pdf").stat().st_size > 10_000
    assert {p.name for p in folder.iterdir()} == {"datasets", "mlartifacts", "mlflow.db", "outputs", "reports"}
