"""The setting ``tracking_uri``: the file of a local store, another database, or an MLflow server."""

import os
import re
import shlex
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

from sqlalchemy.engine import make_url
from sqlalchemy.exc import ArgumentError

from supersampling.errors import UserError

VARIABLE = "MLFLOW_TRACKING_URI"
EXAMPLES = "sqlite:///mlflow.db for a file, or http://HOST:5000 for a server"
FILE_STORE_VARIABLE = "MLFLOW_ALLOW_FILE_STORE"
SQLITE = ("sqlite", "sqlite+pysqlite")
SERVERS = ("http", "https")
OPTIONS = {"timeout", "isolation_level", "detect_types", "check_same_thread", "cached_statements"}
"""What SQLAlchemy reads after the question mark of a SQLite URI."""
_SCHEME = re.compile(r"[a-z][a-z0-9+.-]+")
_HOST_AND_PORT = re.compile(r"[\w.-]+:\d+(/.*)?")
_PASSWORD = re.compile(r"(?<=://)([^/@]*?):[^/@]*@")


@dataclass(frozen=True)
class Location:
    """A store of runs: the URI that MLflow opens, and the database's file if it is one. Printed without a password."""

    uri: str
    file: Path | None = None

    def __str__(self) -> str:
        return _PASSWORD.sub(r"\1:***@", self.uri)

    @property
    def is_server(self) -> bool:
        return urlsplit(self.uri).scheme in SERVERS

    @property
    def address(self) -> str:
        """The URI of a server without name and password, for links."""
        return re.sub(r"(?<=://)[^/@]*@", "", self.uri).rstrip("/")

    def command(self, arguments: str) -> str:
        """Return a command of MLflow's on this store for the user's shell."""
        return f"{VARIABLE}={shlex.quote(str(self))} mlflow {arguments}"


def uri_of_file(path: str | Path) -> str:
    """Return the URI that MLflow reads as the SQLite file ``path``, whatever characters the path has."""
    absolute = os.path.abspath(path)
    plain = f"sqlite:///{absolute}"
    if make_url(plain).database == absolute:
        return plain
    # The same driver by its full name: for sqlite:/// MLflow would create a folder of the quoted name.
    return f"sqlite+pysqlite:///{absolute.replace('%', '%25').replace('?', '%3F')}"


def configured_uri(path: str) -> str:
    """Return the variable ``MLFLOW_TRACKING_URI``; if it is not set, or empty, the URI of the file ``path``."""
    variable = os.environ.get(VARIABLE, "")
    return variable if variable.strip() else uri_of_file(path)


def read_location(setting: object) -> Location:
    """Return the location that a setting names.

    Raises:
        UserError: the setting is empty, a folder, or a URI that names no database or server.
    """
    text = "" if setting is None else str(setting)
    scheme, colon, rest = text.partition(":")
    scheme = scheme.lower().strip()
    if not text.strip():
        raise UserError(f"Invalid {_named(text)}: leave it out for the local store, or write {EXAMPLES}.")
    if _HOST_AND_PORT.fullmatch(text):
        raise UserError(f"Invalid {_named(text)}: write http://{text} for a server.")
    if scheme in SERVERS:
        return _server(text.strip())
    if scheme in SQLITE and colon:
        return _sqlite_file(text, scheme, rest)
    if scheme == "databricks":
        return Location(text)
    if scheme == "file" or not colon or not _SCHEME.fullmatch(scheme):
        return _folder(text)
    return Location(f"{scheme}:{rest}")


def _named(text: str) -> str:
    """Return ``setting=value`` without a password; the setting may be the variable."""
    return f"{VARIABLE if os.environ.get(VARIABLE) == text else 'tracking_uri'}={Location(text)}"


def _server(text: str) -> Location:
    try:
        parts = urlsplit(text)
        valid = bool(parts.hostname) and parts.port != 0
    except ValueError:  # a port that is none, half an IPv6 address
        valid = False
    if not valid or any(character.isspace() for character in text):
        raise UserError(f"Invalid {_named(text)}: write http://HOST:PORT, for example http://HOST:5000.")
    return Location(f"{parts.scheme}{text[len(parts.scheme) :]}")


def _folder(text: str) -> Location:
    """Return the location of a file store if MLflow's own variable allows them; raise `UserError` otherwise."""
    if os.environ.get(FILE_STORE_VARIABLE, "").strip().lower() in ("true", "1"):
        return Location(text)
    path = Path(re.sub(r"^file:(//(localhost)?(?=/))?", "", text, flags=re.IGNORECASE))
    if _is_a(path.is_file) or path.suffix in (".db", ".sqlite", ".sqlite3"):
        raise UserError(f"Invalid {_named(text)}: write {uri_of_file(path)} for the database {path}.")
    sentence = f"{_named(text)} is a folder, which MLflow has given up as a store: write {EXAMPLES}"
    if not _is_a(path.is_dir):
        raise UserError(f"{sentence}.")
    target = f"{path}.db"
    while _is_a(Path(target).exists):
        target = f"{target.removesuffix('.db')}_2.db"
    raise UserError(
        f"{sentence}; to keep the runs of the folder, first copy them into a database with mlflow migrate-filestore "
        f"--source {shlex.quote(str(path))} --target {shlex.quote(f'sqlite:///{target}')}."
    )


def _is_a(test: Callable[[], bool]) -> bool:
    try:
        return test()
    except (OSError, ValueError):  # a name that no file can have
        return False


def _sqlite_file(text: str, scheme: str, rest: str) -> Location:
    if not rest.startswith("///"):
        path = rest.removeprefix("//")
        raise UserError(
            f"Invalid {_named(text)}: write sqlite:///{path or 'mlflow.db'}, with three slashes before the path "
            "(an absolute path begins with a fourth)."
        )
    literal, mark, options = rest.removeprefix("///").partition("?")
    try:
        url = make_url(f"{scheme}:{rest}")
    except (ArgumentError, ValueError) as error:
        raise UserError(f"Invalid {_named(text)} ({error}): write {EXAMPLES}.") from error
    path = url.database or ""
    if mark and not (url.query and set(url.query) <= OPTIONS):
        raise UserError(
            f"Invalid {_named(text)}: a question mark begins options, and {options or 'nothing'} is none "
            f"({', '.join(sorted(OPTIONS))}); write %3F for one in a path."
        )
    _check_path(text, literal, path)
    return Location(uri_of_file(path) + mark + options, Path(os.path.abspath(path)))


def _check_path(text: str, literal: str, path: str) -> None:
    """Raise `UserError` for a path that no file can have, that is no file, or that means another file than it seems."""
    if not path or path.startswith((":memory:", "file:")):
        raise UserError(f"{_named(text)} names no file, and the runs would be lost: write {EXAMPLES}.")
    if path.startswith("~"):
        raise UserError(
            f"{_named(text)} begins with ~, which only a shell replaces: write sqlite:///{Path.home()}{path[1:]}, "
            "or sqlite:///./~ for a folder of that name."
        )
    try:
        path.encode("utf-8")
    except UnicodeEncodeError as error:
        raise UserError(
            f"The path {path!r} of tracking_uri is not UTF-8, which MLflow needs: rename that folder, or set "
            "tracking_uri."
        ) from error
    if "\0" in path or ("\ufffd" in path and "\ufffd" not in literal):
        raise UserError(f"Invalid {_named(text)!r}: no file can have this path; write %25 for a percent sign.")
    decoded, written = Path(path), Path(literal)
    if path == literal or _is_a(decoded.exists) or not _is_a(written.parent.is_dir):
        return
    if _is_a(written.exists) or not _is_a(decoded.parent.is_dir):
        raise UserError(
            f"{_named(text)} means the file {path}, for a percent sign begins a character's number in a URI: "
            f"write {uri_of_file(literal)} for the file {literal}."
        )
