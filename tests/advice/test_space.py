"""Spaces: their compositions, switches fixed on the command line, and the files of conf/among with train.py."""

from pathlib import Path

import pytest
import yaml
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.utils import instantiate

from supersampling.advice.facts import MEASUREMENTS
from supersampling.advice.space import Space, Switch, merge_overrides, read_space
from supersampling.errors import UserError

ROOT = Path(__file__).resolve().parents[2]
SPACES = sorted((ROOT / "conf" / "among").glob("*.yaml"))
SYNTHETIC = Space(
    "synthetic",
    ("model=m", "loss=l1"),
    (
        Switch("previous", {"2": ("p=2",), "0": ("p=0",)}),
        Switch("warp", {"high": ("w=high",), "low": ("w=low",)}, (), {"previous": "0"}),
    ),
)


def load(path: Path) -> Space:
    return read_space(yaml.safe_load(path.read_text()))


def test_idle_switch_is_not_walked() -> None:
    assert [c.name for c in SYNTHETIC.compositions()] == [
        "previous=2 warp=high",
        "previous=2 warp=low",
        "previous=0 warp=low",
    ]
    assert SYNTHETIC.compositions()[0].overrides == ("model=m", "loss=l1", "p=2", "w=high")


def test_command_line_fixes_a_switch() -> None:
    fixed = SYNTHETIC.fix(["w=other", "loss=mse", "budget.steps=3"])
    assert [c.overrides for c in fixed.compositions()] == [
        ("model=m", "loss=mse", "w=other", "budget.steps=3", "p=2"),
        ("model=m", "loss=mse", "w=other", "budget.steps=3", "p=0"),
    ]


def test_later_override_of_a_key_wins() -> None:
    assert merge_overrides(["a=1", "+b=2", "a=3", "b=4"]) == ["a=3", "b=4"]


@pytest.mark.parametrize(
    "data", [{}, {"name": "x", "recipe": []}, {"name": "x", "recipe": [], "switches": {"a": 3}}, None]
)
def test_invalid_space(data: object) -> None:
    with pytest.raises(UserError, match="The space cannot be read"):
        read_space(data)


@pytest.mark.parametrize("path", SPACES, ids=lambda p: p.stem)
def test_whole_space_can_be_tried_as_documented(path: Path) -> None:
    walk = yaml.safe_load((ROOT / "conf" / "advise.yaml").read_text())["walk"]
    assert (len(load(path).compositions()) <= walk) == (path.stem != "nsrr")  # for which search=optuna is documented


@pytest.mark.parametrize("path", SPACES, ids=lambda p: p.stem)
def test_every_option_composes_for_train(path: Path) -> None:
    space = load(path)
    assert space.name == path.stem
    assert {r.fact for s in space.switches for r in s.rules} <= set(MEASUREMENTS)
    plain = {s.name: s.plainest for s in space.switches}
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):
        for switch in space.switches:
            for option in switch.options:
                composition = space.compose({**plain, switch.name: option})
                cfg = compose("train", [*composition.overrides, "scene=atrium"])
                assert instantiate(cfg.model).requires


@pytest.mark.parametrize("path", SPACES, ids=lambda p: p.stem)
def test_options_of_a_switch_differ(path: Path) -> None:
    for switch in load(path).switches:
        assert len(set(switch.options.values())) == len(switch.options)
        for name, option in switch.unless.items():
            assert option in next(s for s in load(path).switches if s.name == name).options
