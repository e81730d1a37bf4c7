"""Pictures side by side: the place where runs differ, the reference, and what is downloaded for them."""

from collections.abc import Iterable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from example_runs import example_run
from PIL import Image

from supersampling.reporting.figures.pictures import magnify
from supersampling.reporting.figures.side_by_side import Scene, crop_row, epipolar_row, most_different, read_scenes
from supersampling.reporting.pages.material import Material
from supersampling.reporting.pages.section import Picture
from supersampling.reporting.pages.sheet import Text
from supersampling.runs.store import Run

RNG = np.random.default_rng(0)


def noise(side: int = 24) -> np.ndarray:
    return RNG.integers(60, 190, (side, side, 3)).astype(np.uint8)


def write(folder: Path, stem: str, **images: np.ndarray) -> None:
    folder.mkdir(exist_ok=True)
    for name, image in images.items():
        Image.fromarray(image).save(folder / f"{stem}{'' if name == 'output' else '_' + name}.png")


def load(out: Path, part: Picture | Text) -> np.ndarray:
    assert isinstance(part, Picture)
    return np.asarray(Image.open(out / part.picture))


def two_runs(folder: Path) -> dict[str, Path]:
    """Two runs that differ in rows 4 to 9 and columns 12 to 17, and err together, and more, in another corner."""
    target, low = noise(), noise()
    first = target.copy()
    first[16:, :6] = 255 - first[16:, :6]
    second = first.copy()
    second[4:10, 12:18] = second[4:10, 12:18] // 2
    for name, output in (("a", first), ("b", second)):
        write(folder / name, "0_bar", output=output, target=target, input=low)
    return {"A": folder / "a", "B": folder / "b"}


def test_the_detail_is_where_runs_differ_not_where_both_err(tmp_path: Path) -> None:
    folders = two_runs(tmp_path)
    (scene,) = read_scenes(folders, [], with_input=True)
    assert [shot.head for shot in scene.shots] == ["input", "A", "B", "target"]
    row = crop_row(scene, tmp_path, "p", with_errors=True)
    details, errors, scores = row.lines[1:]
    for part, name in zip(details, ("a/0_bar_input", "a/0_bar", "b/0_bar", "a/0_bar_target"), strict=True):
        image = np.asarray(Image.open(tmp_path / f"{name}.png"))
        np.testing.assert_array_equal(load(tmp_path, part), np.asarray(magnify(image[4:10, 12:18])))
    assert errors[0] == Text("")
    assert isinstance(errors[-1], Text)
    target = np.asarray(Image.open(tmp_path / "a/0_bar_target.png")).astype(float)
    for part, name in zip(scores[1:3], ("a", "b")):
        error = (np.asarray(Image.open(tmp_path / name / "0_bar.png")) - target) ** 2
        assert isinstance(part, Text)
        assert float(part.text) == pytest.approx(10 * np.log10(255**2 / error.mean()), abs=0.005)
    # Brighter is worse: B errs where A does not.
    a, b = (load(tmp_path, part).astype(int).sum(axis=2) for part in errors[1:3])
    factor = len(a) // 24
    assert (b - a)[4 * factor : 10 * factor, 12 * factor : 18 * factor].mean() > 0
    np.testing.assert_array_equal(a[16 * factor :], b[16 * factor :])


def test_runs_with_targets_of_their_own_stand_beside_them(tmp_path: Path) -> None:
    folders = two_runs(tmp_path)
    other = noise(12)
    write(tmp_path / "b", "0_bar", output=255 - other, target=other, input=other)
    (scene,) = read_scenes(folders, [], with_input=True)
    assert [shot.head for shot in scene.shots] == ["A", "target", "B", "target"]
    np.testing.assert_array_equal(scene.shots[3].image, other)
    row = crop_row(scene, tmp_path, "p", with_errors=False)
    error = (255.0 - 2.0 * other) ** 2
    score = row.lines[-1][2]
    assert isinstance(score, Text)
    assert float(score.text) == pytest.approx(10 * np.log10(255**2 / error.mean()), abs=0.005)
    assert [part.text for part in row.lines[-1][1::2] if isinstance(part, Text)] == ["PSNR (dB)", "PSNR (dB)"]


def test_input_that_differs_is_left_out_and_a_scene_that_a_run_lacks_too(tmp_path: Path) -> None:
    folders = two_runs(tmp_path)
    write(tmp_path / "b", "0_bar", input=noise())
    write(tmp_path / "a", "1_hall", output=noise(), target=noise(), input=noise())
    (scene,) = read_scenes(folders, [], with_input=True)
    assert [shot.head for shot in scene.shots] == ["A", "B", "target"]
    assert read_scenes(folders, ["hall"], with_input=True) == []


def test_three_scenes_that_differ_most_in_their_own_order(tmp_path: Path) -> None:
    target = noise()
    for index, change in enumerate((5, 40, 0, 20, 30)):
        for name, sign in (("a", 1), ("b", -1)):
            image = (target.astype(int) + sign * change).astype(np.uint8)
            write(tmp_path / name, f"{index}_s{index}", output=image, target=target)
    scenes = read_scenes({"A": tmp_path / "a", "B": tmp_path / "b"}, [], with_input=False)
    assert [scene.spread for scene in scenes] == pytest.approx([5, 40, 0, 20, 30])
    assert [scene.name for scene in most_different(scenes)] == ["s1", "s3", "s4"]
    alone = read_scenes({"A": tmp_path / "a"}, [], with_input=False)
    assert [scene.spread for scene in alone] == pytest.approx([5, 40, 0, 20, 30])


def test_epipolar_columns_are_where_runs_differ(tmp_path: Path) -> None:
    target = RNG.integers(60, 190, (10, 200, 3)).astype(np.uint8)
    other = target.copy()
    other[:, 100:164] = other[:, 100:164] // 2
    for name, output in (("a", target), ("b", other)):
        write(tmp_path / name, "0_bar", output=output, target=target)
    scenes: list[Scene] = read_scenes({"A": tmp_path / "a", "B": tmp_path / "b"}, [], with_input=False)
    (line,) = epipolar_row(scenes[0], tmp_path, "p").lines
    for part, image in zip(line, (target, other, target), strict=True):
        np.testing.assert_array_equal(load(tmp_path, part), np.asarray(magnify(image[:, 100:164])))


def test_folders_are_downloaded_once_and_of_one_seed_only(tmp_path: Path) -> None:
    requests: list[str] = []

    def folders(runs: Iterable[Run], name: str) -> dict[str, Path]:
        requests.extend(f"{run.id} {name}" for run in runs)
        return {run.id: tmp_path / run.id for run in runs if run.id not in ("a1", "c1")}

    store, nothing = SimpleNamespace(folders=folders), SimpleNamespace()
    fields = dict.fromkeys(("experiment", "choice"), nothing)
    material = Material(
        store=store,
        papers=[],
        methods=[],
        configurations=0,
        clips={},
        frames={},
        **fields,  # type: ignore[arg-type]
    )
    series = {label: [example_run(f"{label}{seed}") for seed in (1, 2, 3)] for label in "ab"}
    series["c"] = [example_run("c1")]
    assert material.first_folders(series, "crops") == {"a": tmp_path / "a2", "b": tmp_path / "b1"}
    assert sorted(requests) == ["a1 crops", "a2 crops", "b1 crops", "c1 crops"]
    assert material.first_folders(series, "crops") == {"a": tmp_path / "a2", "b": tmp_path / "b1"}
    assert len(requests) == 4
