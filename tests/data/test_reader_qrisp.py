"""QRISP's layout: the test world written and read back, and invalid captures."""

import json
import shutil
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from capture_files import PLANE, SIZE, make_source
from PIL import Image

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.exporters.exporting import export
from supersampling.data.readers.importing import import_capture
from supersampling.data.readers.qrisp import baseline_images, decode_depth
from supersampling.errors import UserError
from supersampling.evaluation.playback import read_recorded_methods
from supersampling.evaluation.protocol import Protocol
from supersampling.evaluation.result import evaluate
from supersampling.metrics.prepare import Continuous
from supersampling.metrics.selection import Metrics
from supersampling.metrics.still import PSNR

LOW = Path("TestSet/World/540p")
MOTION = LOW / "MotionVectorsMipBiasMinus1Jittered"


def test_round_trip_is_exact_except_half_float_motion(written, tmp_path, capsys):
    source, capture = written
    (path,) = import_capture("qrisp", capture, tmp_path, scale=2)
    before, after = DatasetFile(source), DatasetFile(path)
    assert after.buffers == {"color", "depth", "motion", "jitter", "target"}
    assert (after.spec.scene, after.spec.split, after.spec.clips, after.spec.frames) == ("qrisp/World", "test", 2, 5)
    assert after.spec.frame == after.spec.window == SIZE
    assert after.spec.origin.startswith("qrisp:capture:")
    for clip in range(2):
        for name in sorted(after.buffers - {"motion"}):
            np.testing.assert_array_equal(after.read(name, clip, slice(None)), before.read(name, clip, slice(None)))
        motion = before.read("motion", clip, slice(None))
        assert np.abs(after.read("motion", clip, slice(None)) - motion).max() <= np.abs(motion).max() * 2.0**-11
    assert "motion read as -xy" in capsys.readouterr().out


def test_stored_numbers_match_the_paper(written):
    """Read only with OpenEXR and Pillow: velocity is current minus previous, y up; depth is equation 4."""
    _, capture = written
    planes = OpenEXR.File(str(capture / MOTION / "0000/0003.exr"), separate_channels=True).channels()
    assert planes["R"].pixels[-1, 0] == pytest.approx(PLANE[0] / SIZE[0], rel=1e-3)  # G, R in the file: vertical first
    assert planes["G"].pixels[-1, 0] == pytest.approx(-PLANE[1] / SIZE[1], rel=1e-3)
    stored = np.asarray(Image.open(capture / LOW / "DepthMipBiasMinus1Jittered/0000/0003.png")).astype(np.float64)
    depth = sum(stored[..., k] / 255.0 ** (k + 1) for k in range(4))
    assert depth[20, 2] == pytest.approx(0.5 + 0.3 * (20.5 - 0.25) * 2 / 64, abs=1e-6)  # jitter of frame 3


def test_depth_of_four_bytes():
    bytes_ = np.array([[[0, 0, 0, 0], [255, 0, 0, 0], [127, 128, 3, 200], [255, 255, 255, 255]]], dtype=np.uint8)
    exact = 127 / 255 + 128 / 255**2 + 3 / 255**3 + 200 / 255**4
    np.testing.assert_allclose(decode_depth(bytes_)[0, :, 0], [0.0, 1.0, exact, 1.0], rtol=1e-7)


def test_still_capture_is_imported_with_a_note(tmp_path, capsys):
    capture = export("qrisp", make_source(tmp_path / "source", speed=0.0), tmp_path / "capture")
    assert len(import_capture("qrisp", capture, tmp_path / "out", scale=2)) == 1
    assert "could not be checked" in capsys.readouterr().out


def test_clips_of_unequal_length_go_to_separate_files(capture, tmp_path):
    for path in capture.rglob("0001/0004.*"):
        path.unlink()
    files = import_capture("qrisp", capture, tmp_path / "out", scale=2)
    assert sorted((DatasetFile(f).spec.clips, DatasetFile(f).spec.frames) for f in files) == [(1, 4), (1, 5)]


def one_json(capture, content):
    """Camera data as one JSON for the segment instead of one for each frame."""
    for segment in ("0000", "0001"):
        folder = capture / LOW / "CameraData" / segment
        offsets = [json.loads(p.read_text()) for p in sorted(folder.iterdir())]
        shutil.rmtree(folder)
        folder.with_suffix(".json").write_text(json.dumps(content(offsets)))


@pytest.mark.parametrize(
    "content",
    [
        lambda offsets: offsets,
        lambda offsets: {"fov": 60.0, "near": 0.1, "frames": offsets},
        lambda offsets: {f"{k:04d}": o for k, o in enumerate(offsets)},
    ],
)
def test_camera_data_of_segment(written, capture, tmp_path, content):
    one_json(capture, content)
    (path,) = import_capture("qrisp", capture, tmp_path / "out", scale=2)
    expected = DatasetFile(written[0]).read("jitter", 1, slice(None))
    np.testing.assert_array_equal(DatasetFile(path).read("jitter", 1, slice(None)), expected)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"scale": 5}, "scale of 5"),
        ({"scale": 4}, "no clips in the layout"),
        ({"convention": "xx"}, "'xx'"),
        ({"layout": "unreal"}, "layout unreal"),
        ({"path": Path("nowhere")}, "folder nowhere not found"),
    ],
)
def test_wrong_requests(written, tmp_path, change, message):
    request = {"layout": "qrisp", "path": written[1], "folder": tmp_path, "scale": 2} | change
    with pytest.raises(UserError, match=message):
        import_capture(**request)


def test_segment_without_colour_is_an_error(capture, tmp_path):
    shutil.rmtree(capture / LOW / "MipBiasMinus1Jittered/0001")
    with pytest.raises(UserError, match="MipBiasMinus1Jittered/0001 has no frames"):
        import_capture("qrisp", capture, tmp_path / "out", scale=2)


def test_baselines_by_method_and_segment(capture):
    for method in ("DLSS2.2", "FSR1.2", "Native"):
        shutil.copytree(capture / "TestSet/World/1080p/Enhanced", capture / f"TestSet/World/1080p/{method}")
    images = baseline_images(capture, "World")
    assert sorted(images) == ["DLSS2.2", "FSR1.2"]
    assert sorted(images["FSR1.2"]) == ["0000", "0001"]
    assert len(images["FSR1.2"]["0000"].files) == 5
    with pytest.raises(UserError, match="no images of DLSS or FSR"):
        baseline_images(capture, "Other")


def test_baselines_become_rows(capture, tmp_path):
    """FSR's images are the targets, DLSS's are black: PSNR is capped at 100 for FSR, and has a closed form for DLSS."""
    base = capture / "TestSet/World/1080p"
    for method in ("DLSS", "FSR"):
        shutil.copytree(base / "Enhanced", base / method)
    for path in (base / "DLSS").rglob("*.png"):
        Image.new("RGB", SIZE).save(path)
    (file,) = import_capture("qrisp", capture, tmp_path, scale=2)
    store = DatasetFile(file)
    methods = read_recorded_methods(capture, [file])
    scored = {
        name: evaluate(model, Metrics([PSNR()]), Protocol(Continuous()), [file]).frames
        for name, model in methods.items()
    }
    assert {name: len(frames) for name, frames in scored.items()} == {"DLSS": 2 * 5, "FSR": 2 * 5}
    assert (scored["FSR"]["psnr"] == 100.0).all()
    power = float(np.square(store.read("target", 1, slice(4, 5)), dtype=np.float64).mean())
    row = scored["DLSS"].set_index(["clip", "frame"]).loc[(1, 4)]
    assert row["psnr"] == pytest.approx(-10.0 * np.log10(power), abs=1e-3)


def test_missing_baseline_image_is_error(capture, tmp_path):
    base = capture / "TestSet/World/1080p"
    shutil.copytree(base / "Enhanced", base / "FSR")
    next((base / "FSR").rglob("*.png")).unlink()
    (file,) = import_capture("qrisp", capture, tmp_path, scale=2)
    with pytest.raises(UserError, match="4 images of FSR for the 5 frames"):
        read_recorded_methods(capture, [file])
