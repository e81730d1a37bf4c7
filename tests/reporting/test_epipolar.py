"""The epipolar images of a report against a loop over all windows."""

from pathlib import Path

import numpy as np
from example_runs import example_run
from PIL import Image

from supersampling.reporting.figures.epipolar import WIDTH, epipolar_gallery
from supersampling.reporting.figures.pictures import magnify
from supersampling.reporting.methods import Method
from supersampling.reporting.pages.section import Picture


def write(folder: Path, scene: str, image: np.ndarray, target: np.ndarray) -> None:
    folder.mkdir(exist_ok=True)
    Image.fromarray(image).save(folder / f"0_{scene}.png")
    Image.fromarray(target).save(folder / f"0_{scene}_target.png")


def test_the_window_is_where_all_methods_together_err_most(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    target = rng.integers(60, 190, (24, 200, 3), dtype=np.uint8)
    outputs = {}
    for name in ("a", "b"):
        wrong = target.astype(int) + rng.integers(-60, 60, target.shape) * (rng.random(200) < 0.3)[:, None]
        outputs[name] = wrong.astype(np.uint8)
        write(tmp_path / name, "bar", outputs[name], target)
    methods = [Method(f"{name} x4", [example_run(name)], True) for name in outputs]
    out = tmp_path / "out"
    out.mkdir()
    gallery = epipolar_gallery(methods, {name: tmp_path / name for name in outputs}, out)
    assert gallery.heads == ["a", "b", "target"]
    assert [row.label for row in gallery.rows] == ["bar"]

    error = sum(np.abs(image.astype(float) - target).mean(axis=2) for image in outputs.values())
    sums = [error[:, x : x + WIDTH].sum() for x in range(200 - WIDTH + 1)]
    x = int(np.argmax(sums))
    (line,) = gallery.rows[0].lines
    for picture, image in zip(line, (*outputs.values(), target), strict=True):
        assert isinstance(picture, Picture)
        expected = np.asarray(magnify(image[:, x : x + WIDTH]))
        np.testing.assert_array_equal(np.asarray(Image.open(out / picture.picture)), expected)


def test_a_scene_that_a_method_lacks_or_has_in_another_size_is_left_out(tmp_path: Path) -> None:
    image = np.zeros((24, 100, 3), np.uint8)
    for name in ("a", "b"):
        write(tmp_path / name, "bar", image, image)
    write(tmp_path / "a", "arena", image, image)
    write(tmp_path / "a", "sundial", image, image)
    write(tmp_path / "b", "sundial", image[:12], image[:12])
    methods = [Method(f"{name} x4", [example_run(name)], True) for name in ("a", "b", "none")]
    out = tmp_path / "out"
    out.mkdir()
    gallery = epipolar_gallery(methods, {name: tmp_path / name for name in ("a", "b")}, out)
    assert [row.label for row in gallery.rows] == ["bar"]
    assert gallery.heads == ["a", "b", "target"]
