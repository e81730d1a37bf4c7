"""QRISP captures with broken, missing and misplaced files."""

import json
import shutil
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.exporters.images import write_exr
from supersampling.data.readers.importing import import_capture
from supersampling.data.readers.qrisp import baseline_images
from supersampling.errors import UserError

LOW = Path("TestSet/World/540p")
MOTION = LOW / "MotionVectorsMipBiasMinus1Jittered"


def truncate(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 2 // 3])


def shrink(path):
    Image.open(path).resize((20, 20)).save(path)


def poison(path):
    planes = OpenEXR.File(str(path), separate_channels=True).channels()
    image = np.stack([planes[c].pixels for c in "RG"], axis=-1)
    image[3, 4] = np.nan
    write_exr(path, image, "RG")


def without_jitter(path):
    path.write_text(json.dumps({"near": 0.1}))


def endless(path):
    path.write_text("[" * 100_000)


@pytest.mark.parametrize(
    ("file", "harm", "message"),
    [
        (MOTION / "0001/0002.exr", truncate, "truncated"),
        (MOTION / "0001/0002.exr", Path.unlink, "0002.exr is missing"),
        (MOTION / "0001/0002.exr", poison, "NaN"),
        (LOW / "MipBiasMinus1Jittered/0001/0002.png", shrink, "20x20 pixels: .*48x32"),
        (LOW / "MipBiasMinus1Jittered/0001/0002.png", truncate, "truncated"),
        (LOW / "DepthMipBiasMinus1Jittered/0001/0002.png", lambda p: Image.open(p).convert("RGB").save(p), "RGBA"),
        (Path("TestSet/World/1080p/Enhanced/0001/0002.png"), shrink, "20x20 pixels: .*96x64"),
        (Path("TestSet/World/1080p/Enhanced/0001/0002.png"), Path.unlink, "0002.png is missing"),
        (LOW / "CameraData/0001/0002.json", without_jitter, "no jitter_offset"),
        (LOW / "CameraData/0001/0002.json", Path.unlink, "0002.json is missing"),
        (LOW / "CameraData/0001/0002.json", endless, "not valid JSON"),
    ],
)
def test_broken_file_is_named_and_nothing_is_half_written(capture, tmp_path, file, harm, message):
    harm(capture / file)
    out = tmp_path / "out"
    with pytest.raises(UserError, match=message) as caught:
        import_capture("qrisp", capture, out, scale=2)
    assert file.name in str(caught.value)
    assert not list(out.rglob("*.tmp"))
    assert not list(out.glob("*.h5"))


def test_import_continues_after_repair_of_the_file(capture, tmp_path):
    path, out = capture / MOTION / "0001/0001.exr", tmp_path / "out"
    whole = path.read_bytes()
    path.write_bytes(whole[:-30] + bytes(30))  # of the same size, so that it is the same capture
    with pytest.raises(UserError, match="0001.exr"):
        import_capture("qrisp", capture, out, scale=2)
    path.write_bytes(whole)
    (file,) = import_capture("qrisp", capture, out, scale=2)
    assert DatasetFile(file).spec.clips == 2
    assert not list(out.glob("*.clips"))


def test_links_and_parents_out_of_the_capture_are_errors(capture, tmp_path):
    inside = capture / MOTION / "0001/0002.exr"
    outside = tmp_path / "elsewhere.exr"
    shutil.move(inside, outside)
    inside.symlink_to(outside)
    with pytest.raises(UserError, match="leads out of the capture folder"):
        import_capture("qrisp", capture, tmp_path / "out", scale=2)
    with pytest.raises(UserError, match="leads out of the capture folder"):
        baseline_images(capture, "../../../etc")


def test_link_inside_the_capture_is_followed(capture, tmp_path):
    inside = capture / MOTION / "0001/0002.exr"
    shutil.move(inside, capture / "kept.exr")
    inside.symlink_to(capture / "kept.exr")
    assert import_capture("qrisp", capture, tmp_path / "out", scale=2)
