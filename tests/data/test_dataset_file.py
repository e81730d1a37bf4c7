import h5py
import numpy as np
import pytest

from supersampling.data.dataset_file import DatasetFile, restore
from supersampling.data.writer import quantise
from supersampling.errors import UserError


def test_crop_equals_the_same_part_of_the_whole_frame(make_file, tmp_path):
    store = DatasetFile(make_file(tmp_path, size=96))
    whole = store.read("target", 1, slice(2, 5))
    part = store.read("target", 1, slice(2, 5), (8, 20, 40, 32))
    assert part.shape == (3, 3, 32, 40)
    np.testing.assert_array_equal(part, whole[:, :, 20:52, 8:48])


def test_motion_of_crop_points_to_the_same_position(make_file, tmp_path):
    """In pixels, a crop's motion is the whole's: uv units shrink with the image."""
    store = DatasetFile(make_file(tmp_path, size=96))
    whole = store.read("motion", 0, slice(0, 1))
    part = store.read("motion", 0, slice(0, 1), (2, 3, 8, 6))
    pixels = np.array((24, 24)).reshape(2, 1, 1)
    np.testing.assert_allclose(
        part[0] * np.array((8, 6)).reshape(2, 1, 1), (whole[0] * pixels)[:, 3:9, 2:10], rtol=1e-6
    )


def test_stored_values_are_within_half_step():
    values = np.linspace(0, 1, 1001, dtype=np.float32)
    assert np.abs(restore("color", quantise("color", values)) - values).max() <= 0.5 / 255 + 1e-6


def test_equal_content_gives_equal_bytes(make_file, tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    first, second = make_file(tmp_path / "a"), make_file(tmp_path / "b")
    assert first.read_bytes() == second.read_bytes()


def test_missing_file_is_an_error(tmp_path):
    with pytest.raises(UserError, match=r"Data set .*nothing.h5 not found"):
        DatasetFile(tmp_path / "nothing.h5")


def test_truncated_file_is_an_error(make_file, tmp_path):
    path = make_file(tmp_path)
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(UserError, match="truncated"):
        DatasetFile(path)


def test_foreign_file_is_an_error(tmp_path):
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = np.zeros(3)
    with pytest.raises(UserError, match="not a data set"):
        DatasetFile(tmp_path / "other.h5")


def test_full_disk_leaves_nothing(make_file, tmp_path, monkeypatch):
    def full(*args, **kwargs):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(h5py.Group, "create_dataset", full)
    with pytest.raises(UserError, match="No space left on device"):
        make_file(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_small_window_reads_few_chunks(make_file, tmp_path):
    """A 64-pixel crop of one frame lies in at most four tiles of that frame."""
    path = make_file(tmp_path, size=192)
    with h5py.File(path) as file:
        assert file["target"].chunks[:2] == (1, 1)
        assert max(file["target"].chunks[2:4]) <= 64
