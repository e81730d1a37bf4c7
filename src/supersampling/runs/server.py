"""The first request to an MLflow server, and what its failures mean."""

import ssl
from typing import Any
from urllib.parse import urlsplit

import requests
from mlflow.exceptions import MlflowException
from mlflow.utils.credentials import get_default_host_creds
from mlflow.utils.rest_utils import http_request

from supersampling.errors import UserError, chain, first_line
from supersampling.runs.location import Location

ENDPOINT = "/api/2.0/mlflow/experiments/search"
ANSWER = {"experiments", "next_page_token"}
SECONDS = 20.0
ACCESS = "MLFLOW_TRACKING_USERNAME and MLFLOW_TRACKING_PASSWORD, or MLFLOW_TRACKING_TOKEN"


def check_server(location: Location) -> None:
    """Ask a server for its experiments once, as MLflow's client asks, so that its minutes of retries never start.

    Raises:
        UserError: no server answers, it refuses to, or it is no MLflow server.
    """
    try:
        # Name, password, token, certificates and plugins are those of MLflow's own requests.
        response = http_request(
            get_default_host_creds(location.uri.rstrip("/")),
            ENDPOINT,
            "GET",
            max_retries=0,
            timeout=SECONDS,
            raise_on_status=False,
            params={"max_results": 1},
        )
    except (MlflowException, OSError, ImportError, ValueError) as error:
        sentence = explain_request(location, error) or (
            f"The request to tracking_uri={location} cannot be made ({first_line(error)}): check the variables that "
            "begin with MLFLOW_TRACKING_."
        )
        raise UserError(sentence) from error
    _check_answer(location, response)


def explain_request(location: Location, error: BaseException) -> str | None:
    """Return a sentence for an error that led to no answer; None if no request was the reason."""
    causes = list(chain(error))
    # TLS and proxies first: their errors are connection errors as well.
    for cause in causes:
        if isinstance(cause, (requests.exceptions.SSLError, ssl.SSLError)):
            return (
                f"The certificate or TLS of tracking_uri={location} is refused ({_innermost(causes)}): name the "
                "authority's file in MLFLOW_TRACKING_SERVER_CERT_PATH, check https against http, or set "
                "MLFLOW_TRACKING_INSECURE_TLS=true in a network that you trust."
            )
        if isinstance(cause, requests.exceptions.ProxyError):
            return (
                f"The proxy before tracking_uri={location} fails ({_innermost(causes)}): check HTTP_PROXY and "
                "HTTPS_PROXY, or name the host in NO_PROXY."
            )
    if any(isinstance(cause, requests.exceptions.TooManyRedirects) for cause in causes):
        return f"tracking_uri={location} redirects without end: set the address that the MLflow server itself has."
    if any(isinstance(cause, requests.exceptions.Timeout) for cause in causes):
        return _no_answer(location, "it gave none in time")
    for cause in causes:
        if isinstance(cause, requests.RequestException):
            if cause.response is not None:
                return explain_status(location, cause.response.status_code, cause.response.reason)
            return _no_answer(location, _innermost(causes))
    return None


def explain_status(location: Location, status: int, reason: str) -> str | None:
    """Return a sentence for an HTTP status that refuses or fails; None for another one."""
    if status == 401:
        creds = get_default_host_creds(location.uri)
        known = creds.token or (creds.username and creds.password) or urlsplit(location.uri).password
        if known:
            return f"The server at tracking_uri={location} refuses the name, password or token (401): check {ACCESS}."
        return f"The server at tracking_uri={location} asks for a name and password (401): set {ACCESS}."
    if status == 403:
        return (
            f"The server at tracking_uri={location} forbids this (403: {reason}): ask its administrator for access, or "
            f"check {ACCESS}."
        )
    if status == 407:
        return f"The proxy before tracking_uri={location} asks for a password (407): set it in HTTPS_PROXY."
    if status == 429 or status >= 500:
        return f"The server at tracking_uri={location} fails ({status}: {reason}): see its log, or try again later."
    return None


def _check_answer(location: Location, response: requests.Response) -> None:
    """Raise `UserError` unless an MLflow server gave this answer."""
    answer = _json(response)
    reason = str((answer or {}).get("message") or _text(response))
    sentence = explain_status(location, response.status_code, reason)
    if sentence is not None:
        raise UserError(sentence)
    if response.history:  # redirected; a request that writes would lose what it writes
        target = response.url.partition("?")[0].removesuffix(ENDPOINT)
        raise UserError(
            f"tracking_uri={location} redirects to {target}, which would lose what is written: set tracking_uri to the "
            "address of the MLflow server itself, or log in if that is a login page."
        )
    if response.ok and answer is not None and answer.keys() <= ANSWER:
        return
    raise UserError(
        f"What answers at tracking_uri={location} is no MLflow server ({response.status_code}: {reason}): check host, "
        "port and path; a server that was started with --static-prefix needs that prefix at the end."
    )


def _json(response: requests.Response) -> dict[str, Any] | None:
    try:
        answer = response.json()
    except ValueError:
        return None
    return answer if isinstance(answer, dict) else None


def _text(response: requests.Response) -> str:
    kind = response.headers.get("Content-Type", "").partition(";")[0]
    if kind == "text/html":
        return "a web page"
    return " ".join(response.text.split()) or response.reason or "an empty answer"


def _no_answer(location: Location, reason: str) -> str:
    return (
        f"No MLflow server answers at tracking_uri={location} ({reason}): start it, check the address, or leave the "
        "setting out for the local store."
    )


def _innermost(causes: list[BaseException]) -> str:
    """Return the operating system's own words, which libraries wrap in theirs."""
    errors = [cause for cause in causes if isinstance(cause, OSError) and cause.strerror]
    return str(errors[-1].strerror) if errors else first_line(causes[-1])
