"""One door: ``supersampling COMMAND``, the scripts, the configurations and the pages have the same names."""

import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra

from supersampling.commands import entry
from supersampling.resources import resources
from supersampling.runs.keys import KEYS

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("name", entry.COMMANDS)
def test_a_command_has_one_name(name):
    module = import_module(f"supersampling.commands.{name}")
    assert callable(getattr(module, name))
    script = (ROOT / f"{name}.py").read_text()
    assert "script(__file__)" in script
    assert f"{name}.py --help" in script
    config = (ROOT / "conf" / f"{name}.yaml").read_text()
    assert f"app_name: {name}.py" in config


def test_every_script_is_a_command():
    assert {p.stem for p in ROOT.glob("*.py")} - {"setup"} == set(entry.COMMANDS)


def test_help_lists_every_command(capsys):
    entry.main([])
    text = capsys.readouterr().out
    for name in entry.COMMANDS:
        assert f"  {name} " in text
    assert all(len(line) <= 120 for line in text.splitlines())


def test_help_loads_no_slow_library():
    code = "import sys, supersampling.commands.entry; print({'torch', 'lightning', 'mlflow'} & sys.modules.keys())"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert loaded.stdout == "set()\n"


def test_an_unknown_command(capsys):
    with pytest.raises(SystemExit) as caught:
        entry.main(["trane"])
    assert caught.value.code == 2
    assert "Unknown command trane: use one of train" in capsys.readouterr().err


@pytest.mark.parametrize("name", entry.COMMANDS)
def test_every_key_of_a_command_is_in_the_table(name):
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(resources() / "conf"), version_base="1.3"):
        cfg = compose(name)
    assert {str(key) for key in cfg} <= KEYS.keys()
    known = {str(key) for command in entry.COMMANDS for key in _keys(command)}
    groups = {path.name for path in (resources() / "conf").iterdir() if path.is_dir()} | {"sweeps"}
    assert {key for key in KEYS if "." not in key} <= known | groups


def _keys(name):
    with initialize_config_dir(str(resources() / "conf"), version_base="1.3"):
        return compose(name)
