"""Stores of runs that are deleted, of another version, no store at all, guarded, or in folders with odd names."""

import shutil
import sqlite3
import threading
from base64 import b64encode
from collections.abc import Callable, Iterator
from contextlib import closing
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from answers import Answer
from mlflow import MlflowClient

from supersampling.runs.location import VARIABLE, uri_of_file
from supersampling.runs.store import Store

Command = Callable[..., Answer]
Row = Callable[..., None]


@pytest.fixture(autouse=True)
def database(new_database: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the store of the test's own project, still without an experiment."""
    monkeypatch.delenv(VARIABLE, raising=False)
    return Path(shutil.copy(new_database, tmp_path / "mlflow.db"))


@pytest.fixture
def reading(tmp_path: Path) -> list[str]:
    """Return the overrides that make readers read the test's own project."""
    return [f"paths.root={tmp_path}"]


def change(database: Path, *statements: str) -> None:
    with closing(sqlite3.connect(database)) as connection, connection:
        for statement in statements:
            connection.execute(statement)


def says(answer: Answer, *parts: str) -> None:
    """Check that a command printed one sentence that holds these parts, and ended with the status of a mistake."""
    assert answer.status == 2, answer.text
    assert answer.last_line.startswith("error: ")
    assert answer.last_line.endswith(".")
    assert "Traceback" not in answer.text
    for part in parts:
        assert part in answer.last_line


def writer_and_reader(command: Command, scoring: list[str], *more: str) -> Iterator[Answer]:
    """Yield the answers of a command that writes to the store, and of one that reads it."""
    yield command("evaluate", *scoring, *more)
    yield command("report", scoring[-1], *more)


def test_a_deleted_experiment(command: Command, data: list[str], scoring: list[str], database: Path, row: Row) -> None:
    client = MlflowClient(uri_of_file(database))
    number = client.create_experiment("supersampling")
    client.delete_experiment(number)
    restore = f"{VARIABLE}={uri_of_file(database)} mlflow experiments restore --experiment-id {number}"
    root, run = scoring[-1], "run=0123456789abcdef0123456789abcdef"
    answers = (
        *writer_and_reader(command, scoring),
        command("train", *data),
        command("compare", root, "a=jau", "b=tus"),
        command("pick", root, "ms=1"),
        command("benchmark", root, "run=all", "threads=1"),
        command("stress", root, "models=[jau]", "extremes=[hdr]", "threads=1"),
        command("export", root, run, "threads=1", "out=x.onnx"),
    )
    for answer in answers:
        says(answer, "The experiment supersampling", "is deleted", restore, "experiment_name")
    for number in ("3", "3b"):
        row(number, "the experiment was deleted", "restored by the command that is printed, or another experiment_name")


@pytest.mark.parametrize(
    ("revision", "parts"),
    [
        ("0584bdc529eb", ["of an older MLflow", "mlflow db upgrade sqlite:///"]),
        ("ffffffffffff", ["of a newer MLflow", "pip install --upgrade mlflow"]),
    ],
)
def test_a_database_of_another_version(
    command: Command, scoring: list[str], database: Path, revision: str, parts: list[str], row: Row
) -> None:
    change(database, f"UPDATE alembic_version SET version_num = '{revision}'")
    before = database.read_bytes()
    for answer in writer_and_reader(command, scoring):
        says(answer, *parts, str(database))
    assert database.read_bytes() == before
    for number in ("4", "4b"):
        row(number, "database of another MLflow", "the whole upgrade command, or install a newer MLflow")


@pytest.mark.parametrize("value", ["./mlruns", "file:///srv/mlruns", "/srv/mlruns", "mlruns"])
def test_a_folder_of_runs(
    command: Command, scoring: list[str], value: str, row: Row, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, value)
    says(command("evaluate", *scoring), f"{VARIABLE}={value} is a folder", "sqlite:///mlflow.db")
    monkeypatch.delenv(VARIABLE)
    for answer in writer_and_reader(command, scoring, f"tracking_uri={value}"):
        says(answer, f"tracking_uri={value} is a folder", "sqlite:///mlflow.db")
    row("5", "a folder mlruns as store", "refused: which database to write, and how the runs are copied into it")


def test_an_empty_variable_counts_as_none(
    command: Command, reading: list[str], row: Row, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, "")
    says(command("report", *reading), "has no experiment supersampling", "mlflow.db")
    row("5", "MLFLOW_TRACKING_URI is empty", "counts as not set")


@pytest.mark.parametrize(
    ("content", "part"),
    [(b"text\n" * 300, "is no SQLite database"), (b"SQLite format 3\0" + bytes(4000), "no SQLite database")],
)
def test_a_file_that_is_no_database(
    command: Command, scoring: list[str], database: Path, content: bytes, part: str, row: Row
) -> None:
    database.write_bytes(content)
    for answer in writer_and_reader(command, scoring):
        says(answer, str(database), part)
    assert database.read_bytes() == content
    row("6", "mlflow.db is no database", "one sentence that names the file, which stays as it is")


def test_a_database_of_another_program(command: Command, scoring: list[str], database: Path, row: Row) -> None:
    database.unlink()
    change(database, "CREATE TABLE films (title TEXT)", "CREATE TABLE alembic_version (version_num TEXT)")
    before = database.read_bytes()
    for answer in writer_and_reader(command, scoring):
        says(answer, f"{database} is a database of another program", "alembic_version, films")
    assert database.read_bytes() == before
    row("6", "a database of another program", "refused: MLflow would add its tables to it")


class Guard(BaseHTTPRequestHandler):
    """An MLflow server's first answers, for those who know the password."""

    def do_GET(self) -> None:
        known = self.headers.get("Authorization") == "Basic " + b64encode(b"user:secret").decode()
        body = b'{"experiments": []}' if known else b"a password, please"
        if known and "get-by-name" in self.path:
            body = b'{"experiment": {"experiment_id": "7", "name": "supersampling", "lifecycle_stage": "deleted"}}'
        self.send_response(200 if known else 401)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    do_POST = do_GET

    def log_message(self, *arguments: object) -> None:
        pass


@pytest.fixture
def guarded() -> Iterator[str]:
    with ThreadingHTTPServer(("127.0.0.1", 0), Guard) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"127.0.0.1:{server.server_port}"
        server.shutdown()


def test_a_server_that_asks_for_a_password(
    command: Command, scoring: list[str], guarded: str, row: Row, monkeypatch: pytest.MonkeyPatch
) -> None:
    uri = f"tracking_uri=http://{guarded}"
    for answer in writer_and_reader(command, scoring, uri):
        says(answer, "asks for a name and password (401)", "MLFLOW_TRACKING_USERNAME", guarded)
    monkeypatch.setenv("MLFLOW_TRACKING_USERNAME", "user")
    monkeypatch.setenv("MLFLOW_TRACKING_PASSWORD", "wrong")
    says(command("report", uri), "refuses the name, password or token (401)")
    monkeypatch.setenv("MLFLOW_TRACKING_PASSWORD", "secret")
    for answer in writer_and_reader(command, scoring, uri):
        says(answer, "is deleted", "experiments restore --experiment-id 7")
    monkeypatch.delenv("MLFLOW_TRACKING_USERNAME")
    says(command("report", f"tracking_uri=http://user:secret@{guarded}"), "is deleted", f"http://user:***@{guarded}")
    row("7", "a server that asks for a password", "gets what MLflow's client sends; without it, asked for by name")


@pytest.mark.parametrize("name", ["a%20b", "100% é#1 (v2), x=1", "what?&'it\"s"])
def test_a_folder_with_special_characters(
    command: Command, scoring: list[str], new_database: Path, tmp_path: Path, name: str, row: Row
) -> None:
    root = tmp_path / "projects" / name
    root.mkdir(parents=True)
    shutil.copy(new_database, root / "mlflow.db")
    quoted = name.replace("'", "\\'")
    project = [*scoring[:-1], f"paths.root='{root.parent}/{quoted}'"]
    written = command("evaluate", *project)
    assert written.status == 0, written.text
    store = Store(uri_of_file(root / "mlflow.db"), tmp_path)
    (run,) = store.experiment("supersampling", ["evaluation"]).runs
    assert f"{run.metrics['test/psnr']:.4f}" in written.text
    assert run.id in store.tables([run], "frames")
    says(command("compare", project[-1], f"a={run.id[:12]}", "b=none"), "b=none")  # the first was found
    assert [path.name for path in root.parent.iterdir()] == [name]
    assert {path.name for path in root.iterdir()} >= {"mlflow.db", "mlartifacts"}
    row("8", f"a folder called {name}", "written and read again in that folder")
