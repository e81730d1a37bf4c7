"""``make gl`` on machines of all kinds: stand-ins for dpkg-query and apt-get, and no other program in sight."""

import os
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "system_packages.py"
NEEDS_ROOT = (
    "Missing: libgl1. Run as root: {}apt-get update && {}apt-get install --yes --no-install-recommends libgl1\n"
)


@pytest.fixture
def programs(tmp_path, monkeypatch):
    """Put shell scripts of the given texts on an otherwise empty PATH; dpkg-query knows libegl1 only."""

    def write(**texts: str) -> Path:
        texts.setdefault("dpkg-query", '[ "$4" = libegl1 ] && echo "install ok installed"')
        texts.setdefault("apt-get", f'echo "$DEBIAN_FRONTEND $*" >> {tmp_path}/calls; echo chatter')
        for name, text in texts.items():
            (tmp_path / name).write_text(f"#!/bin/sh\n{text}\n")
            (tmp_path / name).chmod(0o755)
        monkeypatch.setenv("PATH", str(tmp_path))
        return tmp_path / "calls"

    return write


def run(monkeypatch, capfd, *packages: str, user: int = 0) -> tuple[int, str]:
    monkeypatch.setattr(os, "geteuid", lambda: user)
    status = runpy.run_path(str(SCRIPT))["main"](list(packages))
    return status, capfd.readouterr().out


def test_nothing_missing(programs, monkeypatch, capfd):
    calls = programs()
    assert run(monkeypatch, capfd, "libegl1") == (0, "")
    assert not calls.exists()


def test_root_installs_what_is_missing(programs, monkeypatch, capfd):
    calls = programs()
    status, output = run(monkeypatch, capfd, "libegl1", "libgl1")
    assert (status, output) == (0, "apt-get install --yes --no-install-recommends libgl1\n")
    update, install = calls.read_text().splitlines()
    assert (update.split()[0], update.split()[-1]) == ("noninteractive", "update")
    assert (install.split()[0], install.split()[-1]) == ("noninteractive", "libgl1")


def test_update_may_fail(programs, monkeypatch, capfd):
    programs(**{"apt-get": 'case "$*" in *update) echo "no network"; exit 100;; esac'})
    assert run(monkeypatch, capfd, "libgl1") == (0, "apt-get install --yes --no-install-recommends libgl1\n")


def test_failed_installation_shows_why(programs, monkeypatch, capfd):
    programs(**{"apt-get": 'echo "E: Unable to locate package" >&2; exit 100'})
    status, output = run(monkeypatch, capfd, "libgl1")
    assert status == 1
    assert "E: Unable to locate package" in output
    assert output.endswith("apt-get update && apt-get install --yes --no-install-recommends libgl1\n")


@pytest.mark.parametrize("sudo", [True, False])
def test_user_is_told_the_command(sudo, programs, monkeypatch, capfd):
    calls = programs(**({"sudo": ""} if sudo else {}))
    prefix = "sudo " if sudo else ""
    assert run(monkeypatch, capfd, "libgl1", user=1000) == (1, NEEDS_ROOT.format(prefix, prefix))
    assert not calls.exists()


def test_another_system(tmp_path):
    result = subprocess.run(
        [sys.executable, SCRIPT, "libgl1"], env={"PATH": str(tmp_path)}, capture_output=True, text=True
    )
    assert (result.returncode, result.stdout.count("\n")) == (0, 1)
    assert "not Debian or Ubuntu" in result.stdout
