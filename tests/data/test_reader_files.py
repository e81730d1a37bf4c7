"""Files and metadata of captures as archives, systems and locales leave them."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.readers.files import Root, number, read_json
from supersampling.data.readers.importing import import_capture
from supersampling.errors import UserError

LOW = Path("TestSet/World/540p")
COLOR = LOW / "MipBiasMinus1Jittered/0001"


def fill(capture):
    """Add what archives, file managers and notebooks leave behind."""
    for folder in (capture / COLOR, capture / LOW / "CameraData/0001", (capture / COLOR).parent):
        (folder / "._0001.png").write_bytes(b"\0\5\26\7")
        (folder / "._0001.json").write_bytes(b"\0\5\26\7")
        (folder / "Thumbs.db").write_bytes(b"")
        (folder / ".ipynb_checkpoints").mkdir()
        (folder / "@eaDir").mkdir()
    (capture / "__MACOSX/TestSet").mkdir(parents=True)


def shout(capture):
    for path in (capture / COLOR).iterdir():
        path.rename(path.with_suffix(".PNG"))


def pad(capture):
    for path in sorted((capture / COLOR).iterdir()):
        path.rename(path.with_stem(str(int(path.stem)).zfill(int(path.stem) + 1)))


def mark(capture):
    for path in (capture / LOW / "CameraData").rglob("*.json"):
        path.write_bytes(("\ufeff" + path.read_text().replace(",", ",\r\n")).encode())


@pytest.mark.parametrize("change", [fill, shout, pad, mark])
def test_what_changes_no_content_changes_no_value(written, capture, tmp_path, change):
    change(capture)
    (path,) = import_capture("qrisp", capture, tmp_path / "out", scale=2)
    for name in ("color", "target", "jitter"):
        expected = DatasetFile(written[0]).read(name, 1, slice(None))
        np.testing.assert_array_equal(DatasetFile(path).read(name, 1, slice(None)), expected)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"jitter_offset": {"x": "0,25", "y": 0}}', "Invalid x in .*('0,25').*: write a finite number"),
        ('{"jitter_offset": {"x": 0,25, "y": 0}}', "is not valid JSON"),
        ('{"jitter_offset": {"x": 0.25, "x": 0.5, "y": 0}}', "the key x occurs twice in an object"),
        ('{"jitter_offset": {"x": 1' + 400 * "0" + ', "y": 0}}', "Invalid x in .*: write a finite number"),
        ('{"jitter_offset": {"x": NaN, "y": 0}}', "Invalid x in .*('nan').*: write a finite number"),
        ('{"jitter_offset": {"x": true, "y": 0}}', "Invalid x in .*('True').*: write a finite number"),
        ('{"jitter_offset": {"x": 24.5, "y": 0}}', "leaves the pixel"),
    ],
)
def test_numbers_that_are_none(capture, tmp_path, text, message):
    (capture / LOW / "CameraData/0001/0002.json").write_text(text)
    with pytest.raises(UserError, match=message.replace("('", r"\('").replace("')", r"'\)")):
        import_capture("qrisp", capture, tmp_path / "out", scale=2)


def test_document_in_another_encoding_or_place(tmp_path):
    path = tmp_path / "0001.json"
    path.write_text(json.dumps({"a": 1.0}), encoding="utf-16")
    with pytest.raises(UserError, match=r"0001\.json is not valid JSON"):
        read_json(path)
    with pytest.raises(UserError, match=r"cannot be read \(Is a directory\): correct the path or its permissions"):
        read_json(tmp_path)
    assert number({"a": 3}, "a", path) == 3.0


def test_two_files_of_a_frame_are_both_named_and_neither_is_to_be_deleted(capture, tmp_path):
    shutil.copy(capture / COLOR / "0002.png", capture / COLOR / "2.PNG")
    with pytest.raises(UserError, match=r"2\.PNG and 0002\.png are the same frame: move one of them elsewhere"):
        import_capture("qrisp", capture, tmp_path / "out", scale=2)


def test_circular_link_is_an_error(tmp_path):
    (tmp_path / "a").symlink_to(tmp_path / "a")
    with pytest.raises(UserError, match="cannot be followed"):
        Root(tmp_path).inside("a")
