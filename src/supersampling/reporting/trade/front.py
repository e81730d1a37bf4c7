"""Quality against time: each way to run each method of a data set, and those that no other beats in both."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from omegaconf import OmegaConf

from supersampling.reporting.pages.overview import Method
from supersampling.runs.estimates import ClipTables, difference, estimate
from supersampling.runs.statistics import Estimate
from supersampling.runs.store import Run, Store
from supersampling.runs.timing import Timing, architecture

EXACT = "float32"
CONFIGURATION = "config.yaml"
Cost = tuple[str, str, str]  # architecture, backend, precision
Costs = Mapping[Cost, Estimate]


@dataclass(frozen=True)
class Candidate:
    """A method as one backend runs it in one precision: its quality, and how long a frame takes.

    ``cost`` is what the precision was measured to change in the quality (negative for a loss), None of float32; it is in
    ``quality`` already.
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
    def same(self) -> tuple[Any, ...]:
        """Equal for candidates whose images, and so quality, are the same."""
        precision = self.timing.precision
        return (*(run.id for run in self.runs), precision, "" if precision == EXACT else self.timing.backend)


@dataclass(frozen=True, order=True)
class Place:
    """Where times can be compared: one machine, device, number of threads, and target size."""

    machine: str
    device: str
    threads: int
    width: int
    height: int

    @classmethod
    def of(cls, timing: Timing) -> "Place":
        return cls(timing.machine, timing.device, timing.threads, timing.width, timing.height)

    def __str__(self) -> str:
        threads = f", {self.threads} threads" if self.device == "cpu" else ""
        return f"{self.width}x{self.height} on {self.device}{threads} ({self.machine})"


def architectures(runs: Iterable[Run], store: Store) -> dict[str, str]:
    """The `architecture` of each run by its id, of the configuration that it logged; a run without one is left out."""
    found = {}
    for run, path in store.folders(list(runs), CONFIGURATION).items():
        said: Any = OmegaConf.to_container(OmegaConf.load(path), resolve=True)
        found[run] = architecture(said["model"], int(said["task"]["scale"]))
    return found


def candidates(
    methods: Iterable[Method],
    timings: Iterable[Timing],
    known: Mapping[str, str],
    clips: ClipTables,
    costs: Costs,
    metric: str = "psnr",
) -> list[Candidate]:
    """Methods joined with the times of their architecture.

    A float32 time has the quality that the method's runs were scored with, whichever backend it is: they differ by rounding.
    Any other precision has that and its measured cost; where that was not measured it is left out, as is what has no time.

    Args:
        timings: the last of one architecture, place, backend and precision counts.
        known: see `architectures`.
        costs: the mean paired change of the metric in that precision, over whole clips.
    """
    newest: dict[str, dict[tuple[Any, ...], Timing]] = {}
    for timing in timings:
        if not timing.runs:
            continue
        kind = (Place.of(timing), timing.backend, timing.precision)
        newest.setdefault(timing.architecture, {})[kind] = timing
    found = []
    for method in methods:
        own = next((known[run.id] for run in method.runs if run.id in known), None)
        quality = estimate(method.runs, metric, clips)
        if own is None or quality is None or math.isnan(quality.mean):
            continue
        for timing in newest.get(own, {}).values():
            cost = costs.get((own, timing.backend, timing.precision))
            if timing.precision != EXACT and cost is None:
                continue
            exact = timing.precision == EXACT or cost is None
            found.append(
                Candidate(
                    method.label,
                    tuple(method.runs),
                    quality if exact or cost is None else plus(quality, cost),
                    timing,
                    None if exact else cost,
                )
            )
    return found


def plus(one: Estimate, other: Estimate, sign: float = 1.0) -> Estimate:
    """The sum of two independent estimates, or ``one - other`` with a ``sign`` of -1; ends of intervals add in quadrature."""
    mean = one.mean + sign * other.mean
    below, above = (other.mean - other.low, other.high - other.mean)[:: 1 if sign > 0 else -1]
    low = mean - math.hypot(one.mean - one.low, below)
    high = mean + math.hypot(one.high - one.mean, above)
    return replace(one, mean=mean, low=low, high=high)


def gap(a: Candidate, b: Candidate, clips: ClipTables, metric: str = "psnr") -> Estimate | None:
    """``a - b`` in the metric, paired over the clips that both have; None without such clips."""
    if a.same == b.same:
        return Estimate(0.0, 0.0, 0.0, a.quality.clips, a.quality.scenes)
    same_runs = [run.id for run in a.runs] == [run.id for run in b.runs]
    apart = (
        Estimate(0.0, 0.0, 0.0, a.quality.clips, a.quality.scenes)
        if same_runs
        else difference(a.runs, b.runs, metric, clips)
    )
    if apart is None:
        return None
    if a.cost is not None:
        apart = plus(apart, a.cost)
    return apart if b.cost is None else plus(apart, b.cost, -1.0)


def front(found: Sequence[Candidate], higher: bool = True) -> list[Candidate]:
    """Those that no other beats: none is as fast and better, or as good and faster. Fastest first.

    Of two with the same time and quality neither beats the other. What has no time or no quality is on no front.
    ``higher``: whether more of the quality is better.
    """
    sign = 1.0 if higher else -1.0
    usable = [c for c in found if math.isfinite(c.ms) and not math.isnan(c.quality.mean)]
    usable.sort(key=lambda c: (c.ms, -sign * c.quality.mean))
    kept: list[Candidate] = []
    for one in usable:
        last = kept[-1] if kept else None
        better = last is None or sign * one.quality.mean > sign * last.quality.mean
        if better or (last is not None and (one.ms, one.quality.mean) == (last.ms, last.quality.mean)):
            kept.append(one)
    return kept


def places(found: Iterable[Candidate | Timing]) -> list[Place]:
    """Each place once, the one with most times first."""
    every = [Place.of(one.timing if isinstance(one, Candidate) else one) for one in found]
    return sorted(set(every), key=lambda place: (-every.count(place), place))
