"""``scripts/mask_causes.py``, which makes a table and a picture of docs/scenes.md, on leaves in closed form."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from analytic_scenes import camera
from leaf_scenes import foliage, layer
from measured_scenes import moment
from PIL import Image

from supersampling.errors import UserError
from supersampling.render.measure import probe as probe_module
from supersampling.render.measure.probe import whole

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def script(monkeypatch):
    spec = importlib.util.spec_from_file_location("mask_causes", ROOT / "scripts" / "mask_causes.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(probe_module, "FRAME", (640, 384))
    world = foliage([layer(3.0, 1.6, 0), layer(5.0, 2.7, 1)], 9.0)
    monkeypatch.setattr(module, "load_scene", lambda name: world)
    shot = moment(camera((0.041, 0.017, 0.0)), camera(), window=whole(1))
    monkeypatch.setattr(module, "seeded_shots", lambda scene, count: [shot] * count)
    return module


def test_table_and_picture(script, tmp_path, capsys):
    file = tmp_path / "causes.png"
    assert script.main(["leaves", "--shots", "1", "--picture", str(file)]) == 0
    lines = capsys.readouterr().out.splitlines()
    counts = {line.split()[0]: int(line.split()[1]) for line in lines[1:8]}
    assert list(counts) == list(script.MEANINGS) == list(script.COLOURS)
    total = int(lines[0].split()[1])
    assert sum(counts.values()) - counts["veiled"] == total
    assert counts["marked"] > total / 2 > 50
    picture = np.asarray(Image.open(file).convert("RGB"))
    assert picture.shape == (2 * 90 * 4 + 3 * 20, 2 * 160 * 4, 3)
    # The last panel shows every pixel of the mask in its colour, 4 x 4 times.
    panel = picture[2 * 20 + 90 * 4 : -20, 160 * 4 :]
    assert 0 < (panel == script.COLOURS["marked"]).all(axis=-1).sum() <= 16 * counts["marked"]


def test_crop_has_most_pixels_of_the_mask(script):
    mask = np.zeros((200, 400), bool)
    mask[5, 5] = mask[150, 300] = mask[160, 310] = True
    left, top, right, bottom = script.densest(mask)
    assert mask[top:bottom, left:right].sum() == 2
    assert (right - left, bottom - top) == script.CROP


def test_unknown_scene_is_one_sentence(script, monkeypatch, capsys):
    def fail(name: str) -> None:
        raise UserError(f"Unknown scene {name}.")

    monkeypatch.setattr(script, "load_scene", fail)
    assert script.main(["nowhere"]) == 2
    assert capsys.readouterr().err == "Unknown scene nowhere.\n"
