"""Several sweeps by one command."""

import subprocess

import pytest

from supersampling.commands import campaign
from supersampling.commands.campaign import commands, run_sweeps, with_scenes
from supersampling.errors import UserError


@pytest.fixture
def folder(tmp_path):
    for name in ("nsrr_table9", "nsrr_table10", "enss_table3", "laptop"):
        (tmp_path / f"{name}.yaml").touch()
    return tmp_path


@pytest.mark.parametrize(
    ("typed", "names"),
    [
        ("sweeps=nsrr_table9,enss_table3", ["nsrr_table9", "enss_table3"]),
        ("sweeps=nsrr", ["nsrr_table10", "nsrr_table9"]),
        ("sweeps=nsrr_table9,nsrr", ["nsrr_table9", "nsrr_table10"]),
        ("sweeps=laptop,enss", ["laptop", "enss_table3"]),
    ],
)
def test_each_sweep_is_a_command(folder, typed, names):
    sweeps = commands(["-m", "budget=laptop", typed, "seed=1"], folder)
    assert sweeps == [["-m", "budget=laptop", f"sweeps={name}", "seed=1"] for name in names]


@pytest.mark.parametrize(
    "arguments", [["--help"], ["model=tus"], ["-m", "seed=0,1"], ["sweeps=null"], ["-m", "sweeps=laptop"]]
)
def test_anything_else_needs_no_process_of_its_own(folder, arguments):
    assert commands(arguments, folder) == []


def test_mistakes(folder):
    with pytest.raises(UserError, match=r"There is no sweep nsr .* enss_table3, laptop, nsrr_table10"):
        commands(["-m", "sweeps=laptop,nsr"], folder)
    with pytest.raises(UserError, match="add -m"):
        commands(["sweeps=laptop"], folder)


@pytest.mark.parametrize(
    ("statuses", "status", "ran"), [((0, 0, 0), 0, 3), ((0, 2, 1), 2, 3), ((0, 130, 0), 130, 2), ((-2, 0, 0), 130, 1)]
)
def test_the_first_failure_is_the_status_and_an_interrupt_ends_it(folder, monkeypatch, statuses, status, ran):
    lines = []

    def run(line):
        lines.append(line[-1])
        return subprocess.CompletedProcess(line, statuses[len(lines) - 1])

    monkeypatch.setattr(campaign.subprocess, "run", run)
    assert run_sweeps(commands(["-m", "sweeps=nsrr,laptop"], folder)) == status
    assert lines == ["sweeps=nsrr_table10", "sweeps=nsrr_table9", "sweeps=laptop"][:ran]


BUILT_IN = "sundial,turntable,louvres,market,foundry,airstrip,bar,atrium,arena"


@pytest.mark.parametrize(
    ("typed", "scenes"),
    [
        ("experiment=laptop/nsrr", set(BUILT_IN.split(","))),
        ("sweeps=nsrr_table3", set(BUILT_IN.split(","))),
        ("sweeps=nsrd_table1", {"market", "atrium", "louvres", "bar", "foundry", "airstrip", "arena"}),
        ("experiment=laptop/nsrr,[laptop/nsrr_published,nsrd/nsrr]", set(BUILT_IN.split(","))),
    ],
)
def test_a_job_for_each_scene(typed, scenes):
    words = with_scenes(["--multirun", "--", typed, "scene=each", "seed=0,1"])
    assert words[:3] + words[4:] == ["--multirun", "--", typed, "seed=0,1"]
    key, _, names = words[3].partition("=")
    assert key == "scene"
    assert set(names.split(",")) == scenes
    assert len(names.split(",")) == len(scenes)


def test_the_default_scenes_each():
    from supersampling.scenes.load import installed_scenes

    assert with_scenes(["-m", "experiment=nsrr", "scene=each"])[2] == f"scene={','.join(installed_scenes())}"


def test_mistakes_of_each_scene():
    with pytest.raises(UserError, match="scene=each trains a network per scene, so it runs several jobs: add -m"):
        with_scenes(["experiment=nsrr", "scene=each"])
    with pytest.raises(UserError, match=r"different scenes, .*: name the scenes, scene=a,b"):
        with_scenes(["-m", "experiment=nsrr,laptop/nsrr", "scene=each"])
    assert with_scenes(["-m", "scene=a,b"]) == ["-m", "scene=a,b"]
