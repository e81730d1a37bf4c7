"""Timing of many cases in turn, round after round, so that other load on the machine affects all of them alike."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import Any, Protocol

import torch

from supersampling.profiling import memory
from supersampling.profiling.ceiling import Ceiling
from supersampling.profiling.parts import Part
from supersampling.profiling.worker import Case, CaseError, CeilingMeter, LoadedCase, Worker

SPARE = 2**30  # bytes of memory that are left to the rest of the machine
LEAST = 2**30  # free bytes below which no further case is started
CEILING_RUNS = 3  # per round


@dataclass(frozen=True)
class Rounds:
    """Number of rounds, and the length of each: ``frames`` per case, or as many as begin within ``seconds``.

    ``depth`` is that of the table of parts, which is measured over ``frames`` frames; 0 leaves the table out.
    """

    rounds: int
    frames: int
    seconds: float
    depth: int


@dataclass(kw_only=True)
class Outcome:
    """Result of a case: seconds of each frame, bytes at the peak and parts; or the reason why it does not run."""

    case: Case
    seconds: list[float] = field(default_factory=list)
    peak: float = float("nan")
    parts: list[Part] = field(default_factory=list)
    ceiling: Ceiling | None = None
    reason: str = ""


class RemoteObject(Protocol):
    """The interface of `Worker`."""

    def call(self, name: str, *values: Any) -> Any: ...
    def close(self) -> None: ...


Start = Callable[..., RemoteObject]
Report = Callable[[str], object]


def rotation(count: int, turn: int) -> Iterator[int]:
    """Yield the order of a round: each begins with the next case, so that no case always follows the same pause."""
    return ((k + turn) % count for k in range(count))


def measure(cases: Sequence[Case], rounds: Rounds, start: Start = Worker, report: Report = print) -> list[Outcome]:
    """Return the outcome of each case, in the order of ``cases``.

    Cases of one size are interleaved. Those that do not fit into memory beside the others have rounds of their own
    afterwards.
    """
    outcomes = [Outcome(case=case) for case in cases]
    by_size = sorted(outcomes, key=lambda o: o.case.size)
    for size, group in groupby(by_size, key=lambda o: o.case.size):
        waiting = list(group)
        report(f"{size[0]}x{size[1]}: {len(waiting)} combinations")
        while waiting:
            waiting = _Batch(rounds, start, report).run(waiting)
    return outcomes


class _Batch:
    """Cases that are loaded at the same time."""

    def __init__(self, rounds: Rounds, start: Start, report: Report) -> None:
        self._rounds, self._start, self._report = rounds, start, report
        self._live: list[tuple[Outcome, RemoteObject]] = []
        self._meters: dict[str, RemoteObject] = {}
        self._ceilings: dict[str, Ceiling] = {}
        self._transient = 0.0  # the most bytes that a loaded case needs while it runs, beyond those between frames

    def run(self, waiting: Sequence[Outcome]) -> list[Outcome]:
        """Time all cases that fit into memory together; return the remaining ones."""
        try:
            later = self._load(waiting)
            for turn in range(self._rounds.rounds):
                self._round(turn)
            for outcome, worker in self._live:
                self._finish(outcome, worker)
            return later
        finally:
            for worker in (*self._meters.values(), *(w for _, w in self._live)):
                worker.close()

    def _load(self, waiting: Sequence[Outcome]) -> list[Outcome]:
        later: list[Outcome] = []
        for outcome in waiting:
            case = outcome.case
            limit = self._memory_limit(case)
            if self._live and limit is not None and limit < LEAST:
                later.append(outcome)
                continue
            self._report(f"  {_label(case)}: loading")
            try:
                if case.precision not in self._meters:
                    worker = self._start(case.threads, None, CeilingMeter, case.device, case.precision)
                    self._meters[case.precision] = worker
                worker = self._start(case.threads, limit, LoadedCase, case)
                self._live.append((outcome, worker))
                self._transient = max(self._transient, worker.call("transient"))
            except CaseError as error:
                if error.memory and self._live:  # it may fit without the cases that are loaded
                    later.append(outcome)
                else:
                    self._give_up(outcome, error)
        return later

    def _memory_limit(self, case: Case) -> int | None:
        """Return the bytes that a further case may use so that the loaded ones can go on; None for no limit."""
        free = memory.available(torch.device("cpu"))
        if free is None or case.device != "cpu":
            return None
        return int(max(free - SPARE - self._transient, 0))

    def _round(self, turn: int) -> None:
        self._report(f"  round {turn + 1} of {self._rounds.rounds}")
        for precision, worker in self._meters.items():
            new = worker.call("measure", CEILING_RUNS)
            old = self._ceilings.get(precision, new)
            self._ceilings[precision] = Ceiling(max(old.macs, new.macs), max(old.bytes, new.bytes))
        for k in rotation(len(self._live), turn) if self._live else ():
            outcome, worker = self._live[k]
            if outcome.reason:
                continue
            try:
                outcome.seconds += worker.call("time", self._rounds.frames, self._rounds.seconds)
            except CaseError as error:
                self._give_up(outcome, error)
                worker.close()

    def _finish(self, outcome: Outcome, worker: RemoteObject) -> None:
        if outcome.reason:
            return
        outcome.ceiling = self._ceilings[outcome.case.precision]
        try:
            outcome.peak = worker.call("peak")
            if self._rounds.depth:
                outcome.parts = worker.call("parts", self._rounds.depth, self._rounds.frames)
        except CaseError as error:
            self._give_up(outcome, error)

    def _give_up(self, outcome: Outcome, error: CaseError) -> None:
        outcome.reason, outcome.seconds = str(error), []
        self._report(f"  {_label(outcome.case)}: {error}")


def _label(case: Case) -> str:
    return f"{case.method} x{case.scale} {case.backend} {case.precision}"
