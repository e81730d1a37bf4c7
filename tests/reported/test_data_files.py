"""Files that cannot be read: each cause has a sentence of its own, and no one is told to delete good data."""

import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import pytest

from supersampling.data.dataset_file import DatasetFile

HOLDER = "import h5py, sys; file = h5py.File(sys.argv[1], 'r+'); print('open', flush=True); sys.stdin.read()"
DESTRUCTIVE = ("delet", "remove", "rendered again")


def damage_chunk(path: Path, name: str, chunk: int = 0) -> None:
    """Overwrite 64 bytes in the middle of a compressed chunk."""
    with h5py.File(path) as file:
        info = file[name].id.get_chunk_info(chunk)
    with path.open("r+b") as raw:
        raw.seek(info.byte_offset + info.size // 2)
        raw.write(b"\xff" * 64)


def one_sentence(answer) -> str:
    """Return the last line of an answer with status 2, which proposes no deletion."""
    assert answer.status == 2, answer.text
    assert "Traceback" not in answer.text
    assert not any(word in answer.last_line for word in DESTRUCTIVE), answer.last_line
    return answer.last_line


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    folder = tmp_path_factory.mktemp("store")
    return [f"tracking_uri=sqlite:///{folder}/mlflow.db", f"paths.artifacts={folder}/mlartifacts"]


@pytest.fixture
def scoring(scoring, store):
    """Use one database for all commands here, because creating one takes seconds."""
    return [*scoring, *store]


@pytest.fixture
def data(data, store):
    return [*data, *store]


@pytest.fixture
def path(files, tmp_path):
    """Return a copy of the test file to be broken."""
    return Path(shutil.copy(files["test"], tmp_path / "copy.h5"))


def test_file_is_open_for_writing_elsewhere(command, scoring, path, row):
    holder = subprocess.Popen([sys.executable, "-c", HOLDER, path], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    try:
        assert holder.stdout.readline() == b"open\n"
        answer = command("evaluate", *scoring, f"data.test=[{path}]")
    finally:
        holder.communicate()
    sentence = one_sentence(answer)
    assert sentence.startswith(f"error: {path} is open for writing in another process: close it there")
    assert "HDF5_USE_FILE_LOCKING=FALSE" in sentence
    row("30", "a data set is open elsewhere", sentence)


def test_sixty_files_under_a_limit_of_64(scoring, files, tmp_path, row):
    paths = [Path(shutil.copy(files["test"], tmp_path / f"{k}.h5")) for k in range(60)]
    read = (
        "import sys; from pathlib import Path; from supersampling.data.clips import WholeClips;"
        "import resource; resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64));"
        "clips = WholeClips([Path(p) for p in sys.argv[1:]], frozenset({'color'}));"
        "print(sum(float(clips[k]['color'][0, 0, 0, 0]) for k in range(len(clips))))"
    )
    result = subprocess.run([sys.executable, "-c", read, *map(str, paths)], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    values = [DatasetFile(paths[0]).read("color", clip, slice(0, 1))[0, 0, 0, 0] for clip in range(2)]
    assert float(result.stdout) == pytest.approx(60 * sum(map(float, values)), rel=1e-6)
    row("31", "60 files, ulimit -n 64", "works: at most a quarter of the limit is open at once")


def test_folder_in_place_of_a_file(command, scoring, tmp_path, row):
    sentence = one_sentence(command("evaluate", *scoring, f"data.test=[{tmp_path}]"))
    assert sentence == f"error: {tmp_path} is a folder: name a file."
    row("32", "a folder's name where a file's belongs", sentence)


def test_damaged_chunk_in_evaluate(command, scoring, path, row):
    damage_chunk(path, "color")
    answer = command("evaluate", *scoring, f"data.test=[{path}]")
    assert answer.status == 2
    assert "copy.h5 is damaged in color of clip 0, frame 0 (" in answer.last_line
    row("14", "a damaged chunk", answer.last_line)


def test_damaged_chunk_in_show(command, path, tmp_path):
    damage_chunk(path, "color", chunk=4)
    answer = command("show", f"file={path}", f"out={tmp_path}", "video=null", "buffers=[color]")
    assert answer.status == 2
    assert "copy.h5 is damaged in color of clip 0, frame 4 (" in answer.last_line


@pytest.mark.parametrize("workers", [0, 1])
def test_damaged_chunk_in_train(workers, data, files, command, tmp_path):
    path = Path(shutil.copy(files["train"], tmp_path / "copy.h5"))
    for chunk in range(10):
        damage_chunk(path, "color", chunk)
    answer = command("train", *data, f"data.train=[{path}]", f"workers={workers}")
    assert answer.status == 2
    assert answer.last_line.startswith(f"error: {path} is damaged in color of clip 0, frame 0 (")
    assert "restore it from a copy" in answer.last_line
