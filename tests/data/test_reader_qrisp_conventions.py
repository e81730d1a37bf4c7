"""QRISP captures whose vectors or depth differ from the documentation."""

import json
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from capture_files import PLANE, SIZE, make_source
from PIL import Image

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.exporters.exporting import export
from supersampling.data.exporters.images import write_exr
from supersampling.data.readers.importing import import_capture
from supersampling.errors import UserError

LOW = Path("TestSet/World/540p")
MOTION = LOW / "MotionVectorsMipBiasMinus1Jittered"


def rewrite_motion(capture, change):
    """Replace the stored channels (R, G) of every motion file by ``change`` of them."""
    for path in sorted((capture / MOTION).rglob("*.exr")):
        planes = OpenEXR.File(str(path), separate_channels=True).channels()
        r, g = change(*(planes[c].pixels.astype(np.float32) for c in "RG"))
        write_exr(path, np.stack([r, g], axis=-1), "RG")


def rewrite_cameras(capture, change):
    for path in sorted((capture / LOW / "CameraData").rglob("*.json")):
        offset = json.loads(path.read_text())["jitter_offset"]
        path.write_text(json.dumps(change(offset)))


@pytest.mark.parametrize(
    ("change", "fits"), [(lambda r, g: (g, r), "y-x"), (lambda r, g: (-r, -g), "x-y"), (lambda r, g: (r, -g), "-x-y")]
)
def test_error_names_the_fitting_convention_which_can_be_set(capture, tmp_path, change, fits):
    rewrite_motion(capture, change)
    with pytest.raises(UserError, match=f"convention={fits}\\."):
        import_capture("qrisp", capture, tmp_path / "wrong", scale=2)
    assert not (tmp_path / "wrong").exists()
    (path,) = import_capture("qrisp", capture, tmp_path / "right", scale=2, convention=fits)
    motion = DatasetFile(path).read("motion", 0, slice(3, 4))[0, :, -1, 0]
    np.testing.assert_allclose(motion, -PLANE / SIZE, rtol=1e-3)


def test_error_names_the_fitting_jitter_convention_which_can_be_set(capture, tmp_path):
    rewrite_cameras(capture, lambda o: {"jitter_offset": {"x": -o["x"], "y": -o["y"]}})
    with pytest.raises(UserError, match="jitter_convention=-xy"):
        import_capture("qrisp", capture, tmp_path / "wrong", scale=2)
    (path,) = import_capture("qrisp", capture, tmp_path / "right", scale=2, jitter_convention="-xy")
    np.testing.assert_allclose(DatasetFile(path).read("jitter", 0, slice(0, 1))[0], (0.25, -0.375))


def test_motion_in_pixels_is_error(capture, tmp_path):
    rewrite_motion(capture, lambda r, g: (r * 48, g * 32))
    with pytest.raises(UserError, match=r"\.exr has motion .* in pixels"):
        import_capture("qrisp", capture, tmp_path / "out", scale=2)


def test_motion_in_clip_space_is_an_error_and_can_be_set(capture, tmp_path):
    rewrite_motion(capture, lambda r, g: (r * 2.0, g * 2.0))
    with pytest.raises(UserError, match=r"convention=-xy\*0\.5"):
        import_capture("qrisp", capture, tmp_path / "wrong", scale=2)
    (path,) = import_capture("qrisp", capture, tmp_path / "right", scale=2, convention="-xy*0.5")
    np.testing.assert_allclose(DatasetFile(path).read("motion", 0, slice(3, 4))[0, :, -1, 0], -PLANE / SIZE, rtol=1e-3)


def test_slow_motion_in_pixels_of_the_inputs_is_error(tmp_path):
    """Below one pixel per frame, pixels look like fractions of the image."""
    capture = export("qrisp", make_source(tmp_path / "source", speed=0.25), tmp_path / "capture")
    rewrite_motion(capture, lambda r, g: (r * 48, g * 32))
    with pytest.raises(UserError, match=r"would fit in pixels of the inputs \(read as -xy\)"):
        import_capture("qrisp", capture, tmp_path / "out", scale=2)


def test_much_too_long_motion_is_an_error(capture, tmp_path):
    rewrite_motion(capture, lambda r, g: (r * 12.5, g * 12.5))  # still within the image
    with pytest.raises(UserError, match="the motion does not fit"):
        import_capture("qrisp", capture, tmp_path / "out", scale=2)


def test_unrelated_motion_is_an_error(capture, tmp_path):
    """Motion that does not belong to the images is an error, unless the user sets its convention."""
    rng = np.random.default_rng(0)
    noise = iter(rng.uniform(-0.2, 0.2, (100, 2)))
    rewrite_motion(capture, lambda r, g: tuple(np.full_like(r, v) for v in next(noise)))
    with pytest.raises(UserError, match="the motion does not fit"):
        import_capture("qrisp", capture, tmp_path / "out", scale=2)
    assert import_capture("qrisp", capture, tmp_path / "out", scale=2, convention="-xy")


def test_reversed_depth_is_an_error_and_can_be_set(written, capture, tmp_path):
    for path in sorted((capture / LOW / "DepthMipBiasMinus1Jittered").rglob("*.png")):
        Image.fromarray(255 - np.asarray(Image.open(path))).save(path)
    with pytest.raises(UserError, match="depth seems to be reversed.*reversed_depth=true"):
        import_capture("qrisp", capture, tmp_path / "out", scale=2)
    (path,) = import_capture("qrisp", capture, tmp_path / "out", scale=2, reversed_depth=True)
    expected = DatasetFile(written[0]).read("depth", 1, slice(None))
    np.testing.assert_allclose(
        DatasetFile(path).read("depth", 1, slice(None)), expected, atol=5e-3
    )  # the digits' carry is lost
