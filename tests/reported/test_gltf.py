"""glTF files that were drawn otherwise than they say without a word: drawn so now, or named in a warning."""

import warnings
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
import torchvision  # noqa: F401 - it loads triton's LLVM, which crashes when Mesa's, the renderer's, is there before it
from answers import Answer
from gltf_files import SQUARE_UV, Builder, front_shot

from supersampling.process import _format_warning
from supersampling.render.renderer import Renderer
from supersampling.scenes.gltf import features, load_gltf

RED = {"pbrMetallicRoughness": {"baseColorFactor": [1.0, 0.0, 0.0, 0.6], "metallicFactor": 0.0}}
BLENDING = f"a.gltf: {features.Deviation.BLENDING}."


def render(command: Callable[..., Answer], file: Builder, folder: Path) -> tuple[Answer, list[str]]:
    """Return the answer of ``render.py`` for one small frame of a file, and its warnings."""
    path = file.gltf(folder / "a.gltf")
    quick = ["splits=[test]", "data.test.frames=2", "data.test.candidates=1", "data.test.window=[16,16]"]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        answer = command(
            *("render", "data=smoke", "scene=gltf", f"path={path}", "buffers=[color]", "data.workers=1"),
            *quick,
            f"paths.root={folder}",
        )
    return answer, [str(w.message) for w in caught if w.category is UserWarning]


def test_scale_animated_to_a_negative_one(row: Callable[..., None], tmp_path: Path) -> None:
    """A square that mirrors shows its front at once before and after, and hides its back."""
    file = Builder()
    node = file.node(mesh=file.square())
    file.animate(node, "scale", [0.0, 1.0], [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]])
    shares = []
    with Renderer(load_gltf(file.glb(tmp_path / "a.glb")), 64) as renderer:
        for seconds in (0.1, 0.9):
            still = front_shot(3.0, 64, 48)
            shot = type(still)(still.camera, still.camera, seconds, seconds, still.window)
            depth = renderer.low(shot, 1, (0.0, 0.0), 0.0, frozenset({"depth"}))["depth"]
            shares.append(float((depth < 1.0).mean()))
    assert shares[0] > 0.1
    assert shares[1] == pytest.approx(shares[0], rel=0.05)
    row("23", "a scale that is animated to a negative one", "drawn: faces are culled by the winding of each frame")


def test_nearest_sampler(command: Callable[..., Answer], row: Callable[..., None], tmp_path: Path) -> None:
    file = Builder()
    checks = np.kron(np.eye(2), np.ones((1, 1)))[..., None].repeat(3, axis=2) * 255
    info = {"index": file.texture(checks, sampler=file.add("samplers", {"magFilter": 9728, "minFilter": 9728}))}
    unlit = {"extensions": {"KHR_materials_unlit": {}}, "doubleSided": True}
    material = file.material(pbrMetallicRoughness={"baseColorTexture": info}, **unlit)
    file.node(mesh=file.square(material, TEXCOORD_0=file.accessor(SQUARE_UV)))
    answer, messages = render(command, file, tmp_path)
    assert (answer.status, messages) == (0, [])
    with Renderer(load_gltf(tmp_path / "a.gltf"), 64) as renderer:
        shot = front_shot(1.0, 32, 32, 2.0 * np.arctan(1.0))
        emission = renderer.low(shot, 1, (0.0, 0.0), 0.0, frozenset({"emission"}))["emission"][..., 0]
    np.testing.assert_array_equal(emission, np.kron(np.eye(2), np.ones((16, 16))))
    row("24", "sampler NEAREST", "drawn so, without mixing texels, and all other filters and wrappings")


def test_blending(command: Callable[..., Answer], row: Callable[..., None], tmp_path: Path) -> None:
    file = Builder()
    file.node(mesh=file.square(file.material(alphaMode="BLEND", doubleSided=True, **RED)))
    answer, messages = render(command, file, tmp_path)
    assert (answer.status, messages) == (0, [BLENDING])
    (path,) = (tmp_path / "datasets").glob("*.h5")
    with h5py.File(path) as data:
        assert data["color"].shape[0] == 1
    row("25", "BLEND", f"warning: {BLENDING}")


def test_opacity_in_vertex_colours(row: Callable[..., None], tmp_path: Path) -> None:
    """A square that is half as opaque at its right edge as a test needs ends before it."""
    file = Builder()
    opacity = file.accessor([[1.0, 1.0, 1.0, a] for a in (1.0, 0.0, 0.0, 1.0)])
    file.node(mesh=file.square(file.material(alphaMode="BLEND"), COLOR_0=opacity))
    with pytest.warns(UserWarning, match=BLENDING):
        scene = load_gltf(file.gltf(tmp_path / "a.gltf"))
    with Renderer(scene, 64) as renderer:
        shot = front_shot(1.0, 32, 32, 2.0 * np.arctan(1.0))
        depth = renderer.low(shot, 1, (0.0, 0.0), 0.0, frozenset({"depth"}))["depth"][..., 0]
    np.testing.assert_array_equal(depth < 1.0, np.tile(np.arange(32) < 16, (32, 1)))
    row("25", "alpha in vertex colours", "tested with that of factor and texture, and the same warning for BLEND")


def test_warnings_of_ours_are_plain_lines() -> None:
    assert _format_warning("a.gltf: no.", UserWarning, features.__file__, 3) == "warning: a.gltf: no.\n"
    assert "numpy" in _format_warning("no", UserWarning, np.__file__, 3)
    assert "features.py" in _format_warning("no", RuntimeWarning, features.__file__, 3)
