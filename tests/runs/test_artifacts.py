"""Artifacts of runs that are missing or cut short: the message names the file or the run."""

import os
from pathlib import Path

import pandas as pd
import pytest
from mlflow.exceptions import MlflowException

from supersampling.errors import UserError
from supersampling.metrics.scores import Scores, read_scores, write_scores
from supersampling.runs.method import read_configuration
from supersampling.runs.scores import scores_of


class Artifacts:
    """An experiment whose artifacts are the files of a folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def artifact(self, run_id: str, path: str) -> Path:
        if not (self._folder / path).exists():
            raise MlflowException(f"no {path}")
        return self._folder / path


@pytest.mark.parametrize("content", ["", "model: {option: jau", "- a\n- b", "text", "model: {}\ntask: {}", "\x00\x01"])
def test_broken_configuration(content, tmp_path):
    path = tmp_path / "config.yaml"
    path.write_text(content)
    with pytest.raises(UserError, match=r"config\.yaml is truncated or no configuration of a method: restore it"):
        read_configuration(path)


@pytest.fixture
def table(tmp_path):
    frames = pd.DataFrame({"scene": ["a"] * 400, "clip": 0, "frame": range(400), "psnr": [k / 7 for k in range(400)]})
    clips = pd.DataFrame({"scene": ["a"], "clip": [0], "psnr": [30.0]})
    write_scores(tmp_path / "frames.parquet", Scores.with_scene_means(frames, clips))
    return tmp_path / "frames.parquet"


@pytest.mark.parametrize("share", [0.0, 0.5, 0.999])
def test_scores_cut_short(share, table):
    os.truncate(table, int(table.stat().st_size * share))
    with pytest.raises(UserError, match=r"frames\.parquet is not a Parquet table of scores"):
        scores_of(Artifacts(table.parent), "r1")


def test_changed_scores_are_not_read(table):
    """Parquet has checksums only where they are asked for."""
    data = bytearray(table.read_bytes())
    data[len(data) // 3] ^= 0x10
    table.write_bytes(data)
    with pytest.raises(UserError, match="is not a Parquet table of scores"):
        read_scores(table)


def test_scores_of_a_folder(tmp_path):
    with pytest.raises(UserError, match="is a folder: name a file"):
        read_scores(tmp_path)


def test_no_scores(tmp_path):
    assert scores_of(Artifacts(tmp_path), "r1") is None
