"""The runs that a name selects, their comparison, and the conditions for a verdict."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from example_runs import example_run

from supersampling.errors import UserError
from supersampling.reporting.comparison import compare, text, verdict
from supersampling.reporting.format import decimals, plus_minus
from supersampling.reporting.seeds import Group, find_groups, pair, seed_groups
from supersampling.runs.statistics import Estimate
from supersampling.runs.store import Run


def run(name: str, *args: Any, method: str = "", **params: Any) -> Run:
    """Return an example run whose method is called like its model."""
    return example_run(name, *args, method=method or params.get("model", "dlctus"), **params)


def names(groups: list[Group]) -> list[list[str]]:
    return [[r.id for r in group.runs] for group in groups]


def test_runs_that_differ_in_seed_alone_are_one_group():
    runs = [run(f"s{seed}", seed=seed, budget="laptop", loss="l1") for seed in (2, 0, 10)]
    assert names(seed_groups([*runs, run("again", 1, seed=0, budget="laptop", loss="l1")])) == [["again", "s2", "s10"]]


@pytest.mark.parametrize(
    "change",
    [
        {"augment": "none"},
        {"pick": "uniform"},
        {"loss": "mse"},
        {"optimizer__lr": 1},
        {"budget": "paper"},
        {"budget__steps": 9},
        {"model__dilate": "closest"},
        {"task__jitter": "halton"},
        {"task__scale": 2},
        {"trainer__precision": "bf16"},
        {"data__train__clips": 9},
        {"dataset": "bbbb"},
    ],
)  # fmt: skip
def test_any_difference_but_the_seed_separates_groups(change):
    args = {
        "augment": "full", "pick": "edges", "loss": "l1", "optimizer__lr": 2, "budget": "laptop", "budget__steps": 8,
        "model__dilate": "none", "task__jitter": "thesis", "trainer__precision": "32", "data__train__clips": 8,
    }  # fmt: skip
    assert len(seed_groups([run("a", **args, seed=0), run("b", **{**args, **change}, seed=1)])) == 2


def test_settings_without_influence_on_results_do_not_separate_groups():
    runs = [run("a", seed=0, data__workers=1, trainer__accelerator="cpu"), run("b", seed=1, data__workers=4)]
    assert names(seed_groups(runs)) == [["a", "b"]]


RUNS = [
    run("d0", seed=0, loss__theta=0.1),
    run("d1", seed=1, loss__theta=0.1),
    run("dt", seed=0, loss__theta=0.5),
    run("t0", model="tus"),
    run("t1", model="tus", method="tus rectify=none", model__rectify="none"),
]


def test_a_name_finds_its_groups():
    assert names(find_groups(RUNS, "a", "dlctus loss.theta=0.10")) == [["d0", "d1"]]
    assert names(find_groups(RUNS, "a", "tus")) == [["t0"]]  # the published stages
    assert names(find_groups(RUNS, "a", "tus rectify=none")) == [["t1"]]
    assert names(find_groups(RUNS, "a", "model=tus model.rectify=none")) == [["t1"]]
    assert names(find_groups(RUNS, "a", "d1")) == [["d1"]]  # a run alone


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("nothing", "choose one of dlctus, tus"),
        ("d", "ids of several runs begin with a=d"),
        ("tus dlctus", "names 2 methods"),
        ("tus rectify=x", "No finished run or method is called a=tus rectify=x"),
    ],
)
def test_name_without_a_match(name, message):
    with pytest.raises(UserError, match=message):
        find_groups(RUNS, "a", name)


def test_an_evaluation_is_found_by_its_id_alone():
    evaluation = replace(run("e5a1", model="tus", method="tus"), kind="evaluation")
    assert names(find_groups([*RUNS, evaluation], "a", "tus")) == [["t0"]]
    assert names(find_groups([*RUNS, evaluation], "a", "e5")) == [["e5a1"]]
    assert names(find_groups([evaluation], "a", "e5a1")) == [["e5a1"]]
    with pytest.raises(UserError, match="No finished run or method is called a=tus: use a run's id"):
        find_groups([evaluation], "a", "tus")
    printed = text(
        A, alone := Group(A.setting, [evaluation]), compare(A, alone, more := tables() | {"e5a1": tables()["t0"]}), more
    )
    assert "b: tus, not trained, evaluation e5a1" in printed


def test_the_same_mip_bias_comes_first_and_another_can_be_compared():
    runs = [run("m", model="tus"), run("n", model="tus", task__mip_bias="none"), run("o", model="jau")]
    tus = find_groups(runs, "a", "tus")
    assert pair(tus, find_groups(runs, "b", "o"))[0].runs[0].id == "m"
    assert pair(find_groups(runs, "a", "n"), find_groups(runs, "b", "o"))[0].runs[0].id == "n"
    with pytest.raises(UserError, match="a names 2 configurations"):
        pair(tus, find_groups([*runs, run("p", model="mine", task__mip_bias="unknown")], "b", "p"))


def test_a_pair_shares_its_test_data_and_is_one():
    dlctus, tus = find_groups(RUNS, "a", "dlctus"), find_groups(RUNS, "b", "tus")
    with pytest.raises(UserError, match=r"a names 2 configurations.*d0 loss.theta=0.1; dt loss.theta=0.5"):
        pair(dlctus, tus)
    elsewhere = seed_groups([run("e", dataset="bbbb", model="jau")])
    with pytest.raises(UserError, match="share no test data"):
        pair(elsewhere, tus)
    a, b = pair(find_groups([*RUNS, *elsewhere[0].runs], "a", "d0"), tus)
    assert (a.runs[0].id, b.runs[0].id) == ("d0", "t0")


def table(psnr: np.ndarray, **more: np.ndarray) -> pd.DataFrame:
    places = [(f"scene{s}", c) for s in range(9) for c in range(4)]
    return pd.DataFrame(places, columns=["scene", "clip"]).assign(psnr=psnr, **more)


def tables() -> dict[str, pd.DataFrame]:
    rng = np.random.default_rng(0)
    hard = rng.normal(30, 5, 36)

    def of(gain: float, scatter: float) -> pd.DataFrame:
        psnr = hard + gain + rng.normal(0, scatter, 36)
        return table(psnr, temporal=10 ** (-psnr / 20), ssim=hard / 50, secret=psnr, spatial=rng.normal(0, 1, 36))

    return {"d0": of(0.9, 0.2), "d1": of(1.1, 0.2), "t0": of(0, 0.2)}


A, B = Group(find_groups(RUNS, "a", "d0")[0].setting, RUNS[:2]), find_groups(RUNS, "b", "tus")[0]


def test_each_metric_has_its_verdict():
    scores = {item.metric: item for item in compare(A, B, tables())}
    assert {name: item.verdict for name, item in scores.items()} == {
        "psnr": "dlctus is better",
        "temporal": "dlctus is better",
        "ssim": "equal on every clip",
        "secret": "a is higher",
        "spatial": "unresolved",
    }
    swapped = {item.metric: item for item in compare(B, A, tables())}
    assert swapped["psnr"].verdict == "dlctus is better"
    assert swapped["psnr"].difference.mean == pytest.approx(-scores["psnr"].difference.mean)
    # By hand: the mean over seeds of the means over clips.
    t = tables()
    by_hand = (t["d0"].psnr.mean() + t["d1"].psnr.mean()) / 2 - t["t0"].psnr.mean()
    assert scores["psnr"].difference.mean == pytest.approx(by_hand)
    assert scores["psnr"].a.half_width > 3 * scores["psnr"].difference.half_width


def test_no_winner_without_an_interval_that_excludes_zero():
    assert verdict("psnr", Estimate(1, -0.1, 2, 9), "x", "y") == "unresolved"
    assert verdict("psnr", Estimate(1, 0.0, 2, 9), "x", "y") == "unresolved"
    assert verdict("psnr", Estimate(1, math.nan, math.nan, 1), "x", "y") == "no interval"
    assert verdict("psnr", Estimate(-1, -2, -0.5, 9), "x", "y") == "y is better"
    assert verdict("temporal", Estimate(-1, -2, -0.5, 9), "x", "y") == "x is better"
    assert verdict("warping_error_ratio", Estimate(-1, -2, -0.5, 9), "x", "y") == "a is lower"


def test_missing_and_infinite_values_are_reported():
    scores = tables()
    scores["t0"].loc[3, "psnr"] = np.nan
    scores["d0"].loc[5, "ssim"] = np.inf
    compared = compare(A, B, scores, ["psnr", "ssim"])
    assert [item.difference.clips for item in compared] == [35, 36]
    printed = text(A, B, compared, scores)
    assert "psnr: 1 clip left out" in printed
    assert "ssim is infinite on a clip" in printed
    assert "no interval" in printed


def test_printed_text_describes_its_population():
    printed = text(A, B, compare(A, B, tables()), tables())
    assert "a: dlctus theta=0.1, seeds 0, 1, runs d0 d1" in printed
    assert "b: tus, not trained, run t0" in printed
    assert "36 clips of 9 scenes" in printed
    assert "two seeds" in printed
    assert "unknown which way is better" in printed
    one_clip = {name: scores[:1] for name, scores in tables().items()}
    assert "1 clip of 1 scene: one clip has no interval" in text(A, B, compare(A, B, one_clip), one_clip)
    alone = Group(A.setting, A.runs[:1])
    assert "one seed" in text(alone, B, compare(alone, B, tables()), tables())


def test_two_runs_of_one_method_are_distinguished():
    first, second = Group(A.setting, RUNS[:1]), Group(A.setting, RUNS[1:2])
    scores = tables()
    scores["d1"]["psnr"] += 3
    scores["dt"] = scores["d0"]
    assert compare(Group(A.setting, RUNS[2:3]), second, scores, ["psnr"])[0].verdict == "dlctus theta=0.1 is better"
    assert compare(first, second, scores, ["psnr"])[0].verdict == "b is better"


def test_incomparable_groups():
    with pytest.raises(UserError, match="choose from psnr, temporal"):
        compare(A, B, tables(), ["flip"])
    with pytest.raises(UserError, match="No metric is common to"):
        compare(A, B, tables() | {"t0": table(np.zeros(36)).rename(columns={"psnr": "vmaf"})})
    with pytest.raises(UserError, match="Run t0 has no table"):
        compare(A, B, {key: value for key, value in tables().items() if key != "t0"})
    apart = tables()
    apart["t0"]["scene"] = "elsewhere"
    with pytest.raises(UserError, match="No clip with a value of psnr is common to"):
        compare(A, B, apart)


def test_numbers_show_two_digits_of_their_half_width():
    assert [decimals(h) for h in (2.34, 0.234, 0.00234, 23.4, 0.0, math.nan)] == [1, 2, 4, 0, 4, 4]
    assert [decimals(h) for h in (9.94, 9.96, 0.0996, 234)] == [1, 0, 2, 0]  # 9.9, 10, 0.10, 234
    for value, expected in (
        (Estimate(31.2345, 30.0, 32.4, 36), "31.2 ± 1.2"),
        (Estimate(31.2345, math.nan, math.nan, 1), "31.2345"),
    ):
        assert plus_minus(value, decimals(value.half_width)) == expected
