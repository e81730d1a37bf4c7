"""Several sweeps by one command."""

import sys

import pytest

from supersampling.commands.campaign import commands, run_each
from supersampling.errors import UserError


@pytest.fixture
def folder(tmp_path):
    for name in ("nsrr_table9", "nsrr_table10", "enss_table3", "laptop"):
        (tmp_path / f"{name}.yaml").touch()
    return tmp_path


@pytest.mark.parametrize(
    ("given", "names"),
    [
        ("sweeps=nsrr_table9,enss_table3", ["nsrr_table9", "enss_table3"]),
        ("sweeps=nsrr", ["nsrr_table10", "nsrr_table9"]),
        ("sweeps=nsrr_table9,nsrr", ["nsrr_table9", "nsrr_table10"]),
        ("sweeps=laptop", ["laptop"]),
    ],
)
def test_each_sweep_is_a_command(folder, given, names):
    made = commands(["-m", "budget=laptop", given, "seed=1"], folder)
    assert made == [["-m", "budget=laptop", f"sweeps={name}", "seed=1"] for name in names]


@pytest.mark.parametrize("arguments", [["--help"], ["model=tus"], ["-m", "seed=0,1"], ["sweeps=null"]])
def test_anything_else_stays_as_it_is(folder, arguments):
    assert commands(arguments, folder) == [arguments]


def test_mistakes(folder):
    with pytest.raises(UserError, match=r"sweeps=nsr is no file .* enss_table3, laptop, nsrr_table10"):
        commands(["-m", "sweeps=laptop,nsr"], folder)
    with pytest.raises(UserError, match="add -m"):
        commands(["sweeps=laptop"], folder)


@pytest.mark.parametrize(
    ("statuses", "status", "ran"),
    [((0, 0, 0), 0, 3), ((0, 2, 1), 2, 3), ((0, 130, 0), 130, 2), ((-2, 0, 0), 130, 1)],
)
def test_the_first_failure_is_told_and_an_interrupt_ends_it(folder, tmp_path, monkeypatch, statuses, status, ran):
    script = tmp_path / "script.py"
    lines = [
        "import os, signal, sys",
        f"log = {str(tmp_path / 'log')!r}",
        "open(log, 'a').write(sys.argv[2] + '\\n')",
        f"status = {statuses}[len(open(log).readlines()) - 1]",
        "status < 0 and (signal.signal(-status, signal.SIG_DFL), os.kill(os.getpid(), -status))",
        "sys.exit(status)",
    ]
    script.write_text("\n".join(lines))
    monkeypatch.setattr(sys, "argv", [str(script), "-m", "sweeps=nsrr,laptop"])
    with pytest.raises(SystemExit) as caught:
        run_each(lambda: pytest.fail("main was called"), folder)
    assert caught.value.code == status
    told = (tmp_path / "log").read_text().split()
    assert told == ["sweeps=nsrr_table10", "sweeps=nsrr_table9", "sweeps=laptop"][:ran]
