"""``show.py``: its output, and its messages for invalid settings."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from PIL import Image
from show_files import write

from supersampling.commands.show import show
from supersampling.errors import UserError

ROOT = Path(__file__).resolve().parents[2]


def run(tmp_path, *overrides):
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):
        show(compose("show", ["scene=atrium", f"paths.root={tmp_path}", f"out={tmp_path}/out", *overrides]))


def test_entry_point_writes_sheet_and_video(make_file, tmp_path):
    path = make_file(tmp_path, "test", frames=3)
    command = [sys.executable, "show.py", f"file={path}", f"out={tmp_path}/out", "clip=1"]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, env={**os.environ})
    assert (result.returncode, result.stderr) == (0, "")
    written = [Path(line) for line in result.stdout.split("\n") if line]
    assert [p.name for p in written] == [f"{path.stem}_clip1_frame2.png", f"{path.stem}_clip1.mp4"]
    assert sorted(written) == sorted((tmp_path / "out").iterdir())


def test_all_buffers_on_one_sheet(tmp_path):
    run(tmp_path, f"file={write(tmp_path)}", "video=null", "columns=8", "width=64")
    [picture] = (tmp_path / "out").iterdir()
    with Image.open(picture) as image:
        assert image.width == 8 * (64 + 12) + 12


def test_user_files_need_not_have_every_buffer(tmp_path):
    path = write(tmp_path, ("color", "target"))
    run(tmp_path, "data=files", f"data.test=[{path}]", "video=null", "frame=2")
    assert [p.name for p in (tmp_path / "out").iterdir()] == [f"{path.stem}_clip0_frame2.png"]


MISTAKES = {
    "no such clip": (["clip=2"], "clip=2: use 0 to 1"),
    "a negative clip": (["clip=-1"], "clip=-1: use 0 to 1"),
    "no such frame": (["frame=5"], "frame=5: use 0 to 4"),
    "no such buffer": (["buffers=[colour]"], "Unknown buffer colour"),
    "a buffer that is missing in the file": (["buffers=[color,depth]"], "has no depth: use some of color, target"),
    "no such format": (["video=gif"], "video=gif"),
    "no width": (["width=0"], "width=0"),
    "no video width": (["video_width=-2"], "video_width=-2"),
    "a word for a number": (["frame=last"], "frame=last"),
    "no frame rate": (["fps=0"], "fps=0"),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_mistakes(case, tmp_path):
    overrides, part = MISTAKES[case]
    with pytest.raises(UserError, match=part):
        run(tmp_path, f"file={write(tmp_path, ('color', 'target'))}", *overrides)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("overrides", "part"),
    [
        (["file=none.h5"], "Data set none.h5 not found"),
        (["split=dev"], "split=dev"),
        (["data=files"], "No test file is set"),
        (["data=files", "split=val"], "No val file is set"),
    ],
)
def test_no_file(overrides, part, tmp_path):
    with pytest.raises(UserError, match=part):
        run(tmp_path, *overrides)


def test_output_folder_that_cannot_be_created(tmp_path):
    (tmp_path / "out").write_text("not a folder")
    with pytest.raises(UserError, match="set out to another folder"):
        run(tmp_path, f"file={write(tmp_path, ('color',))}")
