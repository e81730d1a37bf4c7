"""A composed configuration says which buffers it reads, and nothing else is touched."""

import subprocess
import sys
from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra

from supersampling.data.dataset_file import DatasetFile
from supersampling.training.job import fitting_buffers, scoring_buffers

ROOT = Path(__file__).resolve().parents[2]
FRAME = {"color", "target"}
CASES = {
    ("model=bicubic", "metrics=fast"): FRAME,
    ("model=bicubic",): FRAME | {"motion", "motion_dual"},
    ("model=bicubic", "metrics=capture"): FRAME | {"motion"},
    ("model=jau", "metrics=fast"): FRAME | {"jitter"},
    ("model=tus", "metrics=fast"): FRAME | {"jitter", "motion"},
    ("model=tus", "model/dilate=closest", "metrics=fast"): FRAME | {"jitter", "motion", "depth"},
    ("model=dlctus", "loss=l1", "metrics=fast"): FRAME | {"jitter", "motion", "depth"},
}


@pytest.mark.parametrize("overrides", CASES, ids=" ".join)
def test_what_it_reads(overrides):
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):
        cfg = compose("train", [*overrides, "scene=atrium"])
    assert fitting_buffers(cfg) | scoring_buffers(cfg) == CASES[overrides]


def test_a_bicubic_run_renders_colour_alone(tmp_path):
    small = ["data=smoke", "scene=foundry", "data.train.clips=1", f"paths.root={tmp_path}"]
    store = f"tracking_uri=sqlite:///{tmp_path}/mlflow.db"
    run = [sys.executable, "train.py", "model=bicubic", "metrics=fast", "baselines=[]", *small, store]
    done = subprocess.run(run, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    files = list(tmp_path.rglob("*.h5"))
    assert len(files) == 3
    for path in files:
        assert DatasetFile(path).buffers == FRAME
