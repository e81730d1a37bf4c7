"""Arm's NSS layout: the test world written and read back, depth of every kind, and invalid captures."""

import json
import shutil
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
import torch
from capture_files import PLANE, SIZE, make_source

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.exporters.exporting import export
from supersampling.data.exporters.images import write_exr
from supersampling.data.readers.arm import INFINITE_FAR, linear_depth
from supersampling.data.readers.importing import import_capture
from supersampling.errors import UserError
from supersampling.ops.display import radiance_to_display


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A source file and its capture, not to be changed."""
    folder = tmp_path_factory.mktemp("arm")
    source = make_source(folder / "source", frames=6)
    return source, export("arm", source, folder / "capture")


@pytest.fixture
def capture(written, tmp_path):
    """A copy of the capture to be broken."""
    return Path(shutil.copytree(written[1], tmp_path / "capture"))


def edit(capture, change, sequence="0001"):
    path = capture / f"test/{sequence}.json"
    meta = json.loads(path.read_text())
    change(meta)
    path.write_text(json.dumps(meta))


def planes(path, names):
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    return np.stack([channels[c].pixels.astype(np.float32) for c in names], axis=-1)


def test_round_trip(written, tmp_path):
    source, capture = written
    (path,) = import_capture("arm", capture, tmp_path, scale=2)
    before, after = DatasetFile(source), DatasetFile(path)
    assert (after.spec.scene, after.spec.split, after.spec.clips, after.spec.frames) == ("arm/capture", "test", 2, 6)
    for clip in range(2):
        old = {name: before.read(name, clip, slice(None)) for name in before.buffers}
        new = {name: after.read(name, clip, slice(None)) for name in after.buffers}
        for name in ("radiance", "target_radiance"):
            np.testing.assert_array_equal(new[name], old[name])
        np.testing.assert_allclose(new["jitter"], old["jitter"], atol=1e-7)
        for name in ("motion", "high_motion"):
            assert np.abs(new[name] - old[name]).max() <= np.abs(old[name]).max() * 2.0**-11
        np.testing.assert_allclose(new["depth"], old["depth"], atol=2**-24 * 200 / 0.1)
        for shown, light in (("color", "radiance"), ("target", "target_radiance")):
            expected = radiance_to_display(torch.from_numpy(old[light])).numpy()
            assert np.abs(new[shown] - expected).max() <= 0.5 / 255 + 1e-6


def test_stored_numbers_match_the_specification(written):
    """Motion is current minus previous in UV, y down; jitter is normalised by the render size; depth is a D3D
    buffer."""
    _, capture = written
    motion = planes(capture / "test/x2/motion/0000/0003.exr", "RG")
    np.testing.assert_allclose(motion[-1, 0], PLANE / SIZE, rtol=1e-3)
    meta = json.loads((capture / "test/0000.json").read_text())
    assert meta["ReverseZ"] is False
    stored = meta["Frames"][1]["NormalizedPerRatioJitter"][meta["UpscalingRatiosIndices"]["x2_index"]]
    assert (stored["X"] * 48, stored["Y"] * 32) == pytest.approx((-0.4375, 0.125))
    near, far = (meta["Frames"][0][key] for key in ("CameraNearPlane", "CameraFarPlane"))
    z = near + (far - near) * (0.5 + 0.3 * (21 + 0.5 - 0.375) * 2 / 64)
    depth = planes(capture / "test/x2/depth/0000/0000.exr", "R")[21, 2, 0]
    assert depth == pytest.approx((far - near * far / z) / (far - near), abs=1e-6)


@pytest.mark.parametrize("reversed_z", [False, True])
@pytest.mark.parametrize("far", [50.0, -1.0])
def test_linear_depth_against_projection_matrix(far, reversed_z):
    near, z = 0.5, np.array([0.5, 0.75, 2.0, 10.0, 49.0])
    last = INFINITE_FAR if far == -1.0 else far
    if far == -1.0:
        a, b = 1.0, -near
    else:
        a, b = far / (far - near), -near * far / (far - near)
    stored = (a * z + b) / z  # third row of a D3D projection, divided by w
    stored = (1.0 - stored if reversed_z else stored).astype(np.float32)
    depth = linear_depth(stored, near, far, reversed_z)
    np.testing.assert_allclose(depth, (z - near) / (last - near), rtol=2e-4, atol=1e-7)
    sky = np.array([0.0 if reversed_z else 1.0], dtype=np.float32)
    assert linear_depth(sky, near, far, reversed_z) == 1.0


def reverse_depth(capture):
    for path in (capture / "test/x2/depth").rglob("*.exr"):
        write_exr(path, 1.0 - planes(path, "R"), "R", half=False)


def test_marked_reversed_depth(written, capture, tmp_path):
    reverse_depth(capture)
    for sequence in ("0000", "0001"):
        edit(capture, lambda m: m.update(ReverseZ=True), sequence)
    (path,) = import_capture("arm", capture, tmp_path / "out", scale=2)
    expected = DatasetFile(written[0]).read("depth", 0, slice(None))
    np.testing.assert_allclose(DatasetFile(path).read("depth", 0, slice(None)), expected, atol=2e-4)


def test_unmarked_reversed_depth(capture, tmp_path):
    reverse_depth(capture)
    with pytest.raises(UserError, match="depth seems to be reversed"):
        import_capture("arm", capture, tmp_path / "out", scale=2)
    assert import_capture("arm", capture, tmp_path / "out", scale=2, reversed_depth=True)


def test_sky_on_near_plane_reveals_reversed_depth_without_disocclusion(tmp_path):
    source = make_source(tmp_path / "source", speed=0.0)
    capture = export("arm", source, tmp_path / "capture")
    for path in (capture / "test/x2/depth").rglob("*.exr"):
        depth = planes(path, "R")
        depth[:3] = 1.0  # sky
        write_exr(path, 1.0 - depth, "R", half=False)
    with pytest.raises(UserError, match="exactly on the near plane"):
        import_capture("arm", capture, tmp_path / "out", scale=2)


def test_camera_cut_begins_clip(capture, written, tmp_path):
    edit(capture, lambda m: m["Frames"][2].update(CameraCut=True))
    files = import_capture("arm", capture, tmp_path / "out", scale=2)
    frames = {DatasetFile(f).spec.frames: DatasetFile(f) for f in files}
    assert sorted(frames) == [2, 4, 6]
    old = DatasetFile(written[0])
    for length, part in ((2, slice(0, 2)), (4, slice(2, 6))):
        assert frames[length].spec.clips == 1
        np.testing.assert_array_equal(frames[length].read("radiance", 0, slice(None)), old.read("radiance", 1, part))


def test_exposure_multiplies_radiance(capture, written, tmp_path):
    for sequence in ("0000", "0001"):
        edit(capture, lambda m: [f.update(Exposure=0.5) for f in m["Frames"]], sequence)
    (path,) = import_capture("arm", capture, tmp_path / "out", scale=2)
    expected = 0.5 * DatasetFile(written[0]).read("radiance", 0, slice(None))
    np.testing.assert_array_equal(DatasetFile(path).read("radiance", 0, slice(None)), expected)


def test_motion_of_opposite_sign_is_an_error(capture, tmp_path):
    for folder in ("x2/motion", "motion_gt"):
        for path in (capture / "test" / folder).rglob("*.exr"):
            write_exr(path, -planes(path, "RG"), "RG")
    with pytest.raises(UserError, match=r"convention=xy\."):
        import_capture("arm", capture, tmp_path / "wrong", scale=2)
    assert import_capture("arm", capture, tmp_path / "right", scale=2, convention="xy")


def overflow(capture):
    path = capture / "test/ground_truth/0001/0001.exr"
    image = planes(path, "RGB")
    image[0, 0, 0] = np.inf
    channels = {c: image[..., k].astype(np.float16) for k, c in enumerate("RGB")}
    OpenEXR.File({"type": OpenEXR.scanlineimage}, channels).write(str(path))


def far_out(capture):
    path = capture / "test/x2/depth/0001/0001.exr"
    write_exr(path, planes(path, "R") * 30.0, "R", half=False)


def one_channel(capture):
    path = capture / "test/x2/motion/0001/0001.exr"
    write_exr(path, planes(path, "R"), "R")


@pytest.mark.parametrize(
    ("harm", "message"),
    [
        (overflow, "0001.exr has 1 values that are NaN or Inf"),
        (far_out, "0001.exr has depths from"),
        (one_channel, "0001.exr has the channels R: export RG or XY"),
        (lambda c: (c / "test/x2/color/0001/0003.exr").unlink(), "0003.exr is missing"),
        (lambda c: edit(c, lambda m: m["Frames"].pop()), "describes 5 frames, but 6"),
        (lambda c: edit(c, lambda m: m["Frames"].reverse()), "0001.json describes frame 4 after frame 5: list every"),
        (lambda c: edit(c, lambda m: m["Frames"][3].update(CameraCut="no")), "CameraCut in .*0001.json .'no'.: write"),
        (lambda c: edit(c, lambda m: m["Frames"][3].update(Exposure=1e30)), "Exposure=1e.30 .*0001.json"),
        (lambda c: edit(c, lambda m: m["Frames"][3].update(CameraFarPlane=1e30)), "CameraFarPlane=1e.30 .*0001.json"),
        (lambda c: shutil.rmtree(c / "test/motion_gt/0001"), "motion_gt/0001 has no frames"),
        (lambda c: (c / "test/0001.json").unlink(), "0001.json is missing"),
        (lambda c: edit(c, lambda m: m.pop("ReverseZ")), "ReverseZ"),
        (lambda c: edit(c, lambda m: m["Frames"][3].pop("NormalizedPerRatioJitter")), "0001.json has no Normalized"),
        (lambda c: edit(c, lambda m: m["UpscalingRatiosIndices"].clear()), "0001.json has no Normalized"),
        (lambda c: edit(c, lambda m: m["Frames"][3].update(Exposure=0)), "Exposure=0"),
        (lambda c: edit(c, lambda m: m["Frames"][3].update(CameraNearPlane=0)), "CameraNearPlane=0 .*0001.json"),
        (lambda c: edit(c, lambda m: m["Frames"][3].update(CameraFarPlane="far")), "CameraFarPlane.*finite number"),
        (lambda c: edit(c, lambda m: m["Frames"].__setitem__(3, None)), "0001.json"),
        (
            lambda c: edit(c, lambda m: m["Frames"][3].update(NormalizedPerRatioJitter=[{"X": 0.3, "Y": 0.1}])),
            "leaves the pixel",
        ),
    ],
)
def test_broken_capture_is_error(capture, tmp_path, harm, message):
    harm(capture)
    with pytest.raises(UserError, match=message):
        import_capture("arm", capture, tmp_path / "out", scale=2)
    assert not list((tmp_path / "out").glob("*.h5"))


def test_scale_that_does_not_fit_the_images(capture, tmp_path):
    shutil.move(capture / "test/x2", capture / "test/x4")
    with pytest.raises(UserError, match=r"task\.scale"):
        import_capture("arm", capture, tmp_path, scale=4)
