"""MLflow's client for readers and writers of runs: what the store refuses, and that it fails, is told in a sentence."""

import errno
import inspect
import os
import shlex
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import Any
from urllib.request import url2pathname

import mlflow
import requests
import sqlalchemy
from alembic.util.exc import CommandError
from mlflow.entities import Experiment, LifecycleStage, Run
from mlflow.exceptions import MlflowException, RestException
from mlflow.tracking import MlflowClient
from mlflow.tracking.registry import UnsupportedModelRegistryStoreURIException
from sqlalchemy.exc import DBAPIError, NoSuchModuleError, SQLAlchemyError

from supersampling.errors import UserError, chain, first_line
from supersampling.runs.database import (
    check_database,
    create_database,
    explain_sqlite,
    newer_sentence,
    upgrade_sentence,
)
from supersampling.runs.location import EXAMPLES, VARIABLE, Location, read_location
from supersampling.runs.server import check_server, explain_request, explain_status

DENIED = (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENAMETOOLONG, errno.ENOTDIR, errno.EISDIR, errno.ELOOP)
PACKAGES = {"psycopg2": "psycopg2-binary", "MySQLdb": "mysqlclient", "pymysql": "pymysql", "pyodbc": "pyodbc"}
"""Names of drivers in the package index, by the module that is missing."""


class Client(MlflowClient):
    """MLflow's client; a store that fails or cannot be reached is a `UserError`, other errors stay MLflow's own."""

    def __init__(self, location: Location) -> None:
        self._location = location
        super().__init__(location.uri)

    def __getattribute__(self, name: str) -> Any:
        value = super().__getattribute__(name)
        if name.startswith("_") or not inspect.ismethod(value):
            return value
        return _explaining(value, self._location)


def _explaining(method: Callable[..., Any], location: Location) -> Callable[..., Any]:
    @wraps(method)
    def call(*args: Any, **kwargs: Any) -> Any:
        with _explained_with_files(location):
            return method(*args, **kwargs)

    return call


@contextmanager
def explained(location: Location) -> Iterator[None]:
    """Turn errors of the store within into `UserError`; errors about a run, a name or an artifact pass."""
    try:
        yield
    except (MlflowException, SQLAlchemyError, CommandError, requests.RequestException) as error:
        _raise_sentence(location, error)
        raise


@contextmanager
def _explained_with_files(location: Location) -> Iterator[None]:
    """Do the same as `explained` where only the store's own files are opened."""
    try:
        with explained(location):
            yield
    except OSError as error:
        _raise_sentence(location, error)
        raise


def _raise_sentence(location: Location, error: Exception) -> None:
    sentence = next(filter(None, (_explain(location, cause) for cause in chain(error))), None)
    if sentence is not None:
        raise UserError(sentence) from error


def _explain(location: Location, error: BaseException) -> str | None:
    """Return a sentence for one of the errors that led to a failure, None for an error that is not the store's."""
    match error:
        case UserError():
            return str(error)
        case DBAPIError():
            if location.file is not None:
                return explain_sqlite(str(error.orig), location.file)
            failed = error.connection_invalidated or isinstance(error, sqlalchemy.exc.OperationalError)
            reason = first_line(error.orig or error).rstrip(".")
            return f"The database {location} fails ({reason}): check tracking_uri." if failed else None
        case CommandError():
            return newer_sentence(location)
        case MlflowException() if "out-of-date database schema" in str(error):
            return upgrade_sentence(location)
        case MlflowException() if location.is_server:
            reason = first_line(error).rstrip(".")
            answered = isinstance(error, RestException) or "failed with error code" in reason
            return explain_status(location, error.get_http_status_code(), reason) if answered else None
        case requests.RequestException() if location.is_server:
            return explain_request(location, error)
        case OSError(errno=number, filename=str(name), strerror=reason) if number in DENIED:
            return f"{name} cannot be used for the store {location} ({reason}): check paths.root and tracking_uri."
    return None


def open_client(tracking_uri: object, *, write: bool) -> tuple[Client, Location]:
    """Return a client of the store at ``tracking_uri``, and its location; a local store is created for ``write``.

    Raises:
        UserError: the setting names no store, or one that cannot be used.
    """
    location = read_location(tracking_uri)
    with _explained_with_files(location):
        if location.file is not None and not check_database(location, location.file, write):
            if not write:  # MLflow would create an empty database
                raise UserError(f"There is no MLflow store at {location.file}: train first, or set tracking_uri.")
            create_database(location.file)
        if location.is_server:
            check_server(location)
    return _connect(location), location


def _connect(location: Location) -> Client:
    try:
        with explained(location):
            if location.uri.startswith(("postgresql", "mysql", "mssql")):
                # One attempt: MLflow tries for two minutes.
                engine = sqlalchemy.create_engine(location.uri)
                engine.connect().close()
                engine.dispose()
            return Client(location)
    except UnsupportedModelRegistryStoreURIException as error:
        scheme = location.uri.partition(":")[0]
        raise UserError(
            f"tracking_uri={location} cannot hold runs, for MLflow knows no store called {scheme}: write {EXAMPLES}."
        ) from error
    except ModuleNotFoundError as error:
        name = str(error.name)
        raise UserError(
            f"tracking_uri={location} needs the package {name}: run pip install {PACKAGES.get(name, name)}."
        ) from error
    except (MlflowException, NoSuchModuleError, SQLAlchemyError, ValueError) as error:
        raise UserError(
            f"MLflow cannot open tracking_uri={location} ({first_line(error).rstrip('.')}): write {EXAMPLES}."
        ) from error


def select_store(location: Location) -> None:
    """Make MLflow's functions without a client use this store."""
    if str(location) != location.uri:  # MLflow prints addresses of runs, with the password
        os.environ["MLFLOW_SUPPRESS_PRINTING_URL_TO_STDOUT"] = "true"
    variable = os.environ.get(VARIABLE)
    mlflow.set_tracking_uri(location.uri)
    # MLflow exports it as well: a later job of this process with another root would take it for the user's setting.
    if variable is None:
        os.environ.pop(VARIABLE, None)
    else:
        os.environ[VARIABLE] = variable


def find_experiment(client: Client, location: Location, name: str) -> Experiment | None:
    """Return the experiment of that name, None if there is none.

    Raises:
        UserError: it was deleted, or its files are not where it says.
    """
    try:
        experiment = client.get_experiment_by_name(name)
    except MlflowException as error:
        raise UserError(
            f"MLflow cannot open experiment_name={name} at tracking_uri={location} "
            f"({first_line(error).rstrip('.')}): check both."
        ) from error
    if experiment is None:
        return None
    if experiment.lifecycle_stage == LifecycleStage.DELETED:
        command = location.command(f"experiments restore --experiment-id {experiment.experiment_id}")
        raise UserError(
            f"The experiment {name} at {location} is deleted: restore it with {command}, or set another "
            "experiment_name."
        )
    return experiment


def check_artifacts(location: Location, experiment: Experiment, configured: Path | None = None) -> None:
    """Raise `UserError` if a local store's folder of files is gone, unless it is the ``configured`` one, which is made.

    The database holds an absolute path. MLflow would find no score, and write new ones to the former place.
    """
    uri = str(experiment.artifact_location)
    if location.file is None or not uri.startswith("file:"):
        return
    folder = Path(url2pathname(uri.removeprefix("file:").removeprefix("//")))
    if folder.exists() or (configured is not None and folder == configured.resolve()):
        return
    beside = location.file.parent / folder.name
    source = beside if beside.is_dir() else "FOLDER"
    raise UserError(
        f"The files of the experiment {experiment.name} at {location} are not in {folder}: if the project was moved, "
        f"move it back, or link it to the former place with mkdir -p {shlex.quote(str(folder.parent))} && ln -s "
        f"{shlex.quote(str(source))} {shlex.quote(str(folder))}."
    )


def find_run(client: Client, location: Location, run_id: str) -> Run:
    """Return a run that is not deleted.

    Raises:
        UserError: there is no such run, or it was deleted.
    """
    try:
        run = client.get_run(run_id)
    except MlflowException as error:
        raise UserError(f"There is no run {run_id} at {location}: see the ids in the MLflow UI.") from error
    if run.info.lifecycle_stage == LifecycleStage.DELETED:
        command = location.command(f"runs restore --run-id {run_id}")
        raise UserError(f"Run {run_id} is deleted: restore it with {command}.")
    return run
