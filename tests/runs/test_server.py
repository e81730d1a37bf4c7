"""What a server that is none of MLflow's, or that refuses, is said to be."""

import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from supersampling.errors import UserError
from supersampling.runs.reach import open_client

ANSWERS = {
    "page": (200, "text/html", "<html>log in</html>"),
    "json": (200, "application/json", '{"status": "ok"}'),
    "list": (200, "application/json", "[]"),
    "missing": (404, "text/plain", "not found"),
    "forbidden": (403, "text/plain", "Invalid Host header"),
    "broken": (500, "application/json", '{"error_code": "INTERNAL_ERROR", "message": "the database is gone"}'),
    "busy": (503, "text/html", "<html>"),
    "locked": (401, "text/plain", ""),
    "moved": (302, "text/plain", ""),
}


class Handler(BaseHTTPRequestHandler):
    """Answers by the first part of the path."""

    def do_GET(self) -> None:
        status, kind, body = ANSWERS[self.path.split("/")[1]]
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        if status == 302:
            self.send_header("Location", "/json/login")
        self.end_headers()
        self.wfile.write(body.encode())

    def log_message(self, *arguments: object) -> None:
        pass


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"127.0.0.1:{server.server_port}"
        server.shutdown()


def refusal(uri: str) -> str:
    with pytest.raises(UserError) as error:
        open_client(uri, write=True)
    return str(error.value)


@pytest.mark.parametrize(
    ("path", "parts"),
    [
        ("page", ["is no MLflow server (200: a web page)", "--static-prefix"]),
        ("json", ["is no MLflow server"]),
        ("list", ["is no MLflow server"]),
        ("missing", ["is no MLflow server (404: not found)", "--static-prefix"]),
        ("forbidden", ["forbids this (403: Invalid Host header)"]),
        ("broken", ["fails (500: the database is gone)"]),
        ("busy", ["fails (503: a web page)"]),
        ("locked", ["asks for a name and password (401)"]),
        ("moved", ["redirects to", "/json/login"]),
    ],
)
def test_an_answer_that_is_no_mlflow_servers(address: str, path: str, parts: list[str]) -> None:
    sentence = refusal(f"http://{address}/{path}")
    for part in parts:
        assert part in sentence


def test_no_answer(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "(Name or service not known)" in refusal("http://no-such-host.invalid:5000")
    assert "(Connection refused)" in refusal("http://127.0.0.1:9")
    assert "The certificate or TLS" in refusal(f"https://{address}")
    monkeypatch.setenv("HTTP_PROXY", "http://127.0.0.1:9")
    assert "The proxy before" in refusal("http://mlflow.invalid:5000")
    monkeypatch.setenv("MLFLOW_TRACKING_SERVER_CERT_PATH", "/no/such/file.pem")
    assert "/no/such/file.pem" in refusal(f"https://{address}")


@pytest.mark.parametrize(
    ("uri", "part"),
    [
        ("mysql://me:secret@host/runs", "needs the package MySQLdb: run pip install mysqlclient"),
        ("postgresql+none://host/runs", "MLflow cannot open"),
        ("postgresql://host:port/runs", "MLflow cannot open"),
        ("sqlte:///mlflow.db", "knows no store called sqlte"),
        ("s3://bucket/runs", "knows no store called s3"),
    ],
)
def test_a_uri_that_cannot_hold_runs(uri: str, part: str) -> None:
    sentence = refusal(uri)
    assert part in sentence
    assert "secret" not in sentence
