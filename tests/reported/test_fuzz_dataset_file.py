"""Damaged data set files give the values that were written, or one sentence."""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from capture_files import make_source
from fuzzing import attempt, is_sentence, mutate, trials

from supersampling.data.clips import WholeClips
from supersampling.data.content import read_text, write_text
from supersampling.data.dataset_file import DatasetFile, read_spec
from supersampling.errors import UserError

NAMES = ["color", "depth", "motion", "radiance", "jitter", "target"]
REQUIRES = frozenset(NAMES)


def read_all(path: Path):
    """Return all that a command reads of a file: specification, fingerprint, attributes and whole clips."""
    spec = read_spec(path)
    file = DatasetFile(path)
    values = [file.read(name, clip, slice(None)) for name in NAMES for clip in range(file.clips)]
    clips = WholeClips([path], REQUIRES)
    values += [item.numpy() for k in range(len(clips)) for _, item in sorted(clips[k].items())]
    file.load(NAMES)
    values += [file.read("depth", clip, slice(None), (3, 2, 8, 6)) for clip in range(file.clips)]
    result = spec, file.fingerprint(NAMES), file.attributes, values
    file.close()
    return result


def edit(path: Path, rng: np.random.Generator) -> None:
    """Change an attribute or a buffer with h5py."""
    with h5py.File(path, "r+") as file:
        name = NAMES[rng.integers(len(NAMES))]
        kind = rng.integers(5)
        if kind == 0:
            key = ["spec", "conventions", "renderer", "digest"][rng.integers(4)]
            write_text(file, key, mutate(read_text(file, key).encode(), rng).decode("latin-1"))
        elif kind == 1:
            text = read_text(file[name], "digest")
            file[name].attrs["digest"] = [text[:-1], "", 7, "0" * 64, np.zeros(3)][rng.integers(5)]
        elif kind == 2:
            key = ["spec", "digest"][rng.integers(2)]
            file.attrs[key] = [1, "", "{}", "[]", np.arange(4), 2.5][rng.integers(6)]
        elif kind == 3:
            shape, dtype = list(file[name].shape), file[name].dtype
            axis = rng.integers(len(shape) + 1)
            if axis == len(shape):
                dtype = np.dtype(["int8", "float64", "S4", ">f4", ">f2"][rng.integers(5)])
            else:
                shape[axis] += int(rng.integers(-1, 3)) or 1
            digest = read_text(file[name], "digest")
            del file[name]
            write_text(file.create_dataset(name, shape, dtype), "digest", digest)
        else:
            del file[name]
            if rng.random() < 0.5:
                file[name] = h5py.SoftLink("/nowhere") if rng.random() < 0.5 else h5py.ExternalLink("x.h5", "/a")


@pytest.mark.slow
def test_fuzz_dataset_file(tmp_path):
    source = make_source(tmp_path / "source", clips=2, frames=2, names=NAMES)
    expected = read_all(source)
    content, path = source.read_bytes(), tmp_path / "mutated.h5"
    refused = read = 0

    def check() -> None:
        nonlocal refused, read
        try:
            result = read_all(path)
        except UserError as error:
            refused += is_sentence(error)
            print(error)
            return
        read += 1
        assert result[:2] == expected[:2]
        assert {**expected[2], **result[2]} == result[2]
        for first, second in zip(result[3], expected[3], strict=True):
            np.testing.assert_array_equal(first, second)

    for seed in trials():
        rng = np.random.default_rng(seed)
        kind = rng.random()
        path.unlink(missing_ok=True)  # a new file each: HDF5 shares what it knows of one that is still open
        if kind < 0.2:
            shutil.copy(source, path)
            if kind < 0.15:
                edit(path, rng)
        else:
            path.write_bytes(mutate(content, rng))
        attempt(seed, path, tmp_path / f"failure{seed}.h5", check)
    print(f"{refused} refused, {read} read")
    assert refused
    assert read
