"""Quality against time: each way to run each method of a data set, and the ways that no other beats in both."""

import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

from omegaconf import OmegaConf

from supersampling.errors import UserError
from supersampling.reporting.methods import Method
from supersampling.runs.estimates import ClipTables, difference, estimate
from supersampling.runs.method import CONFIGURATION
from supersampling.runs.options import restored
from supersampling.runs.statistics import Estimate
from supersampling.runs.store import Run, Store
from supersampling.runs.timing import Timing, architecture, former_architecture

EXACT = "float32"

Cost = tuple[str, str, str]
"""Architecture, backend, precision."""
Costs = Mapping[Cost, Estimate]


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """A method as one backend runs it in one precision: its quality, and how long a frame takes.

    ``cost`` is the measured change of the quality by the precision (negative for a loss), None for float32; ``quality``
    includes it.
    """

    label: str
    runs: tuple[Run, ...]
    quality: Estimate
    timing: Timing
    cost: Estimate | None = None

    @property
    def ms(self) -> float:
        return self.timing.ms

    @property
    def how(self) -> str:
        return f"{self.timing.backend} {self.timing.precision}"

    @property
    def images(self) -> tuple[Any, ...]:
        """A key that is equal for candidates whose images, and so quality, are the same."""
        precision = self.timing.precision
        return (*(run.id for run in self.runs), precision, "" if precision == EXACT else self.timing.backend)


@dataclass(frozen=True, order=True, kw_only=True)
class Place:
    """A place within which times compare: one machine, device, number of threads, and target size."""

    machine: str
    device: str
    threads: int
    width: int
    height: int

    @classmethod
    def of(cls, timing: Timing) -> "Place":
        return cls(
            machine=timing.machine,
            device=timing.device,
            threads=timing.threads,
            width=timing.width,
            height=timing.height,
        )

    def __str__(self) -> str:
        threads = f", {self.threads} threads" if self.device == "cpu" else ""
        return f"{self.width}x{self.height} on {self.device}{threads} ({self.machine})"


@dataclass(frozen=True)
class Architectures:
    """The `architecture` of each run by its id, and what the first scheme called each architecture."""

    by_run: Mapping[str, str]
    former: Mapping[str, str]

    @property
    def known(self) -> set[str]:
        return set(self.by_run.values())

    def current(self, name: str) -> str:
        """Return today's name of an architecture of either scheme."""
        return self.former.get(name, name)


def architectures(runs: Iterable[Run], store: Store) -> Architectures:
    """Return the architectures of the configurations that runs logged; a run without one is left out."""
    by_run, former = {}, {}
    for run, path in store.folders(list(runs), CONFIGURATION).items():
        config: Any = OmegaConf.to_container(OmegaConf.load(path), resolve=True)
        model, scale = config["model"], int(config["task"]["scale"])
        by_run[run] = architecture(model, scale)
        # A class that conf/model lacks has no former name, and must not end the report.
        with suppress(UserError):
            former[former_architecture(restored(model, f"Run {run}"), scale)] = by_run[run]
    return Architectures(by_run, former)


def list_candidates(
    methods: Iterable[Method],
    timings: Iterable[Timing],
    known: Mapping[str, str],
    clips: ClipTables,
    costs: Costs,
    metric: str = "psnr",
) -> list[Candidate]:
    """Return the methods joined with the times of their architecture.

    A float32 time has the quality that the method's runs were scored with, whatever its backend: they differ by
    rounding. Any other precision has that and its measured cost; it is left out if the cost was not measured. A method
    without a time is left out as well.

    Args:
        timings: of several of one architecture, place, backend and precision the last counts.
        known: see `architectures`.
        costs: the mean paired change of the metric in that precision, over whole clips.
    """
    newest: dict[str, dict[tuple[Any, ...], Timing]] = {}
    for timing in timings:
        if timing.runs:
            kind = (Place.of(timing), timing.backend, timing.precision)
            newest.setdefault(timing.architecture, {})[kind] = timing
    candidates = []
    for method in methods:
        key = next((known[run.id] for run in method.runs if run.id in known), None)
        quality = estimate(method.runs, metric, clips)
        if key is None or quality is None or math.isnan(quality.mean):
            continue
        for timing in newest.get(key, {}).values():
            exact = timing.precision == EXACT
            cost = None if exact else costs.get((key, timing.backend, timing.precision))
            if not exact and cost is None:
                continue
            total = quality if cost is None else plus(quality, cost)
            candidates.append(
                Candidate(label=method.label, runs=tuple(method.runs), quality=total, timing=timing, cost=cost)
            )
    return candidates


def plus(first: Estimate, second: Estimate, sign: float = 1.0) -> Estimate:
    """Return the sum of two independent estimates, or ``first - second`` with a ``sign`` of -1.

    The distances of the intervals' ends from the mean add in quadrature.
    """
    mean = first.mean + sign * second.mean
    below, above = (second.mean - second.low, second.high - second.mean)[:: 1 if sign > 0 else -1]
    low = mean - math.hypot(first.mean - first.low, below)
    high = mean + math.hypot(first.high - first.mean, above)
    return replace(first, mean=mean, low=low, high=high)


def gap(a: Candidate, b: Candidate, clips: ClipTables, metric: str = "psnr") -> Estimate | None:
    """Return ``a - b`` in the metric, paired over the clips that both have; None without such clips."""
    zero = Estimate(0.0, 0.0, 0.0, a.quality.clips, a.quality.scenes)
    if a.images == b.images:
        return zero
    same_runs = [run.id for run in a.runs] == [run.id for run in b.runs]
    apart = zero if same_runs else difference(a.runs, b.runs, metric, clips)
    if apart is None:
        return None
    if a.cost is not None:
        apart = plus(apart, a.cost)
    return apart if b.cost is None else plus(apart, b.cost, -1.0)


def front(candidates: Sequence[Candidate], higher: bool = True) -> list[Candidate]:
    """Return the candidates that no other beats, fastest first.

    A candidate is beaten by one that is as fast and better, or as good and faster. Of two with the same time and
    quality neither beats the other. A candidate without a time or a quality is on no front.

    Args:
        higher: whether more of the quality is better.
    """
    sign = 1.0 if higher else -1.0
    usable = [c for c in candidates if math.isfinite(c.ms) and not math.isnan(c.quality.mean)]
    usable.sort(key=lambda c: (c.ms, -sign * c.quality.mean))
    best: list[Candidate] = []
    for candidate in usable:
        last = best[-1] if best else None
        better = last is None or sign * candidate.quality.mean > sign * last.quality.mean
        equal = last is not None and (candidate.ms, candidate.quality.mean) == (last.ms, last.quality.mean)
        if better or equal:
            best.append(candidate)
    return best


def places(items: Iterable[Candidate | Timing]) -> list[Place]:
    """Return each place once, the one with most times first."""
    counted = [Place.of(item.timing if isinstance(item, Candidate) else item) for item in items]
    return sorted(set(counted), key=lambda place: (-counted.count(place), place))
