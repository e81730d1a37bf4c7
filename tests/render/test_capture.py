"""Data set files of a small scene: interruptions do not change them, and their contents are consistent."""

import json
import shutil

import numpy as np
import pytest
import torch
import torch.nn.functional as F

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.spec import CaptureSpec
from supersampling.errors import UserError
from supersampling.render import capture
from supersampling.render.capture import DataFile
from supersampling.render.check import check_spec
from supersampling.render.jitter import thesis_4x4
from supersampling.render.pool import render_files
from supersampling.scenes.scene import Material, Mesh, Object, Route, Scene, Sky

USUAL = frozenset({"color", "depth", "motion", "jitter", "target"})
SPEC = CaptureSpec(
    scene="wall",
    split="train",
    clips=3,
    frames=4,
    targets=4,
    frame=(192, 108),
    window=(64, 64),
    scale=4,
    jitter="thesis",
    mip_bias="matched",
    samples=2,
    seed=0,
    candidates=2,
)


def render_file(spec: CaptureSpec, folder, scene: Scene | None = None, names: frozenset[str] = USUAL):
    return render_files([spec], folder, names, scene=scene)[0]


def quad(width: float, height: float, z: float, repeats: float, material: int) -> Mesh:
    x, y = width / 2, height / 2
    positions = np.array([(-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z)], dtype=np.float32)
    uv = np.array([(0, 1), (1, 1), (1, 0), (0, 0)], dtype=np.float32) * repeats
    normals = np.tile(np.array((0, 0, 1), dtype=np.float32), (4, 1))
    return Mesh(positions, normals, uv, np.array([(0, 1, 2), (0, 2, 3)], dtype=np.uint32), material)


def slide(seconds: float) -> np.ndarray:
    matrix = np.eye(4, dtype=np.float32)
    matrix[0, 3] = np.sin(3.0 * seconds)
    return matrix


@pytest.fixture(scope="module")
def wall() -> Scene:
    """Return a wall with a smooth pattern and a panel sliding in front of it, lit by ambient light only."""
    t = np.arange(128) / 128 * 2 * np.pi
    u, v = np.meshgrid(t, t)
    image = np.stack([127 + 60 * np.sin(2 * u + k) + 60 * np.cos(3 * v - k) for k in range(3)], axis=-1)
    materials = [
        Material("wall", albedo=image.astype(np.uint8)),
        Material("panel", albedo=image.astype(np.uint8)[::-1]),
    ]
    meshes = [quad(30, 20, -6, 6, 0), quad(1.5, 1.5, -3, 1, 1)]
    objects = [Object((0,), np.eye(4, dtype=np.float32)), Object((1,), slide)]
    focus = np.array([(0, 0, -6), (0.5, 0, -6)], np.float32)
    lines = [np.array([(-1, k * 0.1, 0), (1, k * 0.1, 0)], np.float32) for k in range(6)]
    routes = [Route(str(k), line, focus) for k, line in enumerate(lines)]
    return Scene("wall", materials, meshes, objects, routes, sun=None, sky=Sky(), attribution="none needed")


def test_interrupted_rendering_gives_the_same_bytes(wall, tmp_path, monkeypatch):
    whole = render_file(SPEC, tmp_path / "whole", wall)
    render = capture.render_clip
    calls = []

    def failing(*args):
        calls.append(1)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return render(*args)

    monkeypatch.setattr(capture, "render_clip", failing)
    with pytest.raises(KeyboardInterrupt):
        render_file(SPEC, tmp_path / "cut", wall)
    assert not list((tmp_path / "cut").glob("*.h5"))
    resumed = render_file(SPEC, tmp_path / "cut", wall)
    assert len(calls) == 2 + 2  # the finished clip was kept
    assert resumed.read_bytes() == whole.read_bytes()
    render_file(SPEC, tmp_path / "cut", wall)
    assert len(calls) == 4  # nothing is missing, so nothing is rendered
    assert [p.name for p in (tmp_path / "cut").glob("*clips*")] == []


@pytest.fixture(scope="module")
def store(wall, tmp_path_factory) -> DatasetFile:
    return DatasetFile(render_file(SPEC, tmp_path_factory.mktemp("data"), wall))


def test_attributes_of_file(store):
    attributes = store.attributes
    assert attributes["attribution"] == "none needed"
    for key in ("spec", "conventions", "renderer", "software", "tonemap", "jitter_sequence"):
        assert attributes[key]
    assert float(attributes["low_mip_bias"]) == -2.0
    jitters = {tuple(j) for j in store.read("jitter", 0, slice(None)).tolist()}
    assert jitters <= {tuple(j) for j in thesis_4x4().tolist()}


def test_file_of_the_former_jitter_order_is_not_taken_for_a_new_one(store, tmp_path):
    """A file that has today's content but says the former revision, under its former name, is left alone."""
    values = json.loads(SPEC.to_json())
    del values["jitter_revision"]
    former = CaptureSpec.from_json(json.dumps(values))
    old = tmp_path / former.file_name
    shutil.copy(store.path, old)
    file = DataFile(SPEC, tmp_path, USUAL)
    assert file.path != old
    assert file.missing() == USUAL


def warped(previous: torch.Tensor, motion: torch.Tensor) -> torch.Tensor:
    """Warp independently of the package: sample the previous image at uv + motion, in double precision."""
    height, width = previous.shape[-2:]
    motion = F.interpolate(motion.double(), size=(height, width), mode="bilinear", align_corners=False)
    y, x = torch.meshgrid(torch.arange(height) + 0.5, torch.arange(width) + 0.5, indexing="ij")
    uv = torch.stack((x / width, y / height), dim=-1)[None] + motion.permute(0, 2, 3, 1)
    return F.grid_sample(previous.double(), 2 * uv - 1, align_corners=False, padding_mode="border")


def test_warping_previous_target_by_motion(store):
    """Warping frame t - 1 onto t reduces the error of static and of moving pixels, separated by depth."""
    errors = {"static": [0.0, 0.0], "moving": [0.0, 0.0]}
    for clip in range(store.clips):
        target, motion, depth = (
            torch.from_numpy(store.read(name, clip, slice(None))) for name in ("target", "motion", "depth")
        )
        for t in range(1, SPEC.frames):
            plain = (target[t] - target[t - 1]).abs().mean(0)
            after = (target[t] - warped(target[t - 1 : t], motion[t : t + 1])[0]).abs().mean(0)
            low = depth[t : t + 1]
            near = F.interpolate(low, scale_factor=4)[0, 0] < low.max() * 0.75
            inside = F.max_pool2d((low < low.max() * 0.75).float(), 3, 1, 1)
            edge = F.interpolate(inside, scale_factor=4)[0, 0].bool() & ~near
            interior = torch.zeros_like(near)
            interior[12:-12, 12:-12] = True
            for name, mask in (("static", ~near & ~edge & interior), ("moving", near & interior)):
                errors[name][0] += float(plain[mask].sum())
                errors[name][1] += float(after[mask].sum())
    for name, (plain, after) in errors.items():
        assert plain > 0, name
        assert after < 0.5 * plain, (name, plain, after)


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ({"scale": 7}, "task.scale=7"),
        ({"split": "dev"}, "dev"),
        ({"clips": 0}, "clips=0"),
        ({"targets": 5}, "targets=5"),
        ({"window": (8, 64)}, "width 8"),
        ({"window": (64, 200)}, "height 200"),
        ({"jitter": "zigzag"}, "zigzag"),
        ({"mip_bias": "none"}, "none"),
    ],
)
def test_error_of_invalid_specification(change, part):
    from dataclasses import replace

    with pytest.raises(UserError, match=part):
        check_spec(replace(SPEC, **change))


def test_error_of_unknown_scene(tmp_path):
    from dataclasses import replace

    with pytest.raises(UserError, match="atrum"):
        render_file(replace(SPEC, scene="atrum"), tmp_path)
    assert not list(tmp_path.glob("*.h5"))
