"""Order of rounds, and cases that do not run, with workers that compute nothing."""

import math

import pytest

from supersampling.profiling import interleave, memory
from supersampling.profiling.ceiling import Ceiling
from supersampling.profiling.interleave import Rounds, measure, rotation
from supersampling.profiling.parts import Part
from supersampling.profiling.worker import Case, CaseError, CeilingMeter


def case(name, size=(8, 8), precision="float32"):
    return Case(
        method=name,
        model={"_target_": "x"},
        scale=2,
        jitter="thesis",
        size=size,
        backend="eager",
        backend_config={"_target_": "y"},
        precision=precision,
        device="cpu",
        threads=1,
    )


class Factory:
    """A factory of workers that records the order of their calls.

    Cases of ``big`` load only if no other case is loaded, those of ``lost`` end in round 2, those of ``broken`` do not
    load.
    """

    def __init__(self, big=(), lost=(), broken=()):
        self.big, self.lost, self.broken = big, lost, broken
        self.timed, self.live, self.limits = [], [], {}

    def __call__(self, threads, limit, make, *arguments):
        name = "ceiling" if make is CeilingMeter else arguments[0].method
        if name != "ceiling":
            self.limits[name] = limit
            if name in self.broken:
                raise CaseError("It cannot.")
            if name in self.big and [n for n in self.live if n != "ceiling"]:
                raise CaseError("It needs more memory than there is.", memory=True)
        self.live.append(name)
        return FakeWorker(self, name)


class FakeWorker:
    def __init__(self, factory, name):
        self.factory, self.name, self.times, self.open = factory, name, 0, True

    def call(self, name, *values):
        assert self.open
        if name == "transient":
            return 5e9 if self.name == "a" else 0
        if name == "measure":
            self.times += 1
            # The highest rates are in different rounds.
            return Ceiling((1e9, 3e9, 2e9)[self.times - 1], (7.0, 5.0, 6.0)[self.times - 1])
        if name == "peak":
            return 42.0
        if name == "parts":
            return [Part(part="all", kind="X", ms=1.0, low=1.0, high=1.0, share=1.0)]
        self.times += 1
        self.factory.timed.append(self.name)
        if self.name in self.factory.lost and self.times == 2:
            raise CaseError("It is gone.")
        return [self.times * 1.0] * values[0]

    def close(self):
        if self.open:
            self.factory.live.remove(self.name)
        self.open = False


def run(cases, factory, rounds=3):
    outcomes = measure(cases, Rounds(rounds, 2, 1.0, 1), factory, report=lambda text: None)
    assert factory.live == []  # all processes were ended
    return outcomes


def test_order_of_rounds():
    factory = Factory()
    outcomes = run([case("a"), case("b"), case("c")], factory)
    assert "".join(factory.timed) == "abc" + "bca" + "cab"
    for outcome in outcomes:
        assert outcome.seconds == [1.0, 1.0, 2.0, 2.0, 3.0, 3.0]
        assert outcome.ceiling == Ceiling(3e9, 7.0)
        assert outcome.peak == 42.0
        assert [p.part for p in outcome.parts] == ["all"]


def test_rotation_starts_with_each_case_once():
    orders = [tuple(rotation(5, turn)) for turn in range(5)]
    assert all(sorted(order) == [0, 1, 2, 3, 4] for order in orders)
    assert sorted(order[0] for order in orders) == [0, 1, 2, 3, 4]


def test_sizes_are_timed_in_turn_and_outcomes_keep_the_order_of_cases():
    factory = Factory()
    cases = [case("a", (16, 8)), case("b"), case("c", (16, 8)), case("d")]
    outcomes = run(cases, factory, rounds=1)
    assert "".join(factory.timed) == "bd" + "ac"
    assert [o.case for o in outcomes] == cases


def test_cases_that_do_not_fit_together_are_timed_alone():
    factory = Factory(big=("a", "c"))
    outcomes = run([case("b"), case("a"), case("c")], factory, rounds=2)
    assert "".join(factory.timed) == "bb" + "aa" + "cc"
    assert all(len(o.seconds) == 4 and not o.reason for o in outcomes)


def test_failing_cases_have_a_reason_and_stop_no_other_case():
    factory = Factory(broken=("a",), lost=("b",))
    a, b, c = run([case("a"), case("b"), case("c")], factory)
    assert (a.reason, b.reason, c.reason) == ("It cannot.", "It is gone.", "")
    assert (a.seconds, b.seconds) == ([], [])
    assert math.isnan(a.peak)
    assert len(c.seconds) == 6
    assert factory.timed.count("b") == 2


def test_memory_limit_leaves_what_loaded_cases_need(monkeypatch):
    monkeypatch.setattr(memory, "available", lambda device: 20 * 10**9)
    factory = Factory()
    run([case("a"), case("b")], factory)
    spare = 20 * 10**9 - interleave.SPARE
    assert factory.limits == {"a": spare, "b": spare - 5 * 10**9}


def test_no_case_is_loaded_with_little_free_memory(monkeypatch):
    free = iter([20 * 10**9, interleave.SPARE + 5 * 10**9 + interleave.LEAST - 1, 20 * 10**9])
    monkeypatch.setattr(memory, "available", lambda device: next(free))
    factory = Factory()
    a, b = run([case("a"), case("b")], factory, rounds=2)
    assert "".join(factory.timed) == "aabb"
    assert (a.reason, b.reason) == ("", "")


@pytest.mark.parametrize("precisions", [("float32",), ("float32", "bfloat16")])
def test_ceiling_for_each_precision(precisions):
    meters = []

    class Counting(Factory):
        def __call__(self, threads, limit, make, *arguments):
            meters.extend([arguments] if make is CeilingMeter else [])
            return super().__call__(threads, limit, make, *arguments)

    run([case("a", precision=p) for p in (*precisions, *precisions)], Counting())
    assert meters == [("cpu", p) for p in precisions]
