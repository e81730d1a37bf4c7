"""Data set files that cannot be read: each cause has a sentence of its own, and none proposes to delete the file."""

import errno
import os
import pickle
import re
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
import torch
from capture_files import make_source

from supersampling.data.clips import WholeClips
from supersampling.data.content import read_text, write_text
from supersampling.data.dataset_file import DatasetFile
from supersampling.data.handles import MOST
from supersampling.errors import UserError

DESTRUCTIVE = ("delet", "remove", "rendered again")


@pytest.fixture(scope="module")
def intact(tmp_path_factory):
    """Return a data set file of the closed-form world, which is read only."""
    return make_source(tmp_path_factory.mktemp("world") / "test", split="test")


@pytest.fixture
def path(intact, tmp_path):
    """Return a copy to be broken."""
    return Path(shutil.copy(intact, tmp_path / "copy.h5"))


def test_too_many_open_files(path):
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    blockers = []
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(before[0], 256), before[1]))
        with pytest.raises(OSError, match="Too many open files"):
            blockers.extend(os.open("/dev/null", os.O_RDONLY) for _ in range(256))
        with pytest.raises(UserError, match=r"copy\.h5 cannot be opened .* raise the limit of 256 with ulimit -n"):
            DatasetFile(path)
    finally:
        for file in blockers:
            os.close(file)
        resource.setrlimit(resource.RLIMIT_NOFILE, before)


def empty(path):
    path.write_bytes(b"")


def text(path):
    path.write_text("no data")


def halve(path):
    os.truncate(path, path.stat().st_size // 2)


def foreign(path):
    with h5py.File(path, "w") as file:
        file["x"] = np.zeros(3)


def edit_spec(change):
    def edit(path):
        with h5py.File(path, "r+") as file:
            write_text(file, "spec", change(read_text(file, "spec")))

    return edit


def replace_buffer(values):
    def edit(path):
        with h5py.File(path, "r+") as file:
            del file["color"]
            file["color"] = values

    return edit


def drop_digest(path):
    with h5py.File(path, "r+") as file:
        del file["color"].attrs["digest"]


def group(path):
    with h5py.File(path, "r+") as file:
        del file["color"]
        file.create_group("color")


def edit_jitter(path):
    with h5py.File(path, "r+") as file:
        file["jitter"][0, 0, 0] += 0.125


def killed_writer(path):
    code = "import h5py, os, sys; file = h5py.File(sys.argv[1], 'r+'); os._exit(1)"
    subprocess.run([sys.executable, "-c", code, path], check=False)


@pytest.mark.parametrize(
    ("change", "part"),
    [
        (empty, "copy.h5 is empty: restore it"),
        (text, "copy.h5 is not an HDF5 file (it begins with b'no data')"),
        (halve, "copy.h5 is truncated (it has "),
        (foreign, "not a data set of schema 3 written by render.py (it has no specification)"),
        (edit_spec(lambda spec: spec.replace('"schema": 3', '"schema": 2')), "schema 2 instead of 3"),
        (edit_spec(lambda spec: spec.replace('"clips": 2', '"clips": "2"')), "specification has clips=2"),
        (edit_spec(lambda spec: spec.replace('"clips": 2', '"clips": 3')), "instead of (3, 5, 32, 48, 3) and uint8"),
        (edit_spec(lambda spec: spec.replace('"seed": 0', '"seed": 1')), "attributes that are not those"),
        (edit_spec(lambda spec: spec[:-9]), "specification has Expecting"),
        (replace_buffer(np.zeros((2, 5, 32, 48, 4), np.uint8)), "color of shape (2, 5, 32, 48, 4) and type uint8"),
        (replace_buffer(np.zeros((2, 5, 32, 48, 3), np.float32)), "type float32 instead of (2, 5, 32, 48, 3)"),
        (drop_digest, "no digest of color"),
        (group, "a group called color"),
        (edit_jitter, "damaged in jitter, whose values are not those that were written"),
        (killed_writer, "clear its mark with h5clear -s"),
    ],
)
def test_what_is_wrong_with_a_file(change, part, path):
    change(path)
    with pytest.raises(UserError) as error:
        DatasetFile(path).read("jitter", 0, slice(None))
    assert part in str(error.value)
    assert str(path) in str(error.value)
    assert not any(word in str(error.value) for word in DESTRUCTIVE)


def test_an_attribute_of_the_user_is_no_damage(path):
    with h5py.File(path, "r+") as file:
        file.attrs["note"] = "my best one"
    assert DatasetFile(path).attributes["note"] == "my best one"


def test_files_without_a_digest_of_attributes_are_read(path):
    with h5py.File(path, "r+") as file:
        del file.attrs["digest"]
    assert DatasetFile(path).spec.clips == 2


@pytest.mark.parametrize(
    ("code", "part"),
    [
        (errno.EACCES, "No permission for"),
        (errno.EIO, "The disk reports an error for"),
        (errno.ESTALE, "has vanished from its network file system"),
        (errno.ENOLCK, "is on a file system without locks (No locks available): set HDF5_USE_FILE_LOCKING=FALSE."),
        (errno.EOPNOTSUPP, "without locks"),
        (errno.EAGAIN, "is open for writing in another process"),
        (errno.EMFILE, "too many open files"),
    ],
)
def test_conditions_of_the_system(code, part, path, monkeypatch):
    what = "lock" if code in (errno.ENOLCK, errno.EOPNOTSUPP, errno.EAGAIN) else "open"
    message = f"Unable to synchronously open file (unable to {what} file, errno = {code})"

    def fail(*arguments, **options):
        raise OSError(code, message)

    monkeypatch.setattr(h5py, "File", fail)
    with pytest.raises(UserError) as error:
        DatasetFile(path)
    assert part in str(error.value)
    assert str(path) in str(error.value)


def test_links_and_pipes(tmp_path):
    os.symlink(tmp_path / "nowhere.h5", tmp_path / "link.h5")
    os.mkfifo(tmp_path / "pipe.h5")
    with pytest.raises(UserError, match=r"is a link to .*nowhere\.h5, which does not exist"):
        DatasetFile(tmp_path / "link.h5")
    with pytest.raises(UserError, match="is a device or a pipe"):
        DatasetFile(tmp_path / "pipe.h5")


def test_a_file_that_changes_while_it_is_open(path):
    store = DatasetFile(path)
    store.read("color", 0, slice(0, 1))
    halve(path)
    with pytest.raises(UserError, match=r"copy\.h5 was changed by another process while it was read"):
        store.read("color", 1, slice(4, 5))


def test_a_file_that_is_replaced_while_it_is_open(path, tmp_path):
    """An open file is read to its end; a closed one must have the same content when it is opened again."""
    store = DatasetFile(path)
    before = store.read("color", 1, slice(0, 5))
    os.replace(make_source(tmp_path / "else", frames=4), path)
    np.testing.assert_array_equal(store.read("color", 1, slice(0, 5)), before)
    store.close()
    with pytest.raises(UserError, match="was changed by another process"):
        store.read("color", 1, slice(0, 4))
    path.unlink()
    with pytest.raises(UserError, match=r"copy\.h5 not found"):
        store.read("color", 1, slice(0, 4))


def test_an_open_file_can_be_sent_to_another_process(path):
    store = DatasetFile(path)
    copy = pickle.loads(pickle.dumps(store))
    np.testing.assert_array_equal(copy.read("color", 1, slice(None)), store.read("color", 1, slice(None)))


def test_missing_buffer_is_named(path):
    with pytest.raises(UserError, match=r"copy\.h5 has no albedo: render or import it with buffers=\[albedo\]"):
        DatasetFile(path).read("albedo", 0, slice(0, 1))


@pytest.mark.parametrize("joined", [False, True])
def test_a_limit_of_file_sizes_is_named(joined, intact, tmp_path):
    """One clip or the whole file is too large: in a process of its own, which must end without a crash."""
    limit = intact.stat().st_size - 1000 if joined else 20_000
    write = (
        "import resource, sys; from pathlib import Path; from capture_files import make_source;"
        f"resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit})); make_source(Path(sys.argv[1]), split='test')"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    result = subprocess.run(
        [sys.executable, "-c", write, tmp_path / "large"], env=environment, capture_output=True, text=True
    )
    assert result.returncode == 1, result.stderr
    name = "closed" if joined else "part0"
    assert re.search(rf"{name}\S*\.h5 would be larger than .* the limit of ulimit -f allows", result.stderr)
    assert "Exception ignored" not in result.stderr
    assert not list((tmp_path / "large").rglob("*.tmp"))


def test_few_files_are_open_at_once(intact, tmp_path):
    paths = [Path(shutil.copy(intact, tmp_path / f"{k}.h5")) for k in range(MOST + 6)]
    before = len(os.listdir("/proc/self/fd"))
    clips = WholeClips(paths, frozenset({"color"}))
    assert len(os.listdir("/proc/self/fd")) - before <= MOST
    for k in (0, len(clips) - 1, 0):
        torch.testing.assert_close(clips[k]["color"], clips[k % 2]["color"], rtol=0, atol=0)
