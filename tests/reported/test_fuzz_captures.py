"""Captures with random edits: refused in a sentence, imported with the same values, or with a line about it."""

import itertools
import random
import shutil

import numpy as np
import pytest
from capture_edits import Effect, edit_capture
from capture_files import make_source
from fuzzing import trials

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.exporters.exporting import export
from supersampling.data.readers.importing import import_capture
from supersampling.errors import UserError


def read(paths):
    """Return all buffers by clip."""
    content = {}
    for path in paths:
        file = DatasetFile(path)
        for clip, name in itertools.product(range(file.clips), sorted(file.buffers)):
            content[file.spec.scene, file.spec.split, clip, name] = file.read(name, clip, slice(None))
        file.close()
    return content


def attempt(layout, capture, out):
    """Return what an import reads, nothing if it is refused in one sentence."""
    try:
        return read(import_capture(layout, capture, out, scale=2))
    except UserError as error:
        if not str(error) or "\n" in str(error):
            raise AssertionError("more than one sentence") from error
        return {}


def same(first, second):
    return first.keys() == second.keys() and all(np.array_equal(first[key], second[key]) for key in first)


@pytest.fixture(scope="module")
def captures(tmp_path_factory):
    """Return a capture of each layout."""
    folder, captures = tmp_path_factory.mktemp("captures"), {}
    for layout, jittered in (("qrisp", True), ("arm", True), ("nsrd", False)):
        source = make_source(folder / f"{layout}source", clips=2, frames=4, jittered=jittered)
        captures[layout] = export(layout, source, folder / layout)
    return captures


@pytest.mark.slow
@pytest.mark.parametrize("layout", ["qrisp", "arm", "nsrd"])
def test_edited_captures(captures, layout, tmp_path, capsys):
    capsys.readouterr()
    expected = attempt(layout, captures[layout], tmp_path / "plain")
    lines = set(capsys.readouterr().out.splitlines())
    for seed in trials(share=1 / 3):  # of three layouts
        folder = tmp_path / str(seed)
        capture = shutil.copytree(captures[layout], folder / layout)
        names, effects = edit_capture(capture, random.Random(f"{layout} {seed}"))
        text = f"seed {seed}, {', '.join(names)}: see {folder}"
        try:
            content = attempt(layout, capture, folder / "out")
        except Exception as error:
            raise AssertionError(text) from error
        output = set(capsys.readouterr().out.splitlines())
        if content and Effect.UNKNOWN not in effects and not same(content, expected):
            assert Effect.NAMED in effects, text
            assert output - lines, text
        shutil.rmtree(folder)
