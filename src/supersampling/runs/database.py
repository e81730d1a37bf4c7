"""The file of a local store: its creation, and which files MLflow must not open."""

import os
import shlex
import sqlite3
import tempfile
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import mlflow
from alembic.script import ScriptDirectory
from mlflow.tracking import MlflowClient

from supersampling.errors import UserError
from supersampling.runs.location import EXAMPLES, Location, uri_of_file

BUSY_SECONDS = 20.0  # how long MLflow waits for a lock
LONGEST_PATH = 511  # bytes, of SQLite
TABLES = {"alembic_version", "experiments", "runs"}
MESSAGES: dict[str, Callable[[Path], str]] = {
    "database is locked": lambda path: (
        f"{path} is locked by another process: end what has it open for writing (a training, a database browser), then "
        "run the same command again."
    ),
    "locking protocol": lambda path: (
        f"{path} cannot be locked, as on some network file systems: set tracking_uri to a file on a local disk, or to "
        "a server."
    ),
    "not a database": lambda path: (
        f"{path} is no SQLite database, or an encrypted one: set tracking_uri to another file, for example "
        f"{uri_of_file(path.with_name('runs.db'))}."
    ),
    "malformed": lambda path: (
        f"The database {path} is damaged: restore it from a backup, or copy what it still holds with "
        f"sqlite3 {shlex.quote(str(path))} .recover, and set tracking_uri to another file until then."
    ),
    "readonly": lambda path: (
        f"{path} cannot be written: allow writing to the file and to its folder, or set tracking_uri to another file."
    ),
    "unable to open": lambda path: (
        f"{path} cannot be opened: SQLite needs the permission to read and write it and its folder, and a path of at "
        f"most {LONGEST_PATH} bytes (it has {len(os.fsencode(path))})."
    ),
    "disk is full": lambda path: (
        f"The disk of {path} is full: free some space, then run the same command again; it continues from there."
    ),
    "disk I/O error": lambda path: f"The disk of {path} fails to read or write: check it, then run the command again.",
}
"""What SQLite reports, and the sentence for the user."""


def explain_sqlite(message: str, path: Path) -> str | None:
    """Return a sentence for an error of SQLite's about the file; None for an error that the user cannot correct."""
    return next((sentence(path) for part, sentence in MESSAGES.items() if part in message), None)


def check_database(location: Location, path: Path, write: bool) -> bool:
    """Return whether the file holds a store; False if there is no file, or nothing in it.

    Raises:
        UserError: the file is a folder, no database, of another program or version of MLflow, or locked; or it cannot
            be written, for ``write``.
    """
    if path.is_dir():
        raise UserError(f"tracking_uri={location} is a folder: name a file in it, {uri_of_file(path / 'mlflow.db')}.")
    if not path.exists():
        return False
    if not path.is_file():
        raise UserError(f"tracking_uri={location} is a device or the like: set it to a file, {EXAMPLES}.")
    try:
        with closing(sqlite3.connect(f"{path.as_uri()}?mode=rw", uri=True, timeout=BUSY_SECONDS)) as connection:
            tables = _names(connection, "SELECT name FROM sqlite_master WHERE type = 'table'")
            revisions = _names(connection, "SELECT version_num FROM alembic_version") if tables >= TABLES else set()
            if write:
                _try_writing(connection)
    except sqlite3.Error as error:
        sentence = explain_sqlite(str(error), path)
        if sentence is None:
            raise
        raise UserError(sentence) from error
    if tables:
        _check_tables(location, path, tables, revisions)
    return bool(tables)


def _names(connection: sqlite3.Connection, query: str) -> set[str]:
    return {str(name) for (name,) in connection.execute(query)}


def _try_writing(connection: sqlite3.Connection) -> None:
    """Begin a transaction that changes nothing, which needs the lock and the journal, and take it back."""
    connection.isolation_level = None
    (version,) = connection.execute("PRAGMA user_version").fetchone()
    connection.execute("BEGIN IMMEDIATE")
    connection.execute(f"PRAGMA user_version = {version}")
    connection.execute("ROLLBACK")


def _check_tables(location: Location, path: Path, tables: set[str], revisions: set[str]) -> None:
    """Raise `UserError` unless the tables are those of the installed MLflow: it would change any others at once."""
    if not tables >= TABLES:
        some = ", ".join(sorted(tables)[:3])
        raise UserError(
            f"{path} is a database of another program (its tables: {some}), to which MLflow would add its own: set "
            f"tracking_uri to another file, for example {uri_of_file(path.with_name('runs.db'))}."
        )
    schema = ScriptDirectory(str(Path(mlflow.__file__).parent / "store" / "db_migrations"))
    if revisions == set(schema.get_heads()):
        return
    if revisions <= {script.revision for script in schema.walk_revisions()}:
        raise UserError(upgrade_sentence(location))
    raise UserError(newer_sentence(location))


def upgrade_sentence(location: Location) -> str:
    """Return what to do about a database of an older MLflow."""
    return (
        f"The store {location} is of an older MLflow than the installed {mlflow.__version__}: make a copy of it, then "
        f"run mlflow db upgrade {shlex.quote(str(location))}."
    )


def newer_sentence(location: Location) -> str:
    """Return what to do about a database of a newer MLflow."""
    return (
        f"The store {location} is of a newer MLflow than the installed {mlflow.__version__}: run pip install --upgrade "
        f"mlflow, or set tracking_uri to another store ({EXAMPLES})."
    )


def create_database(path: Path) -> None:
    """Create a missing database beside its place, then move it there; a file that exists is left as it is.

    MLflow creates tables one by one; killed half-way, it leaves a database that it can neither use nor repair.

    Raises:
        UserError: the folder cannot be written.
    """
    if os.path.lexists(path):  # an empty file, or a link that leads nowhere yet: MLflow fills it in its place
        return
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=".new-store-") as folder:
            complete = Path(folder) / path.name
            MlflowClient(uri_of_file(complete)).search_experiments()
            _move_new(complete, path)
    except OSError as error:
        raise UserError(
            f"The store {path} cannot be created ({error.strerror or error}): set paths.root or tracking_uri to a "
            "folder that can be written."
        ) from error


def _move_new(complete: Path, path: Path) -> None:
    """Give a complete file its place, unless another process was first."""
    try:
        os.link(complete, path)
    except FileExistsError:
        pass
    except OSError:  # a file system without links
        if not os.path.lexists(path):
            os.replace(complete, path)
