"""Spaces: what is enumerated, what the command line fixes, and that every file of conf/among composes for train.py."""

from pathlib import Path

import pytest
import yaml
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.utils import instantiate

from supersampling.advice.facts import MEASURES
from supersampling.advice.space import Space, Switch, merged, read_space
from supersampling.errors import UserError

ROOT = Path(__file__).resolve().parents[2]
SPACES = sorted((ROOT / "conf" / "among").glob("*.yaml"))
MADE = Space(
    "made",
    ("model=m", "loss=l1"),
    (
        Switch("previous", {"2": ("p=2",), "0": ("p=0",)}),
        Switch("warp", {"high": ("w=high",), "low": ("w=low",)}, (), {"previous": "0"}),
    ),
)


def load(path: Path) -> Space:
    return read_space(yaml.safe_load(path.read_text()))


def test_an_idle_switch_is_not_walked() -> None:
    assert [c.name for c in MADE.compositions()] == [
        "previous=2 warp=high", "previous=2 warp=low", "previous=0 warp=low",
    ]  # fmt: skip
    assert MADE.compositions()[0].overrides == ("model=m", "loss=l1", "p=2", "w=high")


def test_the_command_line_fixes_a_switch() -> None:
    fixed = MADE.fixed(["w=other", "loss=mse", "budget.steps=3"])
    assert [c.overrides for c in fixed.compositions()] == [
        ("model=m", "loss=mse", "w=other", "budget.steps=3", "p=2"),
        ("model=m", "loss=mse", "w=other", "budget.steps=3", "p=0"),
    ]


def test_of_two_overrides_of_a_key_the_later_stands() -> None:
    assert merged(["a=1", "+b=2", "a=3", "b=4"]) == ["a=3", "b=4"]


@pytest.mark.parametrize(
    "data", [{}, {"name": "x", "recipe": []}, {"name": "x", "recipe": [], "switches": {"a": 3}}, None]
)
def test_a_space_that_does_not_read_is_a_sentence(data: object) -> None:
    with pytest.raises(UserError, match="space"):
        read_space(data)


@pytest.mark.parametrize("path", SPACES, ids=lambda p: p.stem)
def test_every_option_is_one_of_train(path: Path) -> None:
    space = load(path)
    assert space.name == path.stem
    assert {r.fact for s in space.switches for r in s.rules} <= set(MEASURES)
    plain = {s.name: s.plainest for s in space.switches}
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):
        for switch in space.switches:
            for option in switch.options:
                chosen = space.compose({**plain, switch.name: option})
                cfg = compose("train", [*chosen.overrides, "scene=atrium"])
                assert instantiate(cfg.model).requires


@pytest.mark.parametrize("path", SPACES, ids=lambda p: p.stem)
def test_no_two_options_are_the_same(path: Path) -> None:
    for switch in load(path).switches:
        assert len(set(switch.options.values())) == len(switch.options)
        for other, option in switch.unless.items():
            assert option in next(s for s in load(path).switches if s.name == other).options
