"""The release script's parts that need neither root nor a network; docs/release.md says how to run all of it."""

import os
import runpy
import shutil
import subprocess
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "clean_root.py"
README = SCRIPT.parents[1] / "README.md"


@pytest.fixture(scope="module")
def script():
    return runpy.run_path(str(SCRIPT))


def test_default_commands_are_the_readme_s(script):
    assert script["parse_arguments"]([]).commands == ["make demo STK=0", "make test"]
    assert all(f"    {command}" in README.read_text() for command in ("make demo ", "make test "))
    assert script["parse_arguments"](["--quick"]).commands[-1] == "make test"
    assert script["parse_arguments"](["id", "ls"]).commands == ["id", "ls"]


@pytest.mark.skipif(shutil.which("git") is None, reason="no git")
def test_tracked_files_come_as_they_are_in_the_working_tree(script, tmp_path):
    source, target = tmp_path / "source", tmp_path / "target"
    (source / "sub").mkdir(parents=True)
    for name in ("kept", "sub/changed", "deleted", "untracked"):
        (source / name).write_text("old")
    subprocess.run(["git", "init", "-q"], cwd=source, check=True)
    subprocess.run(["git", "add", "kept", "sub/changed", "deleted"], cwd=source, check=True)
    (source / "sub" / "changed").write_text("new")
    (source / "deleted").unlink()
    names = script["tracked_files"](source)
    assert sorted(names) == ["kept", "sub/changed"]
    script["copy_files"](names, source, target)
    assert sorted(str(p.relative_to(target)) for p in target.rglob("*") if p.is_file()) == sorted(names)
    assert (target / "sub" / "changed").read_text() == "new"


def test_environment_is_the_root_s_and_what_was_passed(script, monkeypatch):
    for name in list(os.environ):
        monkeypatch.delenv(name)
    for name in ("PATH", "HOME", "LANG", "PIP_CERT", "https_proxy", "NO_PROXY", "MINE"):
        monkeypatch.setenv(name, "here")
    environment = script["passed_environment"](["MINE"])
    assert sorted(environment) == ["HOME", "MINE", "NO_PROXY", "PATH", "PIP_CERT", "https_proxy"]
    assert environment["HOME"] == "/root"
    assert environment["PATH"] != "here"


def test_bound_paths_must_exist_and_get_a_mount_point(script, tmp_path):
    wheels, file = tmp_path / "wheels", tmp_path / "file"
    wheels.mkdir()
    file.touch()
    binds = script["bound_paths"]([str(wheels), str(file)])
    root = tmp_path / "root"
    script["prepare_mount_points"](root, {wheels: binds[wheels], file: binds[file]})
    assert (root / str(wheels)[1:]).is_dir()
    assert (root / str(file)[1:]).is_file()
    with pytest.raises(SystemExit, match="none: there is no such path"):
        script["bound_paths"]([str(tmp_path / "none")])


def test_lines_of_a_progress_bar_are_its_last_state(script, tmp_path):
    status, minutes, lines = script["run"](["sh", "-c", r"printf ' 10%%\r100%%\n\nend\n'; exit 3"], tmp_path / "log")
    assert (status, lines) == (3, ["100%", "end"])
    assert minutes >= 0
