"""Which method to use: the best within a time, or the fastest within a loss of quality, as far as the data can tell."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from supersampling.errors import UserError
from supersampling.reporting.trade.front import Candidate, gap
from supersampling.runs.estimates import ClipTables
from supersampling.runs.statistics import LEVEL, Estimate

Gap = Callable[[Candidate, Candidate], Estimate | None]


@dataclass(frozen=True)
class Rendering:
    """Milliseconds of a frame's rendering at the low and, if known, at the target resolution (NSRR, section 4.3.1)."""

    low_ms: float = 0.0
    high_ms: float | None = None

    @classmethod
    def of(cls, low_ms: float | None, high_ms: float | None) -> "Rendering":
        """Of what a user gives.

        Raises:
            UserError: a time that is none, or the high resolution's alone.
        """
        for name, value in (("low_ms", low_ms), ("high_ms", high_ms)):
            if value is not None and not (_is_number(value) and value > 0):
                raise UserError(f"render.{name}={value} is no time: give milliseconds of a frame, above 0.")
        if high_ms is not None and low_ms is None:
            raise UserError(
                f"render.high_ms={high_ms} says nothing by itself: give render.low_ms as well, what a frame costs at the low "
                "resolution."
            )
        return cls(low_ms or 0.0, high_ms)

    def total(self, candidate: Candidate) -> float:
        """Milliseconds of a whole frame: its rendering and three of four upscalings."""
        return self.low_ms + upper(candidate)


@dataclass(frozen=True)
class Answer:
    """What was picked. ``gaps`` says of others how far ``chosen`` is ahead of them (or, of ``against``, behind).

    ``tied``: those that the data cannot tell from ``chosen``, fastest first; ``undecided``: how many have no interval.
    """

    chosen: Candidate
    against: Candidate | None
    lead: Estimate | None
    tied: tuple[Candidate, ...]
    undecided: int
    rendering: Rendering


def upper(candidate: Candidate) -> float:
    """The upper quartile of a frame's time: a budget that every second frame misses is not kept, and a maximum is noise."""
    return candidate.timing.high if math.isfinite(candidate.timing.high) else candidate.ms


def within_ms(found: Sequence[Candidate], ms: float, rendering: Rendering, gap_of: Gap) -> Answer:
    """The best of those whose frames take at most ``ms``, with rendering if that is given.

    Raises:
        UserError: ``ms`` is no time above 0, nothing is that fast, or there is nothing at all.
    """
    fastest = _fastest(found, rendering)
    if not (_is_number(ms) and ms > 0):
        raise UserError(f"pick.ms={ms} is no time: give milliseconds above 0; the fastest here is {fastest}.")
    eligible = distinct([c for c in found if rendering.total(c) <= ms])
    if not eligible:
        raise UserError(f"Nothing here is within pick.ms={_short(ms)}: the fastest is {fastest}.")
    ordered = sorted(eligible, key=lambda c: (-c.quality.mean, upper(c)))
    best, others = ordered[0], ordered[1:]
    gaps = {id(c): gap_of(best, c) for c in others}
    tied = [c for c in others if _is_tied(gaps[id(c)])]
    second = others[0] if others else None
    return Answer(
        best,
        second,
        gaps[id(second)] if second is not None else None,
        tuple(sorted(tied, key=upper)),
        sum(_undecided(value) for value in gaps.values()),
        rendering,
    )


def within_db(found: Sequence[Candidate], db: float, rendering: Rendering, gap_of: Gap) -> Answer:
    """The fastest of those whose loss against the best is at most ``db`` at the far end of its paired interval.

    That is non-inferiority: a mean within ``db`` is not enough, and what has no interval is not picked.

    Raises:
        UserError: ``db`` is no loss of 0 or more, or there is nothing at all.
    """
    fastest = _fastest(found, rendering)
    if not (_is_number(db) and db >= 0):
        raise UserError(f"pick.db={db} is no loss: give decibels from 0 up; the fastest here is {fastest}.")
    ordered = sorted(distinct(found), key=lambda c: (-c.quality.mean, upper(c)))
    best, others = ordered[0], ordered[1:]
    gaps = {id(c): gap_of(c, best) for c in others}
    near = [best, *(c for c in others if _is_near(gaps[id(c)], db))]
    chosen = min(near, key=lambda c: (upper(c), -c.quality.mean))
    return Answer(
        chosen,
        None if chosen is best else best,
        gaps.get(id(chosen)),
        (),
        sum(_undecided(value) for value in gaps.values()),
        rendering,
    )


def distinct(found: Sequence[Candidate]) -> list[Candidate]:
    """The fastest way to run each method in each precision, of those that have a time and a quality."""
    usable = [c for c in found if math.isfinite(upper(c)) and not math.isnan(c.quality.mean)]
    fastest = {c.same: c for c in sorted(usable, key=upper, reverse=True)}
    return [c for c in usable if fastest[c.same] is c]


def paired(clips: ClipTables, metric: str = "psnr") -> Gap:
    """How far one candidate is ahead of another, of these clips' scores."""
    return lambda a, b: gap(a, b, clips, metric)


def named(candidate: Candidate) -> str:
    return f"{candidate.label} ({candidate.how}, {_short(candidate.ms)} ms, upper quartile {_short(upper(candidate))})"


def sentences(answer: Answer, ms: float | None = None, db: float | None = None) -> list[str]:
    """The answer in words."""
    chosen = answer.chosen
    asked = f"best within {_short(ms)} ms" if ms is not None else f"fastest within {_short(db or 0.0)} dB of the best"
    said = [f"{asked}: {named(chosen)}, PSNR {_plus_minus(chosen.quality)}."]
    if db is not None and answer.against is None:
        said.append("It is the best there is: nothing faster is surely within that loss.")
    elif db is not None and answer.against is not None:
        said.append(f"Against the best, {named(answer.against)}: {_interval(answer.lead)}.")
    elif answer.against is not None:
        said.append(f"Ahead of the next, {named(answer.against)}: {_interval(answer.lead)}.")
    if answer.tied:
        names = "; ".join(named(c) for c in answer.tied)
        fastest = min((chosen, *answer.tied), key=upper)
        said.append(f"The data cannot tell it from {names}. The fastest of these is {named(fastest)}.")
    if answer.undecided:
        said.append(f"{answer.undecided} others have no interval: score them on more than one clip.")
    return said + _of_rendering(answer)


def _of_rendering(answer: Answer) -> list[str]:
    rendering = answer.rendering
    if not rendering.low_ms:
        return []
    total = rendering.total(answer.chosen)
    sums = f"{_short(rendering.low_ms)} + {_short(upper(answer.chosen))} = {_short(total)} ms"
    if rendering.high_ms is None:
        return [f"Rendering low and upscaling: {sums} a frame."]
    high = rendering.high_ms
    verdict = "pays" if total < high else "does not pay"
    return [
        f"Upscaling {verdict}: {sums} a frame, against {_short(high)} ms of rendering at the target's size "
        f"({high / total:.2f} times)."
    ]


def _fastest(found: Sequence[Candidate], rendering: Rendering) -> str:
    usable = distinct(found)
    if not usable:
        raise UserError(
            "No method here has both a quality and a time: train on this data set, then measure with benchmark.py."
        )
    fastest = min(usable, key=upper)
    more = f", with its rendering {_short(rendering.total(fastest))} ms" if rendering.low_ms else ""
    return named(fastest) + more


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _undecided(lead: Estimate | None) -> bool:
    return lead is None or math.isnan(lead.low)


def _is_tied(lead: Estimate | None) -> bool:
    """Whether the data leave open which is better; what has no interval is not called tied."""
    return lead is not None and not math.isnan(lead.low) and not lead.resolved


def _is_near(lead: Estimate | None, db: float) -> bool:
    return lead is not None and lead.low >= -db


def _short(value: float) -> str:
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


def _plus_minus(value: Estimate) -> str:
    return f"{value.mean:.2f}" + ("" if math.isnan(value.half_width) else f" ± {value.half_width:.2f}")


def _interval(lead: Estimate | None) -> str:
    if lead is None:
        return "no clip in common"
    if math.isnan(lead.low):
        return f"{lead.mean:+.3f} dB, without an interval"
    words = "" if lead.resolved or lead.low == lead.high == 0 else ", unresolved"
    return f"{lead.mean:+.3f} dB ({LEVEL:.0%} interval {lead.low:+.3f} to {lead.high:+.3f}{words})"
