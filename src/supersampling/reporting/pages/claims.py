"""Judged claims: the section, its table for other documents, and the long form."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence

from supersampling.reporting.format import decimals, fixed, thousands, typeset
from supersampling.reporting.pages.exports import export_rows, export_words
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Section
from supersampling.reporting.pages.sheet import Sheet, Style, Text
from supersampling.reporting.papers.claims import VERDICTS, Judged, Verdict
from supersampling.reporting.papers.schema import BENCHMARK, RUN_METRIC, Claim, Paper
from supersampling.runs.statistics import Estimate

STYLES: dict[Verdict, Style] = {"reproduced": "yes", "contradicted": "no", "unresolved": "open", "not run": "muted"}
SIGNS = {"more": "a > b", "less": "a < b", "rises": "rises with every step", "falls": "falls with every step"}
EXACT_DIGITS = 4
WORDS = [
    Text(
        "What the papers conclude, judged by our runs: the mean paired difference over clips and seeds, below it its "
        "95% "
        "interval over other scenes like these. "
    ),
    Text("Reproduced", "bold"),
    Text(": the interval lies wholly on the claimed side; "),
    Text("contradicted", "bold"),
    Text(": wholly on the other; "),
    Text("unresolved", "bold"),
    Text(": neither; "),
    Text("not run", "bold"),
    Text(": runs are missing. One of twenty intervals misses the truth by chance."),
]


def section(report: Report) -> Section | None:
    """Return the claims of each paper; None without any."""
    groups = report.judged
    if not groups:
        return None
    export_rows(long_form([claim for _, judged in groups for claim in judged]), f"{report.stem}_claims.csv")
    if report.subject is not None:
        export_words([sheet(judged, paper) for paper, judged in groups], report.stem)
    return Section(title="Claims", words=WORDS, claims=[_group(paper, judged, report) for paper, judged in groups])


def _group(paper: Paper, judged: Sequence[Judged], report: Report) -> dict[str, object]:
    name = f"{paper.authors.split(',')[0]}: {paper.title}"
    return {
        "paper": name if len(report.judged) > 1 else "",
        "short": paper.short,
        "counts": [list(item) for item in counts(judged)],
        "rows": rows(judged, report.keys),
    }


def rows(judged: Sequence[Judged], keys: Mapping[str, str]) -> list[dict[str, str]]:
    """Return one row per claim as the template prints it; ``keys`` are the runs' numbers in the appendix."""
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
            "more": " ".join(_remarks(item)),
            "runs": _runs(item, keys),
        }
        for item in judged
    ]


def counts(judged: Sequence[Judged]) -> list[tuple[str, int, str]]:
    """Return ``(verdict, number of claims, style)`` in a fixed order."""
    numbers = Counter(item.verdict for item in judged)
    return [(verdict, numbers[verdict], STYLES[verdict]) for verdict in VERDICTS]


def sheet(judged: Sequence[Judged], paper: Paper) -> Sheet:
    """Return the claims as a table for Markdown and LaTeX."""
    body = []
    for item in judged:
        claim = item.claim
        effect = [_mean(item.effect, claim), _in_brackets(_interval(item.effect, claim))]
        body.append(
            [
                Text(claim.id),
                Text(claim.text),
                Text(_source(claim)),
                Text(_published(claim)),
                Text(" ".join(text for text in effect if text)),
                Text(item.verdict, STYLES[item.verdict]),
                Text(" ".join(_remarks(item))),
            ]
        )
    heads = ["claim", "statement", "where", paper.short, "ours (95% interval)", "verdict", "remarks"]
    return Sheet(
        name="claims",
        title=f"Claims {paper.of}".rstrip(".") + ".",
        headers=heads,
        rows=body,
        labels=len(heads),
        notes=[", ".join(f"{count} {verdict}" for verdict, count, _ in counts(judged)) + "."],
    )


def long_form(judged: Sequence[Judged]) -> list[dict[str, object]]:
    """Return one row per claim, with the runs behind it."""
    table: list[dict[str, object]] = []
    for item in judged:
        claim, effect, sides = item.claim, item.effect, item.selected
        table.append(
            {
                "claim": claim.id,
                "statement": claim.text,
                "source": claim.source,
                "page": claim.page,
                "kind": claim.kind,
                "metric": claim.metric,
                "claimed": _metric(claim),
                "unit": claim.unit,
                "margin": claim.margin,
                "published": claim.published,
                "ours": effect.mean if effect else None,
                "low_95": effect.low if effect else None,
                "high_95": effect.high if effect else None,
                "verdict": item.verdict,
                "reason": item.reason,
                "scenes": len(item.scenes) or None,
                "holds_on": " ".join(scene for scene, holds in item.scenes.items() if holds),
                "fails_on": " ".join(scene for scene, holds in item.scenes.items() if not holds),
                "clips": effect.clips if effect else None,
                "seeds": " ".join(f"{label}:{len(runs)}" for label, runs in sides.runs.items()),
                "setting": "" if sides.setting is None else str(sides.setting),
                "needs": claim.needs,
                "runs": "; ".join(
                    f"{label}: {' '.join(run.id for run in runs)}" for label, runs in sides.runs.items() if runs
                ),
            }
        )
    return table


def _metric(claim: Claim) -> str:
    """Return ``psnr, frames 4 to 6: a > b + 0.5``: the quantity, and what is claimed of it."""
    name = claim.metric.removeprefix(RUN_METRIC).removeprefix(BENCHMARK)
    if claim.frames is not None:
        name += f", frames {claim.frames[0]} to {claim.frames[1]}"
    if claim.settles is not None:
        name = f"frames until {name} is within {claim.settles:g} of its later median"
    unit = " %" if claim.relative else ""
    if claim.margin is not None:
        return f"{name}: |a − b| < {claim.margin:g}{unit}"
    if claim.times != 1.0:
        return f"{name}: {claim.times:g} a < b"
    if claim.at_least:
        signed = claim.at_least if claim.kind == "more" else -claim.at_least
        return typeset(f"{name}: a − b {'>' if claim.kind == 'more' else '<'} {signed:g}{unit}")
    return f"{name}: {SIGNS[claim.kind]}"


def _unit(claim: Claim) -> str:
    return "" if claim.unit in ("1", "") else f" {claim.unit}"


def _published(claim: Claim) -> str:
    return "" if claim.published is None else typeset(f"{claim.published:+g}{_unit(claim)}")


def _mean(effect: Estimate | None, claim: Claim) -> str:
    if effect is None or math.isnan(effect.mean):
        return ""
    return f"{_signed(effect.mean, effect, claim)}{_unit(claim)}"


def _interval(effect: Estimate | None, claim: Claim) -> str:
    if effect is None or math.isnan(effect.low):
        return ""
    return f"{_signed(effect.low, effect, claim)} to {_signed(effect.high, effect, claim)}"


def _signed(value: float, effect: Estimate, claim: Claim) -> str:
    if claim.exact:
        return f"{value:+,.{EXACT_DIGITS}g}" if abs(value) < 1000 else thousands(value, sign=True)
    return typeset(fixed(value, 3 if math.isnan(effect.half_width) else decimals(effect.half_width), sign=True))


def _in_brackets(text: str) -> str:
    return f"({text})" if text else ""


def _remarks(item: Judged) -> list[str]:
    """Return sentences on the scenes, the reason, each step, the paper's condition, and what our data cannot do."""
    claim = item.claim
    steps = "; ".join(
        f"{step.label}: {_mean(step.difference, claim)} {_in_brackets(_interval(step.difference, claim))}".strip()
        for step in item.steps
        if step.difference is not None
    )
    sentences = [item.holds, item.reason, steps, claim.where, claim.needs]
    return [text[:1].upper() + text[1:].rstrip(".") + "." for text in sentences if text]


def _runs(item: Judged, keys: Mapping[str, str]) -> str:
    labels = list(item.selected.runs) if item.claim.stepwise else ["a", "b"]
    names = {label: [keys[run.id] for run in item.selected.runs[label]] for label in labels}
    return "; ".join(f"{label}: {' '.join(members)}" for label, members in names.items() if members)


def _source(claim: Claim) -> str:
    return claim.source + (f", p. {claim.page}" if claim.page else "")
