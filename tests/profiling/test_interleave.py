"""The order of rounds, and what becomes of cases that do not run, with workers that compute nothing."""

import math

import pytest

from supersampling.profiling import interleave, memory
from supersampling.profiling.ceiling import Ceiling
from supersampling.profiling.interleave import Rounds, in_turn, measure
from supersampling.profiling.parts import Part
from supersampling.profiling.worker import Case, Ceilings, Failed


def case(name, size=(8, 8), precision="float32"):
    return Case(name, {"_target_": "x"}, 2, "thesis", size, "eager", {"_target_": "y"}, precision, "cpu", 1)


class Factory:
    """Makes workers, and writes down what is asked of them. Those of ``big`` run alone only, ``lost`` end in round 2, ``none`` do
    not even load."""

    def __init__(self, big=(), lost=(), none=()):
        self.big, self.lost, self.none = big, lost, none
        self.asked, self.live, self.most = [], [], 0
        self.limits = {}

    def __call__(self, threads, limit, make, *arguments):
        name = "ceiling" if make is Ceilings else arguments[0].method
        if name != "ceiling":
            self.limits[name] = limit
            if name in self.none:
                raise Failed("It cannot.")
            if name in self.big and [n for n in self.live if n != "ceiling"]:
                raise Failed("It needs more memory than there is.", memory=True)
        self.live.append(name)
        return Fake(self, name)


class Fake:
    def __init__(self, factory, name):
        self.factory, self.name, self.times, self.open = factory, name, 0, True

    def ask(self, name, *values):
        assert self.open
        if name == "transient":
            return 5e9 if self.name == "a" else 0
        if name == "measure":
            self.times += 1
            # The best of each, which are in different rounds.
            return Ceiling((1e9, 3e9, 2e9)[self.times - 1], (7.0, 5.0, 6.0)[self.times - 1])
        if name == "peak":
            return 42.0
        if name == "parts":
            return [Part("all", "X", 1.0, 1.0, 1.0, 1.0)]
        self.times += 1
        self.factory.asked.append(self.name)
        if self.name in self.factory.lost and self.times == 2:
            raise Failed("It is gone.")
        return [self.times * 1.0] * values[0]

    def close(self):
        if self.open:
            self.factory.live.remove(self.name)
        self.open = False


def run(cases, factory, rounds=3):
    found = measure(cases, Rounds(rounds, 2, 1.0, 1), factory, say=lambda text: None)
    assert factory.live == []  # every process was ended
    return found


def test_each_round_begins_with_the_next():
    factory = Factory()
    found = run([case("a"), case("b"), case("c")], factory)
    assert "".join(factory.asked) == "abc" + "bca" + "cab"
    for outcome in found:
        assert outcome.seconds == [1.0, 1.0, 2.0, 2.0, 3.0, 3.0]
        assert outcome.ceiling == Ceiling(3e9, 7.0)
        assert outcome.peak == 42.0
        assert [p.part for p in outcome.parts] == ["all"]


def test_everyone_follows_everyone_as_often():
    orders = [tuple(in_turn(5, turn)) for turn in range(5)]
    assert all(sorted(order) == [0, 1, 2, 3, 4] for order in orders)
    assert sorted(order[0] for order in orders) == [0, 1, 2, 3, 4]


def test_sizes_are_taken_one_after_the_other_and_given_back_in_order():
    factory = Factory()
    cases = [case("a", (16, 8)), case("b"), case("c", (16, 8)), case("d")]
    found = run(cases, factory, rounds=1)
    assert "".join(factory.asked) == "bd" + "ac"
    assert [o.case for o in found] == cases


def test_what_does_not_fit_beside_the_others_follows_alone():
    factory = Factory(big=("a", "c"))
    found = run([case("b"), case("a"), case("c")], factory, rounds=2)
    assert "".join(factory.asked) == "bb" + "aa" + "cc"
    assert all(len(o.seconds) == 4 and not o.why for o in found)


def test_what_does_not_run_says_why_and_stops_nobody():
    factory = Factory(none=("a",), lost=("b",))
    a, b, c = run([case("a"), case("b"), case("c")], factory)
    assert (a.why, b.why, c.why) == ("It cannot.", "It is gone.", "")
    assert (a.seconds, b.seconds) == ([], [])
    assert math.isnan(a.peak)
    assert len(c.seconds) == 6
    assert factory.asked.count("b") == 2


def test_those_that_are_loaded_keep_the_memory_that_they_run_in(monkeypatch):
    monkeypatch.setattr(memory, "available", lambda: 20 * 10**9)
    factory = Factory()
    run([case("a"), case("b")], factory)
    spare = 20 * 10**9 - interleave.SPARE
    assert factory.limits == {"a": spare, "b": spare - 5 * 10**9}


def test_nothing_is_loaded_where_hardly_any_memory_is_left(monkeypatch):
    free = iter([20 * 10**9, interleave.SPARE + 5 * 10**9 + interleave.LEAST - 1, 20 * 10**9])
    monkeypatch.setattr(memory, "available", lambda: next(free))
    factory = Factory()
    a, b = run([case("a"), case("b")], factory, rounds=2)
    assert "".join(factory.asked) == "aabb"
    assert (a.why, b.why) == ("", "")


@pytest.mark.parametrize("precisions", [("float32",), ("float32", "bfloat16")])
def test_a_ceiling_for_each_precision(precisions):
    made = []

    class Counting(Factory):
        def __call__(self, threads, limit, make, *arguments):
            made.extend([arguments] if make is Ceilings else [])
            return super().__call__(threads, limit, make, *arguments)

    run([case("a", precision=p) for p in (*precisions, *precisions)], Counting())
    assert made == [("cpu", p) for p in precisions]
