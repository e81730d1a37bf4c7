"""Every command in README.md and docs/: each composes (fast), and each runs on the smallest data (slow)."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from filelock import FileLock
from hydra import compose, initialize_config_dir
from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra.core.global_hydra import GlobalHydra
from hydra.core.override_parser.overrides_parser import OverridesParser

from supersampling.commands.campaign import commands, with_scenes
from supersampling.commands.overrides import with_additions

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
COMMANDS = sorted(
    {
        line.strip()
        for page in PAGES
        for line in re.findall(r"^ {4}((?:python \w+\.py|supersampling \w+).*)$", page.read_text(), re.MULTILINE)
    }
)


def parsed(command: str) -> tuple[str, bool, list[str]]:
    words = shlex.split(command.split("#")[0])
    return words[1].removesuffix(".py"), "-m" in words, [w for w in words[2:] if w not in ("-m", "--help")]


def jobs_of(words: list[str], multirun: bool) -> list[list[str]]:
    """The overrides of each job; a list in brackets is one value."""
    if not multirun:
        return [words]
    jobs: list[list[str]] = BasicSweeper.split_arguments(OverridesParser.create().parse_overrides(words), None)[0]
    return jobs


def test_there_are_commands():
    assert len(COMMANDS) >= 12


@pytest.mark.parametrize("command", COMMANDS)
def test_it_composes(command):
    name, multirun, overrides = parsed(command)
    line = ["-m"] * multirun + overrides
    for sweep in commands(line) or [line]:
        given = [word for word in with_scenes(sweep) if word != "-m"]
        for job in jobs_of(given, multirun):
            GlobalHydra.instance().clear()
            with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):
                compose(name, with_additions(name, job))


def test_every_make_target_in_the_documentation_exists():
    makefile = (ROOT / "Makefile").read_text()
    for page in PAGES:
        for target in re.findall(r"\bmake ([a-z-]+)", page.read_text()):
            assert re.search(rf"^{target}:|^\.PHONY:.*\b{target}\b", makefile, re.MULTILINE), (page.name, target)


def test_every_linked_file_exists():
    for page in PAGES:
        for link in re.findall(r"\]\(([^)#:]+)\)", page.read_text()):
            assert (page.parent / link).exists(), (page.name, link)


SMALL = {
    "train": ["data=smoke", "budget=smoke", "scene=atrium"],
    "render": ["data=smoke", "scene=atrium"],
    "show": ["data=smoke", "scene=atrium", "video=null", "data.train.clips=4"],
    "evaluate": ["data=smoke", "scene=atrium"],
    "count": ["scene=atrium"],
    "benchmark": ["sizes=[[96,96]]", "rounds=1", "seconds=0.1", "frames=2", "backends=[eager,tensorrt]"],
    "export": ["scene=atrium", "check=2"],
    "advise": [
        "data=smoke",
        "budget=smoke",
        "scene=atrium",
        "rungs=[1]",
        "seeds=[1]",
        "trials=2",
        "size=[16,16]",
        "frames=1",
    ],
    "report": [],
    "stress": ["models=[jau]", "extremes=[size/1x1]", "scene=atrium"],
}
# Every training and timing is cut to the smallest.
CUT = ("budget=", "budget.steps=", "trials=", "rounds=", "seconds=", "sizes=")
CUT_OF = {"advise": ("size=", "frames=", "rungs=", "seeds="), "train": ("data.train.clips=", "scene=[atrium,")}
# Of a list of methods to time, the first and the last: each is timed in tests of its own.
LISTED = re.compile(r"(methods=\[[^,\]]+,)(?:.+,)([^,]+\])")
# What needs files of the user's, weights of a hub, or hours.
UNRUN = (
    r"RUN_ID|compare|FILE|FOLDER|\.h5|stk/|budget=paper|experiment=|data=(dlctus|nsrr|nsrd|qrisp)"
    r"|sweeps=(dlctus |nsrr_table9,)|3840|pick\.py|cost=true|train\.py model=nsrr( model|$)"
)
RUNNABLE = [c for c in COMMANDS if not re.search(UNRUN, c)]


def run(name, words):
    return subprocess.run([sys.executable, f"{name}.py", *words], cwd=ROOT, capture_output=True, text=True, timeout=900)


@pytest.fixture(scope="session")
def root(tmp_path_factory):
    """Return a project with a trained run, which all test processes share: commands find each other's data and runs."""
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "documented"
    folder.mkdir(exist_ok=True)
    with FileLock(folder / "lock"):
        if not (folder / "mlflow.db").exists():
            done = run("train", [*SMALL["train"], f"paths.root={folder}"])
            assert done.returncode == 0, done.stderr[-3000:]
            shutil.copy(folder / "mlflow.db", folder / "trained.db")
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("command", RUNNABLE)
def test_it_runs(command, root):
    name, multirun, overrides = parsed(command)
    overrides = [LISTED.sub(r"\1\2", o) for o in overrides if not o.startswith(CUT + CUT_OF.get(name, ()))]
    small = [o for o in SMALL[name] if not any(w.startswith(o.split("=")[0] + "=") for w in overrides)]
    where = (
        [f"paths.root={root}"]
        if name != "report"
        else [f"tracking_uri=sqlite:///{root}/mlflow.db", f"output={root}/out"]
    )
    if "run=all" in overrides:  # of this run: other commands add theirs
        where.append(f"tracking_uri=sqlite:///{root}/trained.db")
    done = run(name, [*(["-m"] if multirun else []), *overrides, *small, *where])
    status = re.search(r"# status (\d+)$", command)  # documented of a command whose answer is that something fails
    assert done.returncode == (int(status[1]) if status else 0), done.stderr[-3000:]
