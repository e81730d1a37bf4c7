"""The papers' conclusions, judged by the paired statistics on our runs."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Literal

from supersampling.reporting.papers.effects import RunScores, effect, scene_effects
from supersampling.reporting.papers.schema import RUN_METRIC, Claim, Selection
from supersampling.reporting.papers.times import PART, Measured, choose_times, quantity_of
from supersampling.reporting.selection import choose_runs, pools_for
from supersampling.reporting.settings import Choice, Setting
from supersampling.runs.measurements import Measurement
from supersampling.runs.statistics import Estimate
from supersampling.runs.store import Run

Verdict = Literal["reproduced", "contradicted", "unresolved", "not run"]
VERDICTS: tuple[Verdict, ...] = ("reproduced", "contradicted", "unresolved", "not run")


@dataclass(frozen=True)
class ClaimRuns:
    """A claim's runs by side (``a``, ``b``) or step; an empty list if nothing was run."""

    claim: Claim
    setting: Setting | None
    runs: dict[str, list[Run]]

    @property
    def missing(self) -> list[str]:
        return [label for label, runs in self.runs.items() if not runs]


@dataclass(frozen=True)
class Step:
    """One step of a claim about several: the later minus the earlier."""

    label: str
    difference: Estimate | None
    verdict: Verdict


@dataclass(frozen=True, kw_only=True)
class Judged:
    """A claim and the verdict of our runs.

    Attributes:
        effect: ``a - b`` (for steps: last minus first).
        scenes: whether it holds, by scene.
        reason: why it is unresolved or not run.
    """

    selected: ClaimRuns
    verdict: Verdict
    effect: Estimate | None = None
    steps: list[Step] = field(default_factory=list)
    scenes: dict[str, bool] = field(default_factory=dict)
    reason: str = ""

    @property
    def claim(self) -> Claim:
        return self.selected.claim

    @property
    def holds(self) -> str:
        """``holds on 7 of 9 scenes; not on foundry, louvres``."""
        if not self.scenes:
            return ""
        against = [scene for scene, holds in self.scenes.items() if not holds]
        if len(against) == len(self.scenes):
            return f"holds on none of {len(self.scenes)} scenes"
        count = f"holds on {len(self.scenes) - len(against)} of {len(self.scenes)} scenes"
        return count + (f"; not on {', '.join(against)}" if against else "")


def choose_claim(claim: Claim, choice: Choice, measurements: Sequence[Measurement] = ()) -> ClaimRuns:
    """Return the runs that a claim compares: of one setting, agreeing in all that the claim does not name.

    Of several settings the first that has most of them.
    """
    selections = claim.selections
    if (quantity := quantity_of(claim.metric)) is not None:
        sides = {label: (selection, quantity) for label, selection in selections.items()}
        return ClaimRuns(claim, None, _measured_runs(claim, choose_times(sides, measurements)))
    best = ClaimRuns(claim, None, {label: [] for label in selections})
    for setting, pool in pools_for(choice, selections.values(), {}):
        cells = choose_runs(pool, selections).cells
        if sum(map(bool, cells.values())) > sum(map(bool, best.runs.values())):
            best = ClaimRuns(claim, setting, {label: cells[label] for label in selections})
        if not best.missing:
            break
    return best


def _measured_runs(claim: Claim, times: Mapping[str, Measured]) -> dict[str, list[Run]]:
    """Return the benchmark's run for each side, with the side's number as its metric.

    Its identity tells the method and the part, since both sides are of one benchmark.
    """
    runs: dict[str, list[Run]] = {label: [] for label in claim.selections}
    for label, item in times.items():
        if not math.isnan(item.value):
            identity = f"{item.measurement.run.id} {claim.selections[label].get(PART, '')}"
            runs[label] = [replace(item.measurement.benchmark, identity=identity, metrics={claim.metric: item.value})]
    return runs


def judge(selected: ClaimRuns, scores: RunScores) -> Judged:
    """Return a claim's verdict.

    *Reproduced* if the 95% interval lies wholly on the claimed side (of kind ``same``: within the margin; with
    ``at_least`` or ``times``: beyond it), *contradicted* if wholly on the other, *unresolved* otherwise, *not run* if
    runs are missing. A claim about steps is reproduced if every step is, and contradicted if any is.
    """
    claim, labels = selected.claim, list(selected.runs)
    pairs = list(pairwise(labels))
    steps = []
    for earlier, later in pairs:
        value = effect(selected.runs[later], selected.runs[earlier], claim, scores, claim.times)
        steps.append(Step(f"{earlier} → {later}", value, side(claim, value)))
    whole = effect(selected.runs[labels[-1]], selected.runs[labels[0]], claim, scores)
    verdict = _together([step.verdict for step in steps])
    reason = _reason(selected, steps, verdict)
    if any(_same_runs(selected.runs[earlier], selected.runs[later]) for earlier, later in pairs):
        verdict = "unresolved"
        reason = "both sides are the same runs: what the claim names is not in their parameters"
    return Judged(
        selected=selected,
        verdict=verdict,
        effect=whole,
        steps=steps if claim.stepwise else [],
        scenes=_scenes(selected, scores) if not selected.missing else {},
        reason=reason,
    )


def side(claim: Claim, value: Estimate | None) -> Verdict:
    """Return on which side of the claim the interval of a difference lies; a logged number counts as its own
    interval."""
    if value is None:
        return "not run"
    exact = claim.exact
    low, high = (value.mean, value.mean) if exact else (value.low, value.high)
    if math.isnan(low) or math.isnan(high):
        return "unresolved"
    if claim.margin is not None:
        if -claim.margin < low and high < claim.margin:
            return "reproduced"
        return "contradicted" if low >= claim.margin or high <= -claim.margin else "unresolved"
    if claim.kind in ("less", "falls"):
        low, high = -high, -low
    if low > claim.at_least:
        return "reproduced"
    return "contradicted" if high < claim.at_least or (exact and high == claim.at_least) else "unresolved"


def _together(verdicts: Sequence[Verdict]) -> Verdict:
    """Return the first of contradicted, not run and unresolved that any step has; reproduced if every step is."""
    order: tuple[Verdict, ...] = ("contradicted", "not run", "unresolved")
    return next((verdict for verdict in order if verdict in verdicts), "reproduced")


def _scenes(selected: ClaimRuns, scores: RunScores) -> dict[str, bool]:
    """Return for each scene whether its mean differences are on the claimed side."""
    means = [
        scene_effects(selected.runs[later], selected.runs[earlier], selected.claim, scores)
        for earlier, later in pairwise(selected.runs)
    ]
    common = sorted(set.intersection(*map(set, means)))
    return {scene: all(_claimed(selected.claim, mean[scene]) for mean in means) for scene in common}


def _claimed(claim: Claim, value: float) -> bool:
    if claim.margin is not None:
        return abs(value) < claim.margin
    return (-value if claim.kind in ("less", "falls") else value) > claim.at_least


def _same_runs(first: Sequence[Run], second: Sequence[Run]) -> bool:
    return bool(first) and {(run.id, run.identity) for run in first} == {(run.id, run.identity) for run in second}


def _reason(selected: ClaimRuns, steps: Sequence[Step], verdict: Verdict) -> str:
    """Return why there is no clear verdict; for a contradiction by steps, at which ones."""
    claim = selected.claim
    if verdict == "not run":
        if selected.missing:
            return _missing(selected)
        return f"the runs are there, but not all logged {claim.metric.removeprefix(RUN_METRIC)}" + (
            f" of frames {claim.frames[0]} to {claim.frames[1]}" if claim.frames is not None else ""
        )
    labels = [step.label for step in steps if step.verdict == verdict] if claim.stepwise else []
    place = f"at {', '.join(labels)}" if labels and verdict != "reproduced" else ""
    if verdict != "unresolved":
        return place
    values = [step.difference for step in steps if step.verdict == verdict and step.difference is not None]
    if any(math.isnan(value.low) for value in values):
        reason = "no interval: a single clip, or an infinite value"
    elif claim.margin is not None:
        reason = f"the interval crosses ±{claim.margin:g}"
    else:
        reason = f"the interval holds {-claim.at_least if claim.kind == 'less' else claim.at_least:g}"
    return f"{reason} {place}".strip()


def _missing(selected: ClaimRuns) -> str:
    """Return which runs are missing: by their own selection, and by the common one as well if no run exists."""
    claim = selected.claim
    steps = {step.label: step.select for step in claim.steps}
    selections = steps if claim.stepwise else {"a": claim.a or {}, "b": claim.b or {}}
    missing = [text(selection) for label, selection in selections.items() if label in selected.missing]
    base = f" of {text(claim.base)}" if len(missing) == len(selections) and claim.base else ""
    return f"no run{base} with {', nor with '.join(missing)}"


def text(selection: Selection) -> str:
    """Return a selection as it is written on a command line."""
    return " ".join(f"{name}={value}" for name, value in selection.items()) or "any parameters"
