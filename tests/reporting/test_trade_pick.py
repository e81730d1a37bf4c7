"""A pick from a store: the input, the printed answer, and mistakes."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from omegaconf import DictConfig, OmegaConf
from stored_runs import FINGERPRINT, Log
from test_trade import FACTOR, METHODS, example_timing, log_benchmark, log_trainings, precision_losses

from supersampling.commands.pick import pick
from supersampling.errors import UserError

Configure = Callable[..., DictConfig]


@pytest.fixture(scope="module")
def configure(tmp_path_factory: pytest.TempPathFactory) -> Configure:
    log = Log(tmp_path_factory.mktemp("store"))
    log_trainings(log)
    timings = [example_timing(m, b, ms=ms * f) for m, (_, ms) in METHODS.items() for b, f in FACTOR.items()]
    timings.append(example_timing("dlctus", "openvino", "int8", 120.0))
    timings.append(example_timing("jau", "compile", ms=np.nan, reason="No."))
    small = [example_timing(m, "eager", ms=0.2 * ms, width=640, height=360) for m, (_, ms) in METHODS.items()]
    log_benchmark(log, [*timings, *small], precision=precision_losses("dlctus", 0.3))
    settings = {"tracking_uri": log.uri, "experiment_name": "supersampling"}
    settings |= dict.fromkeys(("dataset", "ms", "db", "size", "low_ms", "high_ms"))

    def build(**overrides: Any) -> DictConfig:
        dotlist = OmegaConf.from_dotlist([f"{k}={v}" for k, v in overrides.items()])
        return OmegaConf.merge(settings, dotlist)  # type: ignore[return-value]

    return build


def test_time_limit(configure: Configure, capsys: pytest.CaptureFixture[str]) -> None:
    pick(configure(ms=50))
    printed = capsys.readouterr().out
    assert printed.startswith("4×4, matched, data=laptop (3fa9c077), budget=laptop; 1920x1080 on cpu, 2 threads")
    assert "best within 50 ms: tus (openvino float32, 24 ms" in printed
    assert "Ahead of the next, jau (openvino float32" in printed
    assert "640x360 on cpu" in printed


@pytest.mark.parametrize(
    ("db", "selected"),
    [(0.0, "float32, 180 ms"), (0.3, "float32, 180 ms"), (0.36, "float32, 180 ms"), (0.6, "int8, 120 ms")],
)
def test_quality_limit_counts_the_loss_of_int8(
    configure: Configure, capsys: pytest.CaptureFixture[str], db: float, selected: str
) -> None:
    """Of dlctus, whose int8 loses 0.345 dB, with an interval down to 0.42."""
    pick(configure(db=db))
    assert f"fastest within {db:g} dB of the best: dlctus (openvino {selected}" in capsys.readouterr().out


def test_size_and_rendering(configure: Configure, capsys: pytest.CaptureFixture[str]) -> None:
    pick(configure(ms=12, size="[640,360]", low_ms=2.0, high_ms=10.0, dataset=FINGERPRINT[:4]))
    printed = capsys.readouterr().out
    # 2 + 8.8 ms
    assert "best within 12 ms: tus (eager float32, 8 ms" in printed
    assert "Upscaling does not pay: 2 + 8.8 = 10.8 ms" in printed


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        ({}, "Invalid ms=None and db=None: set exactly one"),
        ({"ms": 5, "db": 1}, "Invalid ms=5 and db=1: set exactly one"),
        ({"ms": 0}, "Invalid ms=0: .*fastest here is bicubic"),
        ({"ms": 0.001}, "Nothing here is within ms=0.001"),
        ({"db": -1}, "Invalid db=-1"),
        ({"ms": 5, "size": "[8,8]"}, r"No times with size=\[8, 8\]: choose from \[1920,1080\]"),
        ({"ms": 5, "dataset": "zz"}, "dataset=zz"),
        ({"ms": 5, "low_ms": 0}, "Invalid low_ms=0"),
        ({"ms": 5, "high_ms": 3}, "high_ms=3 needs low_ms"),
        ({"ms": 5, "tracking_uri": "sqlite:///no/such.db"}, "no/such.db"),
    ],
)
def test_mistakes(configure: Configure, overrides: dict[str, Any], message: str) -> None:
    with pytest.raises(UserError, match=message):
        pick(configure(**overrides))


def test_without_times(tmp_path: Path, configure: Configure) -> None:
    log = Log(tmp_path)
    log_trainings(log)
    with pytest.raises(UserError, match=r"benchmark.py"):
        pick(configure(ms=5, tracking_uri=log.uri))
