from pathlib import Path

import numpy as np
from example_runs import example_run
from PIL import Image

from supersampling.reporting.figures.states import CAPTION, state_galleries
from supersampling.reporting.methods import Method
from supersampling.reporting.pages.section import Picture
from supersampling.reporting.pages.sheet import Text


def grey(path: Path, level: int) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(np.full((8, 8, 3), level, np.uint8)).save(path)


def test_each_picture_of_a_state_stands_below_its_own_target(tmp_path: Path) -> None:
    """Of ten scenes, so that 10 comes after 2; one scene lacks its picture."""
    crops, states, out = tmp_path / "crops", tmp_path / "state", tmp_path / "out"
    out.mkdir()
    for index in range(11):
        for suffix in ("", "_input", "_target"):
            grey(crops / f"{index}_hall_{index}{suffix}.png", index)
        if index != 4:
            grey(states / f"{index}_hall_{index}_accumulation.png", 100 + index)
    methods = [Method("dlctus x4", [example_run("a")], True), Method("tus x4", [example_run("b")], True)]
    (gallery,) = state_galleries(methods, {"a": states}, {"a": crops, "b": crops}, out)
    assert gallery.caption == [Text("dlctus x4: accumulation", "bold"), Text(CAPTION)]
    expected = [index for index in range(11) if index != 4]
    (row,) = gallery.rows
    scenes, targets, images = row.lines
    assert scenes == [Text(f"hall_{index}") for index in expected]

    def levels(pictures: list[Picture | Text]) -> list[int]:
        names = [item.picture for item in pictures if isinstance(item, Picture)]
        assert len(names) == len(pictures)
        return [int(np.asarray(Image.open(out / name))[0, 0, 0]) for name in names]

    assert levels(targets) == expected
    assert levels(images) == [100 + index for index in expected]


def test_several_pictures_of_a_method_are_lines_of_one_gallery(tmp_path: Path) -> None:
    crops, states, out = tmp_path / "crops", tmp_path / "state", tmp_path / "out"
    out.mkdir()
    for index in range(3):
        grey(crops / f"{index}_hall_target.png", index)
        for level, name in ((50, "mask"), (90, "candidate")):
            if (index, name) != (1, "mask"):
                grey(states / f"{index}_hall_{name}.png", level + index)
    methods = [Method("enss_m x4", [example_run("a")], True)]
    (gallery,) = state_galleries(methods, {"a": states}, {"a": crops}, out)
    assert gallery.caption == [Text("enss_m x4: candidate, mask", "bold"), Text(" (from top to bottom)" + CAPTION)]
    (row,) = gallery.rows
    shown = [[out / part.picture for part in line if isinstance(part, Picture)] for line in row.lines[1:]]
    levels = [[int(np.asarray(Image.open(path))[0, 0, 0]) for path in line] for line in shown]
    assert levels == [[0, 2], [90, 92], [50, 52]]
    assert state_galleries(methods, {}, {"a": crops}, out) == []
