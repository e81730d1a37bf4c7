"""Judged claims as rows to typeset, as a sheet, and in long form."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence

from supersampling.reporting.comparison import decimals
from supersampling.reporting.pages.sheet import Sheet, Style, Text
from supersampling.reporting.papers.claims import VERDICTS, Judged, Verdict
from supersampling.reporting.papers.schema import RUN_METRIC, Claim, Paper
from supersampling.runs.statistics import Estimate

STYLES: dict[Verdict, Style] = {
    "reproduced": "yes", "contradicted": "no", "unresolved": "open", "not run": "muted",
}  # fmt: skip
SIGNS = {"more": "a > b", "less": "a < b", "rises": "rises with every step", "falls": "falls with every step"}
EXACT_DIGITS = 4


def rows(judged: Sequence[Judged], keys: Mapping[str, str]) -> list[dict[str, str]]:
    """One claim each, as the template prints it; ``keys`` are the runs' numbers in the appendix."""
    return [
        {
            "id": item.claim.id,
            "text": item.claim.text,
            "source": _source(item.claim),
            "metric": _metric(item.claim),
            "published": _published(item.claim),
            "ours": _mean(item.effect, item.claim),
            "interval": _interval(item.effect, item.claim),
            "verdict": item.verdict,
            "style": STYLES[item.verdict],
            "more": " ".join(_more(item)),
            "runs": _runs(item, keys),
        }
        for item in judged
    ]


def counts(judged: Sequence[Judged]) -> list[tuple[str, int, str]]:
    """``(verdict, how many, style)`` in a fixed order."""
    found = Counter(item.verdict for item in judged)
    return [(verdict, found[verdict], STYLES[verdict]) for verdict in VERDICTS]


def sheet(judged: Sequence[Judged], paper: Paper) -> Sheet:
    """The claims as a table for Markdown and LaTeX."""
    body = []
    for item in judged:
        claim = item.claim
        ours = " ".join(text for text in (_mean(item.effect, claim), _bracketed(_interval(item.effect, claim))) if text)
        body.append(
            [
                Text(claim.id),
                Text(claim.text),
                Text(_source(claim)),
                Text(_published(claim)),
                Text(ours),
                Text(item.verdict, STYLES[item.verdict]),
                Text(" ".join(_more(item))),
            ]
        )
    heads = ["claim", "statement", "where", paper.short, "ours (95% interval)", "verdict", "remarks"]
    summary = ", ".join(f"{count} {verdict}" for verdict, count, _ in counts(judged))
    return Sheet("claims", f"Claims {paper.of}".rstrip(".") + ".", [], heads, body, len(heads), [f"{summary}."])


def long_form(judged: Sequence[Judged]) -> list[dict[str, object]]:
    """One row for each claim, with the runs behind it."""
    table: list[dict[str, object]] = []
    for item in judged:
        claim, effect, chosen = item.claim, item.effect, item.chosen
        table.append(
            {
                "claim": claim.id,
                "statement": claim.text,
                "source": claim.source,
                "page": claim.page,
                "kind": claim.kind,
                "metric": claim.metric,
                "unit": claim.unit,
                "margin": claim.margin,
                "published": claim.published,
                "ours": effect.mean if effect else None,
                "low_95": effect.low if effect else None,
                "high_95": effect.high if effect else None,
                "verdict": item.verdict,
                "reason": item.reason,
                "scenes": len(item.scenes) or None,
                "holds_on": " ".join(scene for scene, held in item.scenes.items() if held),
                "fails_on": " ".join(scene for scene, held in item.scenes.items() if not held),
                "clips": effect.clips if effect else None,
                "seeds": " ".join(f"{label}:{len(runs)}" for label, runs in chosen.runs.items()),
                "setting": "" if chosen.setting is None else str(chosen.setting),
                "needs": claim.needs,
                "runs": "; ".join(
                    f"{label}: {' '.join(run.id for run in runs)}" for label, runs in chosen.runs.items() if runs
                ),
            }
        )
    return table


def _metric(claim: Claim) -> str:
    name = claim.metric.removeprefix(RUN_METRIC)
    if claim.margin is not None:
        return f"{name}: |a − b| < {claim.margin:g}"
    if claim.times != 1.0:
        return f"{name}: {claim.times:g} a < b"
    return f"{name}: {SIGNS[claim.kind]}"


def _unit(claim: Claim) -> str:
    return "" if claim.unit in ("1", "") else f" {claim.unit}"


def _published(claim: Claim) -> str:
    return "" if claim.published is None else f"{claim.published:+g}{_unit(claim)}".replace("-", "−")


def _mean(effect: Estimate | None, claim: Claim) -> str:
    if effect is None or math.isnan(effect.mean):
        return ""
    return f"{_signed(effect.mean, effect, claim)}{_unit(claim)}"


def _interval(effect: Estimate | None, claim: Claim) -> str:
    if effect is None or math.isnan(effect.low):
        return ""
    return f"{_signed(effect.low, effect, claim)} to {_signed(effect.high, effect, claim)}"


def _signed(value: float, effect: Estimate, claim: Claim) -> str:
    if claim.metric.startswith(RUN_METRIC):
        return f"{value:+,.{EXACT_DIGITS}g}" if abs(value) < 1000 else f"{value:+,.0f}".replace(",", " ")
    places = 3 if math.isnan(effect.half_width) else decimals(effect.half_width)
    return f"{value:+.{places}f}".replace("-", "−")


def _bracketed(text: str) -> str:
    return f"({text})" if text else ""


def _more(item: Judged) -> list[str]:
    """What else to know: the scenes, the reason, each step, the paper's condition, what our data cannot do."""
    claim = item.claim
    steps = "; ".join(
        f"{step.label}: {_mean(step.difference, claim)} {_bracketed(_interval(step.difference, claim))}".strip()
        for step in item.steps
        if step.difference is not None
    )
    sentences = [item.holds, item.reason, steps, claim.where, claim.needs]
    return [text[:1].upper() + text[1:].rstrip(".") + "." for text in sentences if text]


def _runs(item: Judged, keys: Mapping[str, str]) -> str:
    labels = list(item.chosen.runs) if item.claim.stepwise else ["a", "b"]
    found = {label: [keys[run.id] for run in item.chosen.runs[label]] for label in labels}
    return "; ".join(f"{label}: {' '.join(names)}" for label, names in found.items() if names)


def _source(claim: Claim) -> str:
    return claim.source + (f", p. {claim.page}" if claim.page else "")
