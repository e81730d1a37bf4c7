"""Verdicts on example runs: intervals, steps, margins, missing runs, and the scenes on which a claim holds."""

import math
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
import pytest
from example_runs import example_run

from supersampling.reporting.pages.claims import counts, long_form, rows
from supersampling.reporting.papers.claims import Judged, choose_claim, judge, side
from supersampling.reporting.papers.effects import RunScores
from supersampling.reporting.papers.schema import Claim, Series
from supersampling.reporting.settings import choose
from supersampling.runs.statistics import Estimate
from supersampling.runs.store import Run

SCENES = ("arena", "bar", "foundry", "louvres", "market", "sundial")
# By scene; of no mean.
SCENE = dict(zip(SCENES, (4.0, -3.0, 1.0, 0.0, -4.0, 2.0)))


run = partial(example_run, model="nsrr", budget="laptop")


def clips(gains: dict[str, float] | float, base: float = 30.0, metric: str = "psnr") -> pd.DataFrame:
    """Two clips of each scene: its own level plus a gain by scene, the same on both clips."""
    of = gains if isinstance(gains, dict) else dict.fromkeys(SCENES, gains)
    rows = [(s, clip, base + SCENE[s] + of[s]) for s in SCENES for clip in (0, 1)]
    return pd.DataFrame(rows, columns=["scene", "clip", metric])


def claim(kind: str = "more", **more: Any) -> Claim:
    sides: dict[str, Any] = (
        {"a": {"model.warp_at": "target"}, "b": {"model.warp_at": "low"}} if "steps" not in more else {}
    )
    fields: dict[str, Any] = {"metric": "psnr", "base": {"model": "nsrr"}, **sides, **more}
    printed = {"id": "nsrr-1", "text": "Warping late is better", "source": "Table 9", "page": 9, "unit": "dB"}
    return Claim(kind=kind, **printed, **fields)  # type: ignore[arg-type]


def judged(
    statement: Claim, runs: list[Run], tables: dict[str, pd.DataFrame], frames: dict[str, pd.DataFrame] | None = None
) -> Judged:
    return judge(choose_claim(statement, choose(runs, None, None)), RunScores(tables, frames or {}))


PAIR = [run("late", model__warp_at="target"), run("early", model__warp_at="low")]


def test_a_difference_that_is_the_same_on_every_clip_has_no_width() -> None:
    tables = {"late": clips(0.26), "early": clips(0.0)}
    result = judged(claim(), PAIR, tables)
    assert result.verdict == "reproduced"
    assert result.effect is not None
    assert result.effect.mean == pytest.approx(0.26)
    assert result.effect.low == pytest.approx(0.26)
    assert result.effect.clips == 12
    assert result.holds == "holds on 6 of 6 scenes"
    against = judged(claim("less"), PAIR, tables)
    assert against.verdict == "contradicted"
    assert against.holds == "holds on none of 6 scenes"


def test_scenes_that_disagree_leave_it_unresolved_and_are_named() -> None:
    gains = dict(zip(SCENES, (1.0, 1.0, -1.5, -1.5, 1.0, 0.5)))  # mean 1/12
    result = judged(claim(), PAIR, {"late": clips(gains), "early": clips(0.0)})
    assert result.verdict == "unresolved"
    assert result.effect is not None
    assert result.effect.mean == pytest.approx(1 / 12)
    assert result.effect.low < 0 < result.effect.high
    assert result.holds == "holds on 4 of 6 scenes; not on foundry, louvres"
    assert result.reason == "the interval holds 0"


def test_the_interval_is_students_over_scenes() -> None:
    gains = dict(zip(SCENES, (0.9, 1.1, 1.0, 1.2, 0.8, 1.0)))
    result = judged(claim(), PAIR, {"late": clips(gains), "early": clips(0.0)})
    half = 2.5706 * np.std(list(gains.values()), ddof=1) / math.sqrt(6)  # t of 5 degrees of freedom
    assert result.effect is not None
    assert result.effect.half_width == pytest.approx(half, rel=0.05)


@pytest.mark.parametrize(
    ("kind", "low", "high", "expected"),
    [
        ("more", 0.1, 0.2, "reproduced"),
        ("more", -0.1, 0.2, "unresolved"),
        ("more", 0.0, 0.2, "unresolved"),
        ("more", -0.2, -0.1, "contradicted"),
        ("less", -0.2, -0.1, "reproduced"),
        ("less", 0.1, 0.2, "contradicted"),
        ("falls", -0.2, -0.1, "reproduced"),
        ("rises", -0.2, -0.1, "contradicted"),
        ("same", -0.29, 0.29, "reproduced"),
        ("same", 0.1, 0.31, "unresolved"),
        ("same", 0.3, 0.4, "contradicted"),
        ("same", -0.9, -0.31, "contradicted"),
        ("same", -0.4, 0.4, "unresolved"),
        ("more", math.nan, math.nan, "unresolved"),
    ],
)
def test_side_of_an_interval(kind: str, low: float, high: float, expected: str) -> None:
    statement = claim(kind, margin=0.3 if kind == "same" else None)
    assert side(statement, Estimate((low + high) / 2, low, high, 8)) == expected


STEPS = [Series(str(n), {"model.previous": str(n)}) for n in range(3)]
FRAMES = [run(f"p{n}", model__previous=n) for n in range(3)]


def test_every_step_must_be_reproduced() -> None:
    statement = claim("rises", steps=STEPS)
    rising = {f"p{n}": clips(0.5 * n) for n in range(3)}
    result = judged(statement, FRAMES, rising)
    assert result.verdict == "reproduced"
    assert [step.label for step in result.steps] == ["0 → 1", "1 → 2"]
    assert result.effect is not None
    assert result.effect.mean == pytest.approx(1.0)
    assert judged(claim("falls", steps=STEPS), FRAMES, rising).verdict == "contradicted"


def test_one_contradicted_step_contradicts_and_one_unresolved_leaves_open() -> None:
    statement = claim("rises", steps=STEPS)
    back = judged(statement, FRAMES, {"p0": clips(0.0), "p1": clips(2.0), "p2": clips(1.0)})
    assert back.verdict == "contradicted"
    assert back.reason == "at 1 → 2"
    assert back.holds == "holds on none of 6 scenes"
    mixed = dict(zip(SCENES, (1.9, 2.2, 1.8, 2.1, 2.3, 1.8)))
    flat = judged(statement, FRAMES, {"p0": clips(0.0), "p1": clips(2.0), "p2": clips(mixed)})
    assert flat.verdict == "unresolved"
    assert flat.reason == "the interval holds 0 at 1 → 2"
    assert judged(statement, FRAMES[:2], {"p0": clips(0.0), "p1": clips(-2.0)}).verdict == "contradicted"


def test_missing_runs_are_named() -> None:
    late = judged(claim(), PAIR[:1], {"late": clips(0.0)})
    assert late.verdict == "not run"
    assert late.reason == "no run with model.warp_at=low"
    none = judged(claim(base={"model": "enss_s"}), PAIR, {})
    assert none.reason == "no run of model=enss_s with model.warp_at=target, nor with model.warp_at=low"
    unscored = judged(claim(metric="vmaf"), PAIR, {"late": clips(0.0), "early": clips(0.0)})
    assert unscored.verdict == "not run"
    assert "not all logged vmaf" in unscored.reason


def test_runs_that_differ_in_what_the_claim_does_not_name_are_not_compared() -> None:
    runs = [run("late", model__warp_at="target", loss="l1"), run("early", model__warp_at="low", loss="nsrr")]
    assert judged(claim(), runs, {"late": clips(1.0), "early": clips(0.0)}).verdict == "not run"


def test_seeds_are_averaged() -> None:
    runs = [run(f"late{seed}", model__warp_at="target", seed=seed) for seed in range(3)]
    runs += [run(f"early{seed}", model__warp_at="low", seed=seed) for seed in range(3)]
    tables = {f"late{seed}": clips(1.0 + 0.1 * (seed - 1)) for seed in range(3)}
    tables |= {f"early{seed}": clips(0.1 * (seed - 1)) for seed in range(3)}
    result = judged(claim(), runs, tables)
    assert result.verdict == "reproduced"
    assert result.effect is not None
    assert result.effect.mean == pytest.approx(1.0)
    assert result.effect.half_width > 0.1


def test_logged_numbers_compare_without_interval() -> None:
    runs = [
        run("late", metrics={"model/parameters": 500.0}, model__warp_at="target"),
        run("early", metrics={"model/parameters": 800.0}, model__warp_at="low"),
    ]
    result = judged(claim("less", metric="run:model/parameters"), runs, {})
    assert result.verdict == "reproduced"
    assert result.effect is not None
    assert result.effect.mean == -300
    assert result.scenes == {}
    assert judged(claim(metric="run:model/parameters"), runs, {}).verdict == "contradicted"
    assert judged(claim(metric="run:model/gmac"), runs, {}).verdict == "not run"


@pytest.mark.parametrize(("late_ms", "verdict"), [(79.0, "reproduced"), (81.0, "contradicted")])
def test_less_by_a_factor_requires_the_factor(late_ms: float, verdict: str) -> None:
    runs = [
        run("late", metrics={"time/onnxruntime/ms": late_ms}, model__warp_at="target"),
        run("early", metrics={"time/onnxruntime/ms": 800.0}, model__warp_at="low"),
    ]
    result = judged(claim("less", metric="run:time/onnxruntime/ms", times=10), runs, {})
    assert result.verdict == verdict
    assert result.effect is not None
    assert result.effect.mean == late_ms - 800.0


def test_each_step_over_the_task_uses_its_own_data_set() -> None:
    steps = [Series(f"{n}×{n}", {"task.scale": str(n)}) for n in (2, 4)]
    runs = [run("two", dataset="bbbb", task__scale=2, data__train__window="192"), run("four", data__train__window="96")]
    result = judged(claim("falls", steps=steps), runs, {"two": clips(5.0), "four": clips(0.0)})
    assert result.verdict == "reproduced"
    assert str(result.selected.setting).startswith("2×2 and 4×4")


def test_all_sides_use_the_same_of_several_values() -> None:
    statement = claim(base={"model": "nsrr", "model.demodulate": "lighting|log_lighting"})
    runs = [
        run("late", model__warp_at="target", model__demodulate="lighting"),
        run("late_log", model__warp_at="target", model__demodulate="log_lighting"),
        run("early_log", model__warp_at="low", model__demodulate="log_lighting"),
    ]
    result = choose_claim(statement, choose(runs, None, None))
    assert {label: [r.name for r in chosen] for label, chosen in result.runs.items()} == {
        "a": ["late_log"],
        "b": ["early_log"],
    }


def test_sides_that_are_the_same_runs_decide_nothing() -> None:
    statement = claim(a={"model": "nsrr"}, b={"model.warp_at": "low"})
    result = judged(statement, PAIR[1:], {"early": clips(0.0)})
    assert result.verdict == "unresolved"
    assert "same runs" in result.reason


def test_printed_row_and_long_form() -> None:
    gains = dict(zip(SCENES, (0.9, 1.1, 1.0, 1.2, 0.8, 1.0)))
    result = judged(claim(published=-0.26, needs="Ours has no text"), PAIR, {"late": clips(gains), "early": clips(0.0)})
    (row,) = rows([result], {"late": "R1", "early": "R2"})
    assert row["published"] == "−0.26 dB"
    assert row["ours"] == "+1.00 dB"
    low, high = map(float, row["interval"].split(" to "))
    assert (low, high) == pytest.approx((1 - 0.148, 1 + 0.148), abs=0.015)
    assert row["runs"] == "a: R1; b: R2"
    assert row["more"] == "Holds on 6 of 6 scenes. Ours has no text."
    assert [number for _, number, _ in counts([result])] == [1, 0, 0, 0]
    (line,) = long_form([result])
    assert line["low_95"] < line["ours"] < line["high_95"]  # type: ignore[operator]
    assert line["runs"] == "b: early; a: late"
