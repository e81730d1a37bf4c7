"""Checkpoints that are cut short, damaged or another program's: a job goes on, and every command names the file."""

import io
import itertools
import os
import zipfile
from pathlib import Path

import pytest
import torch
from hydra.utils import instantiate

from supersampling.errors import DamagedFile, UserError
from supersampling.runs.checkpoint import load_weights, read_metadata
from supersampling.runs.checkpoint_file import WholeCheckpoints, load_checkpoint


def last(root: Path) -> Path:
    (path,) = (root / "outputs" / "checkpoints").glob("*/last.ckpt")
    return path


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """Return a database for all commands here, because creating one takes seconds, and numbers that tell jobs apart."""
    return f"sqlite:///{tmp_path_factory.mktemp('store')}/mlflow.db", itertools.count()


@pytest.fixture
def unfinished(command, data, tmp_path, monkeypatch, store):
    """Return the overrides of a job that ended after its checkpoint was written, before it was scored."""
    from supersampling.training import job

    def stop(*arguments):
        raise UserError("stopped")

    uri, numbers = store
    monkeypatch.setenv("MLFLOW_TRACKING_URI", uri)
    overrides = [*data, "model=dlctus", "budget.epochs=1", "budget.steps=2", f"seed={next(numbers)}"]
    with monkeypatch.context() as patch:
        patch.setattr(job, "evaluate", stop)
        assert command("train", *overrides).last_line == "error: stopped"
    return overrides


@pytest.mark.parametrize("share", [0.0, 0.5])
def test_job_goes_on_after_its_checkpoint_was_cut_short(share, unfinished, command, tmp_path, row):
    path = last(tmp_path)
    os.truncate(path, int(path.stat().st_size * share))
    content = path.read_bytes()
    answer = command("train", *unfinished)
    assert answer.status == 0, answer.text
    sentence = next(line for line in answer.text.splitlines() if "last.ckpt.broken" in line)
    assert sentence.startswith(f"{path} is ")
    assert sentence.endswith("it is now last.ckpt.broken, and the training begins anew.")
    assert path.with_name("last.ckpt.broken").read_bytes() == content
    assert load_checkpoint(path)["epoch"] == 0
    row("9", f"last.ckpt cut to {share:.0%}", sentence)


def test_checkpoint_of_another_model_or_program_is_refused(unfinished, command, tmp_path):
    path = last(tmp_path)
    content = torch.load(path, weights_only=True)
    name = next(iter(content["state_dict"]))
    torch.save({**content, "state_dict": {**content["state_dict"], name: torch.zeros(1)}}, path)
    answer = command("train", *unfinished)
    assert answer.status == 2
    assert f"{path} holds the weights of another model ({name} is [1] instead of" in answer.last_line
    torch.save({"state_dict": content["state_dict"]}, path)
    assert "it has no epoch" in command("train", *unfinished).last_line
    torch.save(torch.nn.Linear(1, 1), path)
    answer = command("train", *unfinished)
    assert (answer.status, f"error: {path} is not a checkpoint" in answer.last_line) == (2, True)
    assert path.exists()


@pytest.fixture
def checkpoint(entry, tmp_path):
    """Return a checkpoint with random weights, and its model."""
    model = instantiate(entry("train", "scene=atrium", "model=dlctus").model)
    path = tmp_path / "some.ckpt"
    WholeCheckpoints().save_checkpoint({"state_dict": {f"model.{k}": v for k, v in model.state_dict().items()}}, path)
    return path, model


def flip(path):
    """Change a weight without the checksum, which PyTorch does not compare."""
    data = bytearray(path.read_bytes())
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        largest = max(archive.infolist(), key=lambda entry: entry.file_size)
    data[largest.header_offset + largest.file_size // 2] ^= 0x40
    path.write_bytes(data)


@pytest.mark.parametrize(
    ("change", "part"),
    [
        (lambda path: path.write_bytes(b""), "is empty"),
        (lambda path: os.truncate(path, 2), "is truncated or damaged"),
        (lambda path: os.truncate(path, path.stat().st_size - 1), "is truncated or damaged"),
        (flip, "is damaged ('archive/data/"),
    ],
)
def test_damaged_checkpoint(change, part, checkpoint):
    path, model = checkpoint
    change(path)
    for read in (read_metadata, lambda p: load_weights(model, p)):
        with pytest.raises(DamagedFile, match=r"restore it from a copy, or train again") as error:
            read(path)
        assert str(error.value).startswith(f"{path} {part}")


def test_no_checkpoint(tmp_path):
    (tmp_path / "text.ckpt").write_text("hello")
    torch.save([1, 2], tmp_path / "list.ckpt")
    torch.save({"state_dict": {"a": "b"}}, tmp_path / "values.ckpt")
    for name, part in (
        ("text.ckpt", "is not a checkpoint"),
        ("list.ckpt", "it has no state_dict"),
        ("values.ckpt", "it has no state_dict"),
        ("none.ckpt", "There is no checkpoint"),
        ("", "is a folder"),
    ):
        with pytest.raises(UserError, match=part):
            load_checkpoint(tmp_path / name)


def test_checkpoint_without_permission(checkpoint, monkeypatch):
    path, _ = checkpoint

    def fail(*arguments, **options):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "open", fail)
    with pytest.raises(UserError, match=r"No permission for .*some\.ckpt"):
        load_checkpoint(path)


def test_full_disk_leaves_the_previous_checkpoint(checkpoint, monkeypatch):
    path, _ = checkpoint
    before = path.read_bytes()

    def full(self, data):
        with self.open("wb") as file:
            file.write(data[:100])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(OSError, match="No space left"):
        WholeCheckpoints().save_checkpoint({"state_dict": {}}, path)
    assert path.read_bytes() == before
    assert [p.name for p in path.parent.iterdir() if p.suffix == ".part"] == []
