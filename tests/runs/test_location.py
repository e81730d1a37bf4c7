"""The setting ``tracking_uri``, and the way from a path to its URI and back."""

from pathlib import Path

import pytest

from supersampling.errors import UserError
from supersampling.runs.location import VARIABLE, configured_uri, read_location, uri_of_file

NAMES = [
    "plain",
    "a b",
    "a%20b",
    "100% é#1",
    "x=1,y",
    "what?",
    "a&b;c",
    "it's",
    'a "b"',
    "back\\slash",
    "end ",
    "%",
    "%25",
]


@pytest.mark.parametrize("name", NAMES)
def test_a_path_becomes_a_uri_and_back(name: str, tmp_path: Path) -> None:
    path = tmp_path / name / "mlflow.db"
    location = read_location(uri_of_file(path))
    assert location.file == path
    assert location.uri == uri_of_file(path)


@pytest.mark.parametrize("uri", ["sqlite:///x/mlflow.db", "SQLITE:///x/mlflow.db", "sqlite:///x/mlflow.db?timeout=60"])
def test_a_relative_path_begins_at_the_working_folder(
    uri: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert read_location(uri).file == tmp_path / "x" / "mlflow.db"


@pytest.mark.parametrize(
    ("setting", "part"),
    [
        (None, "leave it out for the local store"),
        ("", "leave it out for the local store"),
        ("sqlite:mlflow.db", "write sqlite:///mlflow.db, with three slashes"),
        ("sqlite://mlflow.db", "write sqlite:///mlflow.db, with three slashes"),
        ("sqlite:/data/x.db", "write sqlite:////data/x.db, with three slashes"),
        ("sqlite://", "with three slashes"),
        ("sqlite:///", "names no file"),
        ("sqlite:///:memory:", "names no file"),
        ("sqlite:///file:x.db?mode=ro&uri=true", "a question mark begins options"),
        ("sqlite:////tmp/what?/x.db", "write %3F"),
        ("sqlite:///~/x.db", "begins with ~"),
        ("sqlite:///a%ff/x.db", "write %25"),
        ("sqlite:////tmp/\udcff/x.db", "is not UTF-8"),
        ("mlflow.db", "write sqlite:////"),
        ("localhost:5000", "write http://localhost:5000"),
        ("http://", "http://HOST:PORT"),
        ("http:/host", "http://HOST:PORT"),
        ("http://host:99999", "http://HOST:PORT"),
        ("http://two words:5000", "http://HOST:PORT"),
    ],
)
def test_a_setting_that_names_no_store(setting: str | None, part: str) -> None:
    with pytest.raises(UserError) as error:
        read_location(setting)
    assert part in str(error.value)


def test_a_folder_of_runs_is_copied_beside_what_exists(tmp_path: Path) -> None:
    (tmp_path / "my runs").mkdir()
    (tmp_path / "my runs.db").touch()
    with pytest.raises(UserError) as error:
        read_location(tmp_path / "my runs")
    assert f"--source '{tmp_path}/my runs' --target 'sqlite:///{tmp_path}/my runs_2.db'" in str(error.value)


def test_a_percent_sign_that_was_meant_as_one_is_not_read_otherwise(tmp_path: Path) -> None:
    (tmp_path / "a%20b").mkdir()
    with pytest.raises(UserError) as error:
        read_location(f"sqlite:///{tmp_path}/a%20b/mlflow.db")
    assert f"write {uri_of_file(tmp_path / 'a%20b' / 'mlflow.db')} " in str(error.value)
    (tmp_path / "a b").mkdir()
    assert read_location(f"sqlite:///{tmp_path}/a%20b/mlflow.db").file == tmp_path / "a b" / "mlflow.db"


def test_a_password_is_not_printed() -> None:
    location = read_location("http://me:secret@host:5000/mlflow/")
    assert str(location) == "http://me:***@host:5000/mlflow/"
    assert location.address == "http://host:5000/mlflow"


@pytest.mark.parametrize(("value", "counts"), [("", False), ("  ", False), ("http://host:5000", True)])
def test_an_empty_variable_counts_as_not_set(value: str, counts: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, value)
    assert configured_uri("/data/mlflow.db") == (value if counts else "sqlite:////data/mlflow.db")
