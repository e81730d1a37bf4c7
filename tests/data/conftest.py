"""A QRISP capture of the test world; tests of the other layouts create theirs."""

import shutil
from pathlib import Path

import pytest
from capture_files import make_source

from supersampling.data.exporters.exporting import export


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A source file and its capture, not to be changed."""
    folder = tmp_path_factory.mktemp("qrisp")
    source = make_source(folder / "source")
    return source, export("qrisp", source, folder / "capture")


@pytest.fixture
def capture(written, tmp_path):
    """A copy of the capture to be broken."""
    return Path(shutil.copytree(written[1], tmp_path / "capture"))
