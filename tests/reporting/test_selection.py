"""The choice of the runs of each cell, on example runs."""

from typing import Any

import pytest
from example_runs import example_run

from supersampling.errors import UserError
from supersampling.reporting.selection import choose_runs, matches, newest_per_seed, pools_for
from supersampling.reporting.settings import choose
from supersampling.runs.store import Run


def run(name: str, ended: int = 0, dataset: str = "aaaa", **params: Any) -> Run:
    """Return an example run, with a budget if its model is trained."""
    budget = {} if params.get("model") == "jau" else {"budget": "laptop"}
    return example_run(name, ended, dataset, **{**budget, **params})


def names(runs: list[Run]) -> list[str]:
    return [r.name for r in runs]


def test_numbers_match_as_numbers_and_absence_matches_nothing() -> None:
    item = run("a", loss__theta=0.1, task__scale=4)
    assert matches(item, {"loss.theta": "0.10", "task.scale": "4.0"})
    assert not matches(item, {"loss.theta": "0.5"})
    assert not matches(item, {"model.dilate": "none"})


def test_the_data_set_with_most_runs_is_chosen_and_the_newest_of_equals() -> None:
    many = [run("a1", 1), run("a2", 2)]
    assert choose([*many, run("b1", 9, "bbbb")], None, None).setting.dataset == "aaaa"
    assert choose([*many, run("b1", 9, "bbbb"), run("b2", 3, "bbbb")], None, None).setting.dataset == "bbbb"
    assert choose([*many, run("b1", 9, "bbbb")], "bb", None).setting.dataset == "bbbb"


def test_a_chosen_data_set_keeps_others_out() -> None:
    runs = [run("a1"), run("a2"), run("b", dataset="bbbb", task__scale=2)]
    pool = next(iter(pools_for(choose(runs, None, None), [{"task.scale": "2"}], {})), None)
    assert pool is not None
    assert names(pool[1]) == ["b"]
    assert pools_for(choose(runs, "aa", None), [{"task.scale": "2"}], {}) == []


def test_budgets_never_mix_but_untrained_methods_join() -> None:
    runs = [run("a"), run("b"), run("smoke", budget="smoke"), run("jau", model="jau")]
    laptop, smoke = choose(runs, None, None), choose(runs, None, "smoke")
    assert names(laptop.pools[laptop.setting]) == ["a", "b", "jau"]
    assert names(smoke.pools[smoke.setting]) == ["smoke", "jau"]
    assert len(laptop.pools) == 1


def test_unknown_choices_list_the_known_ones() -> None:
    runs = [run("a", dataset="aa11"), run("b", dataset="aa22")]
    with pytest.raises(UserError, match="Several data sets begin with dataset=aa: choose one of aa11, aa22"):
        choose(runs, "aa", None)
    with pytest.raises(UserError, match="No finished run has budget=paper: choose one of laptop"):
        choose(runs, None, "paper")


CELLS = {"with": {"model.accumulate": "buffer"}, "without": {"model.accumulate": "none"}}


def test_compared_cells_agree_in_what_no_cell_selects() -> None:
    runs = [
        run("sig buffer", 9, model__accumulate="buffer", model__confine="sigmoid"),
        run("clamp buffer", 1, model__accumulate="buffer", model__confine="clamp"),
        run("clamp none", 2, model__accumulate="none", model__confine="clamp"),
    ]
    selection = choose_runs(runs, CELLS)
    assert {key: names(members) for key, members in selection.cells.items()} == {
        "with": ["clamp buffer"],
        "without": ["clamp none"],
    }
    assert names(selection.left_out) == ["sig buffer"]


def test_a_cell_that_only_another_configuration_could_fill_stays_empty() -> None:
    runs = [
        run("a", model__accumulate="buffer", model__confine="sigmoid", seed=0),
        run("b", model__accumulate="buffer", model__confine="sigmoid", seed=1),
        run("c", model__accumulate="none", model__confine="clamp"),
    ]
    selection = choose_runs(runs, CELLS)
    assert names(selection.cells["with"]) == ["a", "b"]
    assert selection.cells["without"] == []
    assert names(selection.left_out) == ["c"]


def test_what_belongs_to_a_swept_parameter_may_differ() -> None:
    runs = [
        run("9", model__reproject="bicubic9", model__reproject__a=-0.75),
        run("5", model__reproject="bicubic5", model__reproject__a=-0.5),
    ]
    cells = {name: {"model.reproject": f"bicubic{name}"} for name in ("9", "5")}
    assert {key: names(members) for key, members in choose_runs(runs, cells).cells.items()} == {"9": ["9"], "5": ["5"]}


def test_the_newest_run_of_a_seed_counts_once() -> None:
    runs = [run("old", 1, seed=0), run("ten", 1, seed=10), run("new", 2, seed=0), run("two", 1, seed=2)]
    assert names(newest_per_seed(runs)) == ["new", "two", "ten"]
