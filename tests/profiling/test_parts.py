"""Times of parts against the seconds of a fake clock."""

import pytest
import torch
from fake_time import FRAME, Clock, WorkingMethod
from hydra.utils import instantiate

from supersampling.profiling.parts import Recorder, measure_parts

CPU = torch.device("cpu")
TOP = {"prepare": 10.0, "net": 24.0, "blocks.0": 32.0, "blocks.1": 64.0, "(its own)": 1.0, "total": 131.0}
BELOW = {"prepare.warp": 8.0, "prepare.(its own)": 2.0, "net.inner": 16.0, "net.(its own)": 8.0}


@pytest.mark.parametrize(("depth", "expected"), [(1, TOP), (2, TOP | BELOW), (9, TOP | BELOW)])
def test_times_are_those_of_the_clock(depth, expected):
    clock = Clock()
    model = WorkingMethod(clock)
    rows = measure_parts(model, lambda: model(FRAME, None), 5, Recorder(CPU, depth, clock))
    assert {r.part: r.ms / 1e3 for r in rows} == pytest.approx(expected)
    assert {r.part: r.share * 131.0 for r in rows} == pytest.approx(expected)
    assert next(r for r in rows if r.part == "net").kind == "Working"


def test_levels_add_up_when_frames_differ():
    clock = Clock()
    model = WorkingMethod(clock)
    lengths = iter((1.0, 50.0, 3.0, 9.0, 2.0, 700.0, 5.0))

    def step():
        model.warp.seconds = model.net.inner.seconds**0.5 * next(lengths)
        model(FRAME, None)

    rows = {r.part: r for r in measure_parts(model, step, 7, Recorder(CPU, 2, clock))}
    assert sum(r.ms for name, r in rows.items() if name in TOP and name != "total") == pytest.approx(rows["total"].ms)
    for parent in ("prepare", "net"):
        children = [r.ms for name, r in rows.items() if name.startswith(f"{parent}.")]
        assert sum(children) == pytest.approx(rows[parent].ms)
    # Sorted: 1 2 3 5 9 50 700; the middle five count.
    assert rows["prepare.warp"].ms == pytest.approx(1e3 * 2 * 4 * (2 + 3 + 5 + 9 + 50) / 5)


def test_model_is_unchanged():
    clock = Clock()
    model = WorkingMethod(clock)
    before = {name: dict(vars(m)) for name, m in model.named_modules()}
    measure_parts(model, lambda: model(FRAME, None), 1, Recorder(CPU, 3, clock))
    assert {name: dict(vars(m)) for name, m in model.named_modules()} == before
    assert "prepare" not in vars(model)


def test_tensor_functions_are_parts(composed):
    from supersampling.models import dlctus
    from supersampling.models.count import random_frame

    original = dlctus.zero_upsample
    model = instantiate(composed("model=dlctus").model)
    frame = random_frame(model, 8, 8, "cpu")
    with torch.no_grad():
        rows = {
            r.part: r.kind
            for r in measure_parts(model, lambda: model(frame, model(frame, None)[1]), 2, Recorder(CPU, 3))
        }
    assert rows["prepare_input.zero_upsample"] == "function"
    assert rows["prepare_input.prepare.jitter_aligned_upsample"] == "function"
    assert rows["network.blocks.3"] == "ResidualBlock"
    # Numbered layers of a numbered block: names of two levels do not mix.
    layers = [rows[f"network.blocks.3.{k}"] for k in range(3)]
    assert layers == ["Conv2d", "ReLU", "Conv2d"]
    assert dlctus.zero_upsample is original
