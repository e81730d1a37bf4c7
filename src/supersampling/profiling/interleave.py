"""Many cases timed in turn, round after round, so that what else the machine does falls on all of them alike."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import Any, Protocol

from supersampling.profiling import memory
from supersampling.profiling.ceiling import Ceiling
from supersampling.profiling.parts import Part
from supersampling.profiling.worker import Case, Ceilings, Failed, Held, Worker

SPARE = 2**30  # bytes of memory that are left to the rest of the machine
LEAST = 2**30  # bytes below which no further case is begun
CEILING_RUNS = 3  # a round


@dataclass(frozen=True)
class Rounds:
    """How long each case is timed: rounds, and in each so many frames, or as many as begin within so many seconds.

    ``depth`` is that of the parts' table, of as many frames as a round has; 0 leaves it out.
    """

    rounds: int
    frames: int
    seconds: float
    depth: int


@dataclass
class Outcome:
    """Of a case: seconds of each frame, bytes at the peak and its parts, or why it does not run."""

    case: Case
    seconds: list[float] = field(default_factory=list)
    peak: float = float("nan")
    parts: list[Part] = field(default_factory=list)
    ceiling: Ceiling | None = None
    why: str = ""


class Asked(Protocol):
    """What `Worker` is."""

    def ask(self, name: str, *values: Any) -> Any: ...
    def close(self) -> None: ...


Start = Callable[..., Asked]
Say = Callable[[str], object]


def in_turn(count: int, turn: int) -> Iterator[int]:
    """The order of a round: each begins with the next, so that none always follows the same pause."""
    return ((k + turn) % count for k in range(count))


def measure(cases: Sequence[Case], rounds: Rounds, start: Start = Worker, say: Say = print) -> list[Outcome]:
    """The outcome of each case, in their order. Those of one size are interleaved; what does not fit into memory beside the
    others gets rounds of its own afterwards."""
    outcomes = [Outcome(case) for case in cases]
    by_size = sorted(outcomes, key=lambda o: o.case.size)
    for size, group in groupby(by_size, key=lambda o: o.case.size):
        waiting = list(group)
        say(f"{size[0]}x{size[1]}: {len(waiting)} combinations")
        while waiting:
            waiting = _Batch(rounds, start, say).run(waiting)
    return outcomes


class _Batch:
    """Cases that are loaded at the same time."""

    def __init__(self, rounds: Rounds, start: Start, say: Say) -> None:
        self._rounds, self._start, self._say = rounds, start, say
        self._live: list[tuple[Outcome, Asked]] = []
        self._ceilings: dict[str, Asked] = {}
        self._reached: dict[str, Ceiling] = {}
        self._transient = 0.0  # bytes that one of the loaded needs again while it runs

    def run(self, waiting: Sequence[Outcome]) -> list[Outcome]:
        """Time all that fit into memory together; gives the others."""
        try:
            later = self._load(waiting)
            for turn in range(self._rounds.rounds):
                self._round(turn)
            for outcome, worker in self._live:
                self._finish(outcome, worker)
            return later
        finally:
            for worker in (*self._ceilings.values(), *(w for _, w in self._live)):
                worker.close()

    def _load(self, waiting: Sequence[Outcome]) -> list[Outcome]:
        later: list[Outcome] = []
        for outcome in waiting:
            case = outcome.case
            allowed = self._allowed(case)
            if self._live and allowed is not None and allowed < LEAST:
                later.append(outcome)
                continue
            self._say(f"  {_name(case)}: loading")
            try:
                if case.precision not in self._ceilings:
                    worker = self._start(case.threads, None, Ceilings, case.device, case.precision)
                    self._ceilings[case.precision] = worker
                worker = self._start(case.threads, allowed, Held, case)
                self._live.append((outcome, worker))
                self._transient = max(self._transient, worker.ask("transient"))
            except Failed as error:
                if error.memory and self._live:  # beside these, there is too little
                    later.append(outcome)
                else:
                    self._give_up(outcome, error)
        return later

    def _allowed(self, case: Case) -> int | None:
        """Bytes that a further case may take, so that those which are loaded can go on."""
        free = memory.available()
        if free is None or case.device != "cpu":
            return None
        return int(max(free - SPARE - self._transient, 0))

    def _round(self, turn: int) -> None:
        self._say(f"  round {turn + 1} of {self._rounds.rounds}")
        for precision, worker in self._ceilings.items():
            new = worker.ask("measure", CEILING_RUNS)
            old = self._reached.get(precision, new)
            self._reached[precision] = Ceiling(max(old.macs, new.macs), max(old.bytes, new.bytes))
        for k in in_turn(len(self._live), turn) if self._live else ():
            outcome, worker = self._live[k]
            if outcome.why:
                continue
            try:
                outcome.seconds += worker.ask("time", self._rounds.frames, self._rounds.seconds)
            except Failed as error:
                self._give_up(outcome, error)
                worker.close()

    def _finish(self, outcome: Outcome, worker: Asked) -> None:
        if outcome.why:
            return
        outcome.ceiling = self._reached[outcome.case.precision]
        try:
            outcome.peak = worker.ask("peak")
            if self._rounds.depth:
                outcome.parts = worker.ask("parts", self._rounds.depth, self._rounds.frames)
        except Failed as error:
            self._give_up(outcome, error)

    def _give_up(self, outcome: Outcome, error: Failed) -> None:
        outcome.why, outcome.seconds = str(error), []
        self._say(f"  {_name(outcome.case)}: {error}")


def _name(case: Case) -> str:
    return f"{case.method} x{case.scale} {case.name} {case.precision}"
