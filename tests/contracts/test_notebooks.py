"""The notebooks run from top to bottom on a store that train.py wrote."""

import os
import re
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

import supersampling

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("path", sorted((ROOT / "notebooks").glob("*.ipynb")), ids=lambda p: p.stem)
def test_it_runs(path, make_file, tmp_path, monkeypatch):
    files = [f"data.{s}=[{make_file(tmp_path, s)}]" for s in ("train", "val", "test")]
    job = [
        "data=files",
        "metrics=capture",
        "scene=atrium",
        *files,
        "budget=smoke",
        "model=bicubic",
        f"paths.root={tmp_path}",
    ]
    # Named outright: mlflow leaves the last store of this process in the environment, which would win.
    job.append(f"tracking_uri=sqlite:///{tmp_path}/mlflow.db")
    baselines = "baselines=[['model=jau']]"
    subprocess.run(
        [sys.executable, "train.py", *job, baselines], cwd=ROOT, check=True, capture_output=True, timeout=300
    )
    monkeypatch.setitem(os.environ, "SUPERSAMPLING_FILE", str(make_file(tmp_path, "test")))
    monkeypatch.setitem(os.environ, "MLFLOW_TRACKING_URI", f"sqlite:///{tmp_path}/mlflow.db")
    notebook = nbformat.read(path, as_version=4)
    NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(path.parent)}}).execute()
    outputs = [o for cell in notebook.cells if cell.cell_type == "code" for o in cell.outputs]
    assert any("image/png" in o.get("data", {}) for o in outputs)


@pytest.mark.parametrize("path", sorted((ROOT / "notebooks").glob("*.ipynb")), ids=lambda p: p.stem)
def test_it_imports_the_public_face_only(path):
    code = "\n".join(cell.source for cell in nbformat.read(path, as_version=4).cells if cell.cell_type == "code")
    imports = [line for line in code.splitlines() if "supersampling" in line and "import" in line]
    assert imports
    assert all(line.startswith("from supersampling import ") for line in imports)


def test_the_example_of_the_documentation_runs(tmp_path):
    text = (ROOT / "docs" / "python.md").read_text()
    (example,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    environment = {**os.environ, "SUPERSAMPLING_ROOT": str(tmp_path), "OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, "-c", example], env=environment, cwd=tmp_path, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert "foundry" in done.stdout
    assert "psnr" in done.stdout


def test_every_name_of_the_face_is_documented():
    text = (ROOT / "docs" / "python.md").read_text() + "".join(p.read_text() for p in (ROOT / "notebooks").iterdir())
    missing = [
        name
        for name in supersampling.__all__
        if name not in text and name not in ("Estimate", "Result", "Upsampler", "WarpCheck")
    ]
    assert not missing
