"""Parts against the seconds that a fake clock gives them."""

import pytest
import torch
from fake_time import FRAME, Clock, Timed
from hydra.utils import instantiate

from supersampling.profiling.parts import Recorder, parts

CPU = torch.device("cpu")
TOP = {"prepare": 10.0, "net": 24.0, "blocks.0": 32.0, "blocks.1": 64.0, "(its own)": 1.0, "total": 131.0}
BELOW = {"prepare.warp": 8.0, "prepare.(its own)": 2.0, "net.inner": 16.0, "net.(its own)": 8.0}


@pytest.mark.parametrize(("depth", "expected"), [(1, TOP), (2, TOP | BELOW), (9, TOP | BELOW)])
def test_they_are_the_clock_s(depth, expected):
    clock = Clock()
    model = Timed(clock)
    rows = parts(model, lambda: model(FRAME, None), 5, Recorder(CPU, depth, clock))
    assert {r.part: r.ms / 1e3 for r in rows} == pytest.approx(expected)
    assert {r.part: r.share * 131.0 for r in rows} == pytest.approx(expected)
    assert next(r for r in rows if r.part == "net").kind == "Takes"


def test_each_level_adds_up_to_what_calls_it_where_frames_differ():
    clock = Clock()
    model = Timed(clock)
    lengths = iter((1.0, 50.0, 3.0, 9.0, 2.0, 700.0, 5.0))

    def step():
        model.warp.seconds = model.net.inner.seconds**0.5 * next(lengths)
        model(FRAME, None)

    rows = {r.part: r for r in parts(model, step, 7, Recorder(CPU, 2, clock))}
    assert sum(r.ms for name, r in rows.items() if name in TOP and name != "total") == pytest.approx(rows["total"].ms)
    for parent in ("prepare", "net"):
        children = [r.ms for name, r in rows.items() if name.startswith(f"{parent}.")]
        assert sum(children) == pytest.approx(rows[parent].ms)
    # Sorted: 1 2 3 5 9 50 700; of seven, the middle five.
    assert rows["prepare.warp"].ms == pytest.approx(1e3 * 2 * 4 * (2 + 3 + 5 + 9 + 50) / 5)


def test_a_model_is_left_as_it_was():
    clock = Clock()
    model = Timed(clock)
    before = {name: dict(vars(m)) for name, m in model.named_modules()}
    parts(model, lambda: model(FRAME, None), 1, Recorder(CPU, 3, clock))
    assert {name: dict(vars(m)) for name, m in model.named_modules()} == before
    assert "prepare" not in vars(model)


def test_tensor_functions_are_parts(composed):
    from supersampling.models import dlctus
    from supersampling.models.count import random_frame

    original = dlctus.zero_upsample
    model = instantiate(composed("model=dlctus").model)
    frame = random_frame(model, 8, 8, "cpu")
    with torch.no_grad():
        rows = {r.part: r.kind for r in parts(model, lambda: model(frame, model(frame, None)[1]), 2, Recorder(CPU, 2))}
    assert rows["zero_upsample"] == "function"
    assert rows["prepare.jitter_aligned_upsample"] == "function"
    assert rows["network.blocks.3"] == "Sequential"
    assert dlctus.zero_upsample is original
