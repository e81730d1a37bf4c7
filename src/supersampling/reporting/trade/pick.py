"""The choice of a method: the best within a time, or the fastest within a loss of quality, as far as the data can
tell."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from supersampling.errors import UserError
from supersampling.reporting.format import fixed, plus_minus, short, span, unless_resolved
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
        """Return the rendering of ``low_ms`` and ``high_ms``.

        Raises:
            UserError: a time is not a positive number, or the high resolution's is given without the low one's.
        """
        for name, value in (("low_ms", low_ms), ("high_ms", high_ms)):
            if value is not None and not (_is_number(value) and value > 0):
                raise UserError(f"Invalid {name}={value}: use the milliseconds of a frame, a positive number.")
        if high_ms is not None and low_ms is None:
            raise UserError(
                f"high_ms={high_ms} needs low_ms: set it to the milliseconds of a frame at the low resolution."
            )
        return cls(low_ms or 0.0, high_ms)

    def total(self, candidate: Candidate) -> float:
        """Return the milliseconds of a whole frame: its rendering and three of four upscalings."""
        return self.low_ms + upper(candidate)


@dataclass(frozen=True, kw_only=True)
class Answer:
    """The selected candidate, and what the data say of it.

    Attributes:
        against: the candidate that it is compared with: the next best, or the best.
        lead: how far it is ahead of ``against``; negative if it is behind.
        tied: the candidates that the data cannot tell from it, fastest first.
        undecided: how many candidates have no interval.
    """

    selected: Candidate
    against: Candidate | None
    lead: Estimate | None
    tied: tuple[Candidate, ...] = ()
    undecided: int
    rendering: Rendering


def upper(candidate: Candidate) -> float:
    """Return the upper quartile of a frame's time.

    A budget that every second frame misses is not met, so the median is too low; the maximum is noise.
    """
    return candidate.timing.high if math.isfinite(candidate.timing.high) else candidate.ms


def within_ms(candidates: Sequence[Candidate], ms: float, rendering: Rendering, gap_of: Gap) -> Answer:
    """Return the best of the candidates whose frames take at most ``ms``, with rendering if that is given.

    Raises:
        UserError: ``ms`` is not positive, nothing is that fast, or there are no candidates.
    """
    fastest = _fastest(candidates, rendering)
    if not (_is_number(ms) and ms > 0):
        raise UserError(f"Invalid ms={ms}: use positive milliseconds; the fastest here is {fastest}.")
    eligible = distinct([c for c in candidates if rendering.total(c) <= ms])
    if not eligible:
        raise UserError(f"Nothing here is within ms={short(ms)}: use more; the fastest is {fastest}.")
    best, *rest = sorted(eligible, key=lambda c: (-c.quality.mean, upper(c)))
    gaps = {id(c): gap_of(best, c) for c in rest}
    second = rest[0] if rest else None
    return Answer(
        selected=best,
        against=second,
        lead=gaps[id(second)] if second is not None else None,
        tied=tuple(sorted((c for c in rest if _is_tied(gaps[id(c)])), key=upper)),
        undecided=sum(_is_undecided(value) for value in gaps.values()),
        rendering=rendering,
    )


def within_db(candidates: Sequence[Candidate], db: float, rendering: Rendering, gap_of: Gap) -> Answer:
    """Return the fastest of the candidates whose loss against the best is at most ``db``.

    The loss counts at the far end of its paired interval. That is non-inferiority: a mean within ``db`` is not enough,
    and a candidate without an interval is not selected.

    Raises:
        UserError: ``db`` is negative or not a number, or there are no candidates.
    """
    fastest = _fastest(candidates, rendering)
    if not (_is_number(db) and db >= 0):
        raise UserError(f"Invalid db={db}: use decibels of at least 0; the fastest here is {fastest}.")
    best, *rest = sorted(distinct(candidates), key=lambda c: (-c.quality.mean, upper(c)))
    gaps = {id(c): gap_of(c, best) for c in rest}
    near = [best, *(c for c in rest if _is_near(gaps[id(c)], db))]
    selected = min(near, key=lambda c: (upper(c), -c.quality.mean))
    return Answer(
        selected=selected,
        against=None if selected is best else best,
        lead=gaps.get(id(selected)),
        undecided=sum(_is_undecided(value) for value in gaps.values()),
        rendering=rendering,
    )


def distinct(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return the fastest way to run each method in each precision, of the candidates with a time and a quality."""
    usable = [c for c in candidates if math.isfinite(upper(c)) and not math.isnan(c.quality.mean)]
    fastest = {c.images: c for c in sorted(usable, key=upper, reverse=True)}
    return [c for c in usable if fastest[c.images] is c]


def paired(clips: ClipTables, metric: str = "psnr") -> Gap:
    """Return a function of two candidates: how far the first is ahead of the second by these clips' scores."""
    return lambda a, b: gap(a, b, clips, metric)


def describe(candidate: Candidate) -> str:
    """Return a candidate's name, backend, precision and time."""
    return f"{candidate.label} ({candidate.how}, {short(candidate.ms)} ms, upper quartile {short(upper(candidate))})"


def sentences(answer: Answer, ms: float | None = None, db: float | None = None) -> list[str]:
    """Return the answer in words."""
    selected = answer.selected
    question = f"best within {short(ms)} ms" if ms is not None else f"fastest within {short(db or 0.0)} dB of the best"
    lines = [f"{question}: {describe(selected)}, PSNR {plus_minus(selected.quality, 2)}."]
    if db is not None and answer.against is None:
        lines.append("It is the best there is: nothing faster is surely within that loss.")
    elif db is not None and answer.against is not None:
        lines.append(f"Against the best, {describe(answer.against)}: {_interval(answer.lead)}.")
    elif answer.against is not None:
        lines.append(f"Ahead of the next, {describe(answer.against)}: {_interval(answer.lead)}.")
    if answer.tied:
        names = "; ".join(describe(c) for c in answer.tied)
        fastest = min((selected, *answer.tied), key=upper)
        lines.append(f"The data cannot tell it from {names}. The fastest of these is {describe(fastest)}.")
    if answer.undecided:
        lines.append(f"{answer.undecided} others have no interval: score them on more than one clip.")
    return lines + _rendering_sentences(answer)


def _rendering_sentences(answer: Answer) -> list[str]:
    rendering = answer.rendering
    if not rendering.low_ms:
        return []
    total = rendering.total(answer.selected)
    sums = f"{short(rendering.low_ms)} + {short(upper(answer.selected))} = {short(total)} ms"
    if rendering.high_ms is None:
        return [f"Rendering low and upscaling: {sums} a frame."]
    high = rendering.high_ms
    verdict = "pays" if total < high else "does not pay"
    return [
        f"Upscaling {verdict}: {sums} a frame, against {short(high)} ms of rendering at the target's size "
        f"({high / total:.2f} times)."
    ]


def _fastest(candidates: Sequence[Candidate], rendering: Rendering) -> str:
    usable = distinct(candidates)
    if not usable:
        raise UserError(
            "No method here has both a quality and a time: train on this data set, then measure with benchmark.py."
        )
    fastest = min(usable, key=upper)
    total = f", with its rendering {short(rendering.total(fastest))} ms" if rendering.low_ms else ""
    return describe(fastest) + total


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _is_undecided(lead: Estimate | None) -> bool:
    return lead is None or math.isnan(lead.low)


def _is_tied(lead: Estimate | None) -> bool:
    """Return whether the data leave open which is better; a candidate without an interval is not called tied."""
    return lead is not None and not math.isnan(lead.low) and not lead.resolved


def _is_near(lead: Estimate | None, db: float) -> bool:
    return lead is not None and lead.low >= -db


def _interval(lead: Estimate | None) -> str:
    if lead is None:
        return "no clip in common"
    mean = f"{fixed(lead.mean, 3, sign=True)} dB"
    if math.isnan(lead.low):
        return f"{mean}, without an interval"
    words = "" if lead.low == lead.high == 0 else unless_resolved(lead)
    return f"{mean} ({LEVEL:.0%} interval {span(lead, 3)}{words})"
