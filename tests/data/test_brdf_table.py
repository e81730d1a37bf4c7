import os
import pickle
from pathlib import Path

import numpy as np
import pytest
import torch

from supersampling.data.brdf_table import VERSION, brdf_table, cache_folder
from supersampling.ops.brdf import integrate_table

SIZE, SAMPLES = 8, 16


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty cache for each test, on disk and in memory."""
    monkeypatch.setenv("SUPERSAMPLING_CACHE", str(tmp_path / "cache"))
    brdf_table.cache_clear()
    yield tmp_path / "cache"
    brdf_table.cache_clear()


def fresh() -> torch.Tensor:
    """Return the table of a new process."""
    brdf_table.cache_clear()
    return brdf_table(SIZE, SAMPLES)


def table_file(folder: Path) -> Path:
    return folder / f"brdf_v{VERSION}_{SIZE}_{SAMPLES}.npy"


def test_computed_once_and_written(folder):
    table = brdf_table(SIZE, SAMPLES)
    assert torch.equal(table, integrate_table(SIZE, SAMPLES))
    assert table is brdf_table(SIZE, SAMPLES)
    np.testing.assert_array_equal(np.load(table_file(folder), allow_pickle=False), table.numpy())
    assert os.listdir(folder) == [table_file(folder).name]


def test_another_process_reads_the_file(folder):
    table = fresh()
    np.save(table_file(folder), table.numpy() * np.float32(0.5))
    assert torch.equal(fresh(), table * 0.5)


def test_sizes_and_samples_have_separate_files(folder):
    assert brdf_table(4, 16).shape == (2, 4, 4)
    assert not torch.equal(brdf_table(4, 8), brdf_table(4, 16))
    assert len(os.listdir(folder)) == 2


class Bomb:
    def __reduce__(self):
        return (os.mkdir, ("exploded",))


def damaged(whole: bytes, table: np.ndarray, path: Path) -> dict[str, bytes]:
    def saved(values: object) -> bytes:
        np.save(path, np.asarray(values), allow_pickle=True)
        return path.read_bytes()

    np.savez(path.with_suffix(".npz"), table)
    nan, zeros = table.copy(), table.copy()
    nan[0, 1, 1], zeros[0, 4:] = np.nan, 0.0
    return {
        "empty": b"",
        "half a magic": whole[:4],
        "half a header": whole[:70],
        "header only": whole[:128],
        "truncated": whole[:-1],
        "all zeros": bytes(len(whole)),
        "header broken": whole.replace(b"{'descr'", b"{'des{{('"),
        "header too large": whole.replace(b"(2, 8, 8)", b"(2, 8, 8000000000)".ljust(9))[: len(whole)],
        "zip": path.with_suffix(".npz").read_bytes(),
        "pickle": pickle.dumps(Bomb()),
        "objects": saved(np.array([Bomb()], dtype=object)),
        "float64": saved(table.astype(np.float64)),
        "other shape": saved(table[:, :4]),
        "NaN": saved(nan),
        "zero blocks": saved(zeros),
        "too bright": saved(table * np.float32(3.0)),
    }


def test_damaged_file_is_replaced(folder, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    table = fresh()
    whole = table_file(folder).read_bytes()
    for kind, content in damaged(whole, table.numpy(), tmp_path / "scratch.npy").items():
        assert content != whole, kind
        table_file(folder).write_bytes(content)
        assert torch.equal(fresh(), table), kind
        assert table_file(folder).read_bytes() == whole, kind
    assert not (tmp_path / "exploded").exists()
    assert os.listdir(folder) == [table_file(folder).name]


def test_folder_that_cannot_be_made(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("SUPERSAMPLING_CACHE", str(tmp_path / "file" / "cache"))
    assert torch.equal(fresh(), integrate_table(SIZE, SAMPLES))
    assert (tmp_path / "file").read_text() == "in the way"


def test_full_disk_leaves_no_file(folder, monkeypatch):
    def full(file, *_, **__):
        file.write(b"a few bytes")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "save", full)
    assert torch.equal(fresh(), integrate_table(SIZE, SAMPLES))
    assert os.listdir(folder) == []


def test_location_of_cache_folder(monkeypatch, tmp_path):
    assert cache_folder() == tmp_path / "cache"
    monkeypatch.setenv("SUPERSAMPLING_CACHE", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_folder() == tmp_path / "xdg" / "supersampling"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert cache_folder() == tmp_path / "home" / ".cache" / "supersampling"


def test_user_without_home(monkeypatch):
    def none():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("SUPERSAMPLING_CACHE")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", none)
    assert torch.equal(fresh(), integrate_table(SIZE, SAMPLES))


@pytest.mark.parametrize("from_file", [False, True])
def test_table_created_in_validation_works_in_training(from_file):
    if from_file:
        fresh()
    with torch.inference_mode():
        table = fresh()
    place = torch.zeros(1, 1, 1, 2, requires_grad=True)
    torch.nn.functional.grid_sample(table[None], place, align_corners=False).sum().backward()
    assert place.grad is not None
