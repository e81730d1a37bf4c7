"""Exports that are errors."""

import numpy as np
import pytest
from capture_files import ALL, make_source

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.exporters.exporting import export
from supersampling.data.exporters.source import check_exportable
from supersampling.data.readers.importing import import_capture
from supersampling.data.spec import CaptureSpec
from supersampling.data.writer import ClipWriter, join_clips
from supersampling.errors import UserError


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    return make_source(tmp_path_factory.mktemp("source"), clips=1, frames=2)


@pytest.mark.parametrize(
    ("layout", "lost", "message"),
    [
        ("qrisp", "depth", r"has no depth, .*buffers=\[color,depth,jitter,motion,target\]"),
        ("nsrd", "motion_dual", "has no motion_dual"),
        ("arm", "high_motion", "has no high_motion"),
    ],
)
def test_missing_buffer_is_named_with_the_setting_that_adds_it(tmp_path, layout, lost, message):
    file = make_source(tmp_path / "source", clips=1, frames=2, names=[n for n in ALL if n != lost])
    with pytest.raises(UserError, match=message):
        export(layout, file, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_jittered_inputs_cannot_be_exported_to_nsrd(source, tmp_path):
    with pytest.raises(UserError, match=r"task\.jitter=none"):
        export("nsrd", source, tmp_path / "out")
    assert not list((tmp_path / "out").iterdir())


def test_non_empty_folder_is_not_changed(source, tmp_path):
    (tmp_path / "mine.txt").write_text("keep")
    with pytest.raises(UserError, match="is not empty"):
        export("qrisp", source, tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["mine.txt"]


def test_unknown_layout_and_scale(source, tmp_path):
    with pytest.raises(UserError, match="layout unity"):
        export("unity", source, tmp_path / "out")
    six = make_source(tmp_path / "six", clips=1, frames=2, scale=8)
    with pytest.raises(UserError, match="scale of 8"):
        export("qrisp", six, tmp_path / "other")


def test_targets_of_some_frames_only(tmp_path):
    spec = CaptureSpec(
        scene="a",
        split="train",
        clips=1,
        frames=3,
        targets=1,
        frame=(8, 8),
        window=(8, 8),
        scale=2,
        jitter="none",
        mip_bias="matched",
        samples=1,
        seed=0,
        candidates=1,
    )
    with ClipWriter(tmp_path / "0.h5", {"target": 1}) as writer:
        writer.add("target", np.zeros((8, 8, 3), "float32"))
    join_clips(tmp_path / "all.h5", spec, [tmp_path / "0.h5"], frozenset({"target"}), {})
    with pytest.raises(UserError, match=r"data\.train\.targets=3"):
        check_exportable(DatasetFile(tmp_path / "all.h5"), frozenset({"target"}), "qrisp")


@pytest.mark.parametrize("layout", ["qrisp", "arm", "nsrd"])
def test_clips_of_one_frame_are_read_without_a_check_of_motion(tmp_path, capsys, layout):
    file = make_source(tmp_path / "source", clips=2, frames=1, jittered=layout != "nsrd")
    paths = import_capture(layout, export(layout, file, tmp_path / "capture"), tmp_path / "out", scale=2)
    assert [DatasetFile(path).spec.frames for path in paths] == [1]
    assert "clips of one frame, so the motion" in capsys.readouterr().out
