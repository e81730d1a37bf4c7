from pathlib import Path

import numpy as np
from made_runs import made_run
from PIL import Image
from supersampling.reporting.pages.overview import Method

from supersampling.reporting.figures.states import state_tables


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
    found = [Method("dlctus x4", [made_run("a")], True), Method("tus x4", [made_run("b")], True)]
    tables = state_tables(found, {"a": states}, {"a": crops, "b": crops}, out)
    assert [(table.label, table.name) for table in tables] == [("dlctus x4", "accumulation")]
    expected = [index for index in range(11) if index != 4]
    assert tables[0].scenes == [f"hall_{index}" for index in expected]

    def levels(names: list[str]) -> list[int]:
        return [int(np.asarray(Image.open(out / name))[0, 0, 0]) for name in names]

    assert levels(tables[0].targets) == expected
    assert levels(tables[0].images) == [100 + index for index in expected]
