"""NSRD's layout: our own world written and read back, and the demodulated buffers that come of it."""

import shutil
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from capture_files import PLANE, SIZE, World, grid, make_source

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.exporters.exporting import export
from supersampling.data.exporters.images import write_exr
from supersampling.data.readers.importing import import_capture
from supersampling.data.readers.nsrd import Nsrd
from supersampling.errors import UserError


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A source file without jitter and its capture, not to be changed."""
    folder = tmp_path_factory.mktemp("nsrd")
    source = make_source(folder / "source", jittered=False, split="train")
    return source, export("nsrd", source, folder / "capture")


@pytest.fixture
def capture(written, tmp_path):
    """A copy of the capture to be changed."""
    return Path(shutil.copytree(written[1], tmp_path / "Bistro"))


def planes(path, names):
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    return np.stack([channels[c].pixels for c in names], axis=-1)


def test_round_trip(written, tmp_path):
    source, capture = written
    (path,) = import_capture("nsrd", capture, tmp_path, scale=2)
    before, after = DatasetFile(source), DatasetFile(path)
    assert (after.spec.scene, after.spec.split, after.spec.clips) == ("nsrd/capture", "train", 2)
    for clip in range(2):
        old = {name: before.read(name, clip, slice(None)) for name in before.buffers}
        new = {name: after.read(name, clip, slice(None)) for name in after.buffers}
        for name in ("depth", "motion", "motion_dual", "normal", "target"):
            np.testing.assert_array_equal(new[name], old[name])
        np.testing.assert_allclose(new["target_radiance"], old["target_radiance"], rtol=2e-3)
        emits = old["high_emission"] > 0
        np.testing.assert_array_equal(new["high_material"][~emits], old["high_material"][~emits])
        assert not new["high_material"][emits].any()
        assert not new["jitter"].any()


def test_inputs_are_the_lighting(written, tmp_path):
    """radiance / material is the world's lighting, whatever the material was."""
    (path,) = import_capture("nsrd", written[1], tmp_path, scale=2)
    store = DatasetFile(path)
    assert store.attributes["demodulated"].startswith("yes")
    assert (store.read("material", 1, slice(None)) == 1.0).all()
    assert not store.read("emission", 1, slice(None)).any()
    lit = World(*grid(SIZE[0] // 2, SIZE[1] // 2, 2.0), t=3, clip=1).lit
    radiance = store.read("radiance", 1, slice(3, 4))[0].transpose(1, 2, 0)
    np.testing.assert_allclose(radiance[12:], lit[12:], rtol=5e-3)  # the corner above emits


def test_stored_numbers_match_the_released_code(written):
    """Previous position is position - MV, y down; frames are numbered without padding."""
    _, capture = written
    motion = planes(capture / "train/X2/1/MV/4.exr", "RG")
    np.testing.assert_allclose(motion[-1, 0], PLANE / SIZE, rtol=1e-6)
    brdf, sky, light = (
        planes(capture / f"train/GT/1/{n}/4.exr", "RGB") for n in ("BRDF", "Emission_Sky", "Irradiance")
    )
    world = World(*grid(*SIZE, 1.0), t=4, clip=1)
    remodulated = np.where(sky > 1e-4, sky, brdf * light)
    np.testing.assert_allclose(remodulated, world.radiance, rtol=2e-3)


@pytest.mark.parametrize(("unit", "largest"), [(37.0, 100.0), (1000.0, 1000.0)])
def test_depth_in_unknown_unit_is_divided_by_a_power_of_ten(written, capture, tmp_path, unit, largest):
    for path in capture.rglob("Depth/*.exr"):
        write_exr(path, planes(path, "R") * np.float32(unit), "R", half=False)
    (path,) = import_capture("nsrd", capture, tmp_path / "out", scale=2)
    expected = DatasetFile(written[0]).read("depth", 1, slice(None)) * unit / largest
    np.testing.assert_allclose(DatasetFile(path).read("depth", 1, slice(None)), expected, rtol=1e-6)
    assert DatasetFile(path).attributes["depth_unit"] == f"captured depth / {largest:g}"


def test_y_up_is_error(capture, tmp_path):
    for kind in ("MV", "OCMV"):
        for path in capture.rglob(f"{kind}/*.exr"):
            write_exr(path, planes(path, "RG") * np.array((1.0, -1.0)), "RG", half=False)
    with pytest.raises(UserError, match=r"convention=-xy\."):
        import_capture("nsrd", capture, tmp_path / "wrong", scale=2)
    assert import_capture("nsrd", capture, tmp_path / "right", scale=2, convention="-xy")


def poison(path):
    image = planes(path, "RGB").copy()
    image[5, 5, 1] = np.nan
    write_exr(path, image, "RGB", half=False)


@pytest.mark.parametrize(
    ("harm", "message"),
    [
        (lambda c: poison(c / "train/X2/0/Irradiance/2.exr"), "2.exr has 1 values that are NaN or Inf"),
        (lambda c: shutil.rmtree(c / "train/GT/0/BRDF"), "BRDF has no frames"),
        (lambda c: (c / "train/GT/0/View_PNG/3.png").unlink(), "3.png is missing"),
        (lambda c: shutil.copy(c / "train/X2/0/MV/3.exr", c / "train/X2/0/MV/03.exr"), "are the same frame"),
        (lambda c: shutil.rmtree(c / "train/X2/0"), "Irradiance has no frames"),
        (lambda c: shutil.rmtree(c / "train/X2"), "no clips in the layout"),
    ],
)
def test_broken_capture_is_error(capture, tmp_path, harm, message):
    harm(capture)
    with pytest.raises(UserError, match=message):
        import_capture("nsrd", capture, tmp_path / "out", scale=2)
    assert not list((tmp_path / "out").glob("*.h5"))


@pytest.mark.parametrize(
    ("parts", "line", "absent"),
    [
        (["X2/0/OCMV", "X2/1/OCMV"], "has no OCMV: imported without motion_dual.", {"motion_dual"}),
        (["X2/0/Normal", "X2/1/Normal"], "has no Normal: imported without normal.", {"normal"}),
        (
            ["GT/0/BRDF", "GT/1/BRDF"],
            "has no GT/<folder>/{Irradiance,BRDF,Emission_Sky}: imported without high_emission, high_material, ",
            {"high_emission", "high_material", "target_radiance"},
        ),
    ],
)
def test_parts_that_no_clip_has_are_left_out(written, capture, tmp_path, capsys, parts, line, absent):
    for part in parts:
        shutil.rmtree(capture / "train" / part)
    (path,) = import_capture("nsrd", capture, tmp_path / "out", scale=2)
    assert line in capsys.readouterr().out
    assert DatasetFile(path).buffers == Nsrd.buffers - absent
    expected = DatasetFile(written[0]).read("target", 1, slice(None))
    np.testing.assert_array_equal(DatasetFile(path).read("target", 1, slice(None)), expected)


def test_infinite_depth_is_sky(written, capture, tmp_path):
    for path in capture.rglob("Depth/*.exr"):
        depth = planes(path, "R").copy()
        depth[:2] = np.inf
        OpenEXR.File({"type": OpenEXR.scanlineimage}, {"Z": depth[..., 0]}).write(str(path))
    (path,) = import_capture("nsrd", capture, tmp_path / "out", scale=2)
    depth, expected = (DatasetFile(p).read("depth", 1, slice(None)) for p in (path, written[0]))
    assert (depth[:, :, :2] == 1.0).all()
    np.testing.assert_array_equal(depth[:, :, 2:], expected[:, :, 2:])
