"""Captures with motion that says nothing, with a marked sky, and without motion in high resolution."""

import shutil
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from capture_files import make_source

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.exporters.exporting import export
from supersampling.data.exporters.images import write_exr

QRISP_MOTION = "TestSet/World/540p/MotionVectorsMipBiasMinus1Jittered"


@pytest.fixture(scope="module")
def captures(tmp_path_factory):
    """Return each layout's capture of the closed-form world, with its data set file, not to be changed."""
    folder = tmp_path_factory.mktemp("captures")
    jittered, plain = (make_source(folder / f"source{j}", clips=1, frames=4, jittered=bool(j)) for j in (1, 0))
    sources = {"qrisp": jittered, "arm": jittered, "nsrd": plain}
    return {layout: (source, export(layout, source, folder / layout)) for layout, source in sources.items()}


@pytest.fixture
def copy(captures, tmp_path):
    """Return a function that copies the capture of a layout, to be broken."""
    return lambda layout: Path(shutil.copytree(captures[layout][1], tmp_path / layout))


def planes(path, names):
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    return np.stack([channels[c].pixels.astype(np.float32) for c in names], axis=-1)


def rewrite(folder, names, change, half=True):
    for path in sorted(folder.rglob("*.exr")):
        write_exr(path, change(planes(path, names)), names, half=half)


def arguments(layout, path, tmp_path):
    return f"layout={layout}", f"path={path}", "task.scale=2", f"paths.root={tmp_path}"


@pytest.mark.parametrize(
    ("layout", "folders"), [("qrisp", [QRISP_MOTION]), ("arm", ["test/x2/motion", "test/motion_gt"])]
)
def test_zero_motion_while_pictures_move(command, row, copy, tmp_path, layout, folders):
    capture = copy(layout)
    for folder in folders:
        rewrite(capture / folder, "RG", np.zeros_like)
    answer = command("import_capture", *arguments(layout, capture, tmp_path))
    assert answer.status == 2
    assert "of the pictures" in answer.last_line
    assert "all motion is 0, so record the motion again" in answer.last_line
    convention = {"qrisp": "-xy", "arm": "-x-y"}[layout]
    answer = command("import_capture", *arguments(layout, capture, tmp_path), f"convention={convention}")
    assert answer.status == 0
    assert "all motion is 0, so record the motion again" in answer.text
    row("21", "motion is all zero while the pictures move", "refused: how much moves, by how many pixels, what to do")


@pytest.mark.parametrize("sky", [1e10, 65504.0, 3.4e38, -1.0, 0.0])
def test_marked_sky_in_depth(command, row, captures, copy, tmp_path, sky):
    capture = copy("nsrd")

    def distances(depth):
        depth = (depth * 50.0).astype(np.float32)  # 10 to 40
        depth[:3] = sky
        return depth

    rewrite(capture / "test/X2/0/Depth", "R", distances, half=False)
    answer = command("import_capture", *arguments("nsrd", capture, tmp_path))
    assert answer.status == 0
    assert f"captured depth is divided by 100; {np.float32(sky):g} (9.4% of the pixels) counts as sky" in answer.text
    depth = DatasetFile(Path(answer.last_line)).read("depth", 0, slice(None))
    expected = (DatasetFile(captures["nsrd"][0]).read("depth", 0, slice(None)) * 50.0).astype(np.float32) / 100.0
    expected[:, :, :3] = 1.0
    np.testing.assert_array_equal(depth, expected.astype(np.float32))
    row("22", "depth with a sky at 1e10", "sky becomes 1, the rest keeps its range; a line names the mark and the unit")


def test_only_motion_in_low_resolution(command, row, copy, tmp_path):
    capture = copy("arm")
    shutil.rmtree(capture / "test/motion_gt")
    answer = command("import_capture", *arguments("arm", capture, tmp_path))
    assert answer.status == 0
    assert f"{capture} has no motion_gt: imported without high_motion." in answer.text
    assert DatasetFile(Path(answer.last_line)).buffers == {
        *("color", "radiance", "depth", "motion", "jitter", "target", "target_radiance")
    }
    row("34", "Arm capture without motion_gt", "imported without high_motion, with a line that says so")


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("path=2024", "Capture folder 2024 not found: correct path=."),
        ("path=[a]", "Capture folder [a] not found: correct path=."),
        ("convention=1", "Unknown convention '1': use one of xy, "),
        ("reversed_depth=maybe", "Invalid reversed_depth=maybe: use true or false."),
        ("reversed_depth=1", "Invalid reversed_depth=1: use true or false."),
        ("task.scale=two", "Invalid task.scale=two: use a whole number between 2 and 6."),
    ],
)
def test_settings_of_another_type(command, captures, tmp_path, setting, message):
    answer = command("import_capture", *arguments("nsrd", captures["nsrd"][1], tmp_path), setting)
    assert answer.status == 2
    assert message in answer.last_line
