"""Files that MLflow must not open, and those that it cannot."""

import os
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from supersampling.errors import UserError
from supersampling.runs import database as module
from supersampling.runs.location import Location, uri_of_file
from supersampling.runs.reach import open_client


def refusal(path: Path, write: bool = True) -> str:
    with pytest.raises(UserError) as error:
        open_client(uri_of_file(path), write=write)
    return str(error.value)


def test_a_locked_database(database: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "BUSY_SECONDS", 0.1)
    with closing(sqlite3.connect(database)) as connection:
        connection.execute("BEGIN EXCLUSIVE")
        assert f"{database} is locked by another process" in refusal(database)
        assert f"{database} is locked by another process" in refusal(database, write=False)
    assert open_client(uri_of_file(database), write=True)


def test_a_folder_and_a_pipe_are_no_databases(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert f"name a file in it, sqlite:///{tmp_path}/mlflow.db" in refusal(tmp_path)
    assert "is a device or the like" in refusal(tmp_path / "pipe")
    assert (tmp_path / "pipe").is_fifo()


def test_a_damaged_database_is_not_to_be_deleted(database: Path) -> None:
    content = bytearray(database.read_bytes())
    content[100:4096] = bytes(3996)  # the page of the list of tables
    database.write_bytes(content)
    sentence = refusal(database)
    assert f"The database {database} is damaged: restore it from a backup" in sentence
    assert "delete" not in sentence


def test_a_store_that_is_missing_or_empty_has_nothing_to_read(tmp_path: Path) -> None:
    assert "There is no MLflow store" in refusal(tmp_path / "none.db", write=False)
    (tmp_path / "empty.db").touch()
    assert "There is no MLflow store" in refusal(tmp_path / "empty.db", write=False)
    assert (tmp_path / "empty.db").stat().st_size == 0


def test_an_existing_file_or_link_is_never_replaced(tmp_path: Path) -> None:
    (tmp_path / "link.db").symlink_to(tmp_path / "elsewhere.db")
    (tmp_path / "empty.db").touch()
    for name in ("link.db", "empty.db"):
        module.create_database(tmp_path / name)
    assert (tmp_path / "link.db").is_symlink()
    assert (tmp_path / "empty.db").stat().st_size == 0


def test_a_folder_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    assert "cannot be" in refusal(tmp_path / "file" / "mlflow.db")
    assert "cannot be used" in refusal(tmp_path / ("y" * 300))


@pytest.mark.parametrize(
    ("message", "part"),
    [
        ("attempt to write a readonly database", "cannot be written"),
        ("unable to open database file", "at most 511 bytes"),
        ("database or disk is full", "free some space"),
        ("disk I/O error", "fails to read or write"),
        ("locking protocol", "network file systems"),
        ("file is not a database", "an encrypted one"),
    ],
)
def test_each_message_of_sqlite_becomes_a_sentence(message: str, part: str) -> None:
    sentence = module.explain_sqlite(message, Path("/data/mlflow.db"))
    assert sentence is not None
    assert part in sentence
    assert "/data/mlflow.db" in sentence


def test_an_error_of_ours_stays_one() -> None:
    assert module.explain_sqlite("no such column: x", Path("/data/mlflow.db")) is None


def test_the_upgrade_command_is_whole(database: Path) -> None:
    folder = database.parent / "a folder with a very long name, which is not cut off anywhere" / ("x" * 200)
    folder.mkdir(parents=True)
    path = database.rename(folder / "mlflow.db")
    location = Location(uri_of_file(path), path)
    assert module.upgrade_sentence(location).endswith(f"run mlflow db upgrade 'sqlite:///{path}'.")
