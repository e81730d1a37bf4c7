"""A pick from a store: what is read, and mistakes."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from omegaconf import DictConfig, OmegaConf
from stored_runs import FINGERPRINT, Log
from test_trade import FACTOR, METHODS, benchmark, losses, made, trained

from supersampling.commands.pick import pick_command, wants_pick
from supersampling.errors import UserError

Ask = Callable[..., DictConfig]


@pytest.fixture(scope="module")
def ask(tmp_path_factory: pytest.TempPathFactory) -> Ask:
    log = Log(tmp_path_factory.mktemp("store"))
    trained(log)
    timings = [made(m, b, ms=ms * f) for m, (_, ms) in METHODS.items() for b, f in FACTOR.items()]
    timings += [made("dlctus", "openvino", "int8", 120.0), made("jau", "compile", ms=np.nan, reason="No.")]
    small = [made(m, "eager", ms=0.2 * ms, width=640, height=360) for m, (_, ms) in METHODS.items()]
    benchmark(log, [*timings, *small], precision=losses("dlctus", 0.3))

    def make(**more: Any) -> DictConfig:
        cfg = {
            "logger": {"tracking_uri": log.uri, "experiment": "supersampling"}, "dataset": None,
            "pick": {"ms": None, "db": None, "size": None}, "render": {"low_ms": None, "high_ms": None},
        }  # fmt: skip
        return OmegaConf.merge(cfg, OmegaConf.from_dotlist([f"{k}={v}" for k, v in more.items()]))  # type: ignore[return-value]

    return make


def test_a_time(ask: Ask, capsys: pytest.CaptureFixture[str]) -> None:
    answer = pick_command(ask(**{"pick.ms": 50}))
    assert (answer.chosen.label, answer.chosen.how) == ("tus", "openvino float32")
    said = capsys.readouterr().out
    assert said.startswith("4×4, matched, data=laptop (3fa9c077), budget=laptop; 1920x1080 on cpu, 2 threads")
    assert "best within 50 ms: tus (openvino float32, 24 ms" in said
    assert "Ahead of the next, jau (openvino float32" in said
    assert "640x360 on cpu" in said


@pytest.mark.parametrize(("db", "chosen"), [(0.0, "float32"), (0.3, "float32"), (0.36, "float32"), (0.6, "int8")])
def test_a_loss_counts_what_int8_costs(ask: Ask, db: float, chosen: str) -> None:
    """Of dlctus, whose int8 loses 0.345 dB, with an interval down to 0.42."""
    answer = pick_command(ask(**{"pick.db": db}))
    assert (answer.chosen.label, answer.chosen.timing.precision) == ("dlctus", chosen)


def test_another_size_and_rendering(ask: Ask, capsys: pytest.CaptureFixture[str]) -> None:
    more = {
        "pick.size": "[640,360]",
        "render.low_ms": 2.0,
        "render.high_ms": 10.0,
        "dataset": FINGERPRINT[:4],
    }
    answer = pick_command(ask(**{"pick.ms": 12, **more}))
    assert answer.chosen.label == "tus"  # 2 + 8.8 ms
    assert "Upscaling does not pay: 2 + 8.8 = 10.8 ms" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({}, "pick.ms=None and pick.db=None"),
        ({"pick.ms": 5, "pick.db": 1}, "give one of them"),
        ({"pick.ms": 0}, "pick.ms=0 is no time.*fastest here is bicubic"),
        ({"pick.ms": 0.001}, "Nothing here is within pick.ms=0.001"),
        ({"pick.db": -1}, "pick.db=-1"),
        (
            {"pick.ms": 5, "pick.size": "[8,8]"},
            r"pick.size=\[8, 8\] was not timed: choose from \[1920,1080\]",
        ),
        ({"pick.ms": 5, "dataset": "zz"}, "zz"),
        ({"pick.ms": 5, "render.high_ms": 3}, "render.low_ms"),
        ({"pick.ms": 5, "tracking_uri": "sqlite:///no/such.db"}, "no/such.db"),
    ],
)
def test_mistakes(ask: Ask, given: dict[str, Any], told: str) -> None:
    with pytest.raises(UserError, match=told):
        pick_command(ask(**given))


def test_without_times(tmp_path: Path, ask: Ask) -> None:
    log = Log(tmp_path)
    trained(log)
    with pytest.raises(UserError, match=r"benchmark.py"):
        pick_command(ask(**{"pick.ms": 5, "tracking_uri": log.uri}))


def test_what_asks_for_a_pick(ask: Ask) -> None:
    assert not wants_pick(ask())
    assert wants_pick(ask(**{"pick.ms": 0}))
