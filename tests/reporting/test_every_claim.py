"""Every claim of every paper, judged on made-up runs: the claimed effect reproduces it, the opposite contradicts it.

Which side is the higher one is typed a second time in `claim_directions`, from the papers' sentences and tables: a
claim whose sides or whose direction were swapped would contradict itself.
"""

from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from claim_directions import HIGHER, PRINTED, RANGES
from example_runs import example_run

from supersampling.reporting.papers.claims import Judged, choose_claim, judge, text
from supersampling.reporting.papers.effects import RunScores
from supersampling.reporting.papers.published import load_papers
from supersampling.reporting.papers.schema import BENCHMARK, RUN_METRIC, Claim
from supersampling.reporting.settings import choose
from supersampling.runs.measurements import Measurement
from supersampling.runs.store import Run

CLAIMS = {
    claim.id: claim
    for paper in load_papers(Path(__file__).resolve().parents[2] / "reports" / "published", None)
    for claim in paper.claims
}
UNTRAINED = ("bicubic", "jau", "jau_bicubic", "tus", "tus_thesis")
WAY = {"backend": "onnxruntime", "precision": "float32", "device": "cpu", "threads": "2"}
SCENES = ("arena", "bar", "foundry")
FRAMES = 24


def test_every_claim_is_typed_once() -> None:
    assert set(HIGHER) == set(CLAIMS)


@pytest.mark.parametrize("name", CLAIMS)
def test_the_claimed_effect_reproduces_a_claim_and_the_opposite_contradicts_it(name: str) -> None:
    claim = CLAIMS[name]
    levels = claimed(claim)
    labels = list(claim.selections)
    if claim.published is not None:
        first, last = levels[labels[0]], levels[labels[-1]]
        assert (last - first) * claim.published > 0 or claim.published == 0 == last - first
    assert judged(claim, levels).verdict == "reproduced"
    assert judged(claim, opposite(claim, levels)).verdict == "contradicted"


@pytest.mark.parametrize("name", PRINTED)
def test_printed_sides_reproduce_a_factor_or_a_percentage(name: str) -> None:
    claim, (a, b) = CLAIMS[name], PRINTED[name]
    result = judged(claim, {"b": b, "a": a})
    assert result.verdict == "reproduced"
    assert result.effect is not None
    assert result.effect.mean == pytest.approx(claim.published, abs=0.05 if claim.relative else 1e-6)
    ratio = b / a
    assert claim.times == 1.0 or 0.5 * ratio < claim.times <= ratio


def test_factors_percentages_and_frames_are_typed_here_too() -> None:
    factors = {name for name, claim in CLAIMS.items() if claim.times > 1.0 or (claim.relative and claim.published)}
    assert factors <= set(PRINTED)
    assert {name: claim.frames for name, claim in CLAIMS.items() if claim.frames} == RANGES
    assert [name for name, claim in CLAIMS.items() if claim.settles] == ["dlctus-28"]


def claimed(claim: Claim) -> dict[str, float]:
    """The quantity of each side or step, as the paper has it: `HIGHER` is higher, by the published difference."""
    labels = list(claim.selections)
    up = HIGHER[claim.id]
    if up == "=":
        return dict.fromkeys(labels, 30.0)
    ends = [_own(claim, label) for label in (labels[0], labels[-1])]
    (rising,) = [end for end, words in enumerate(ends) if any(word.endswith(up) for word in words)]
    if claim.relative:
        share = abs(claim.published or 0.5 * (claim.margin or 50.0)) / 100
        return {"b": 30.0, "a": 30.0 * (1 + share if rising else 1 - share)}
    low, high = 30.0, 30.0 + size(claim)
    if claim.times > 1.0:
        high = 1.1 * claim.times * low
    start, stop = (low, high) if rising else (high, low)
    return {label: start + (stop - start) * i / (len(labels) - 1) for i, label in enumerate(labels)}


def size(claim: Claim) -> float:
    """The published difference; without one, one that the claim's wording allows."""
    return abs(claim.published or (0.5 * claim.margin if claim.margin else 5.0))


def opposite(claim: Claim, levels: dict[str, float]) -> dict[str, float]:
    """The sides exchanged; of two that should be the same, one far above the other."""
    labels = list(levels)
    if claim.margin is not None:
        return {labels[0]: 30.0, labels[1]: 30.0 + 3 * claim.margin}
    if claim.relative and claim.at_least < 0:  # a part that is a smaller one of the whole
        return {"b": 30.0, "a": 0.3 * (90 + claim.at_least)}
    return dict(zip(labels, reversed(levels.values())))


def judged(claim: Claim, levels: dict[str, float]) -> Judged:
    measurements = measured(claim, levels) if claim.metric.startswith(BENCHMARK) else []
    logged = claim.metric.startswith(RUN_METRIC)
    runs, clips, frames = [made_up("another training", {"model": "nearest"}, {})], {}, {}
    for label, selection in claim.selections.items():
        metrics = {claim.metric.removeprefix(RUN_METRIC): levels[label]} if logged else {}
        run = made_up(f"{claim.id} {label}", selection, metrics)
        runs.append(run)
        # What the claim does not look at says the contrary.
        contrary = -levels[label]
        clips[run.id] = clip_table(claim.metric, contrary if claim.over_frames else levels[label])
        frames[run.id] = frame_table(claim, levels[label], contrary)
    return judge(choose_claim(claim, choose(runs, None, None), measurements), RunScores(clips, frames))


def measured(claim: Claim, levels: dict[str, float]) -> list[Measurement]:
    """One benchmark of the sides: the last term of a sum of parts has what is left of its level."""
    benchmark = replace(example_run("benchmark"), kind="benchmark")
    sums = {
        label: selection.get("part", "whole").split("|")[0].split(" + ")
        for label, selection in claim.selections.items()
    }
    parts: dict[tuple[tuple[str, str], ...], dict[str, float]] = {}
    for label, names in sorted(sums.items(), key=lambda item: len(item[1])):
        own = {key: value.split("|")[0] for key, value in claim.selections[label].items() if key != "part"}
        numbers = parts.setdefault(tuple(sorted({**WAY, **own}.items())), {})
        numbers |= {name: numbers.get(name, 0.0) for name in names}
        numbers[names[-1]] = levels[label] - sum(numbers[name] for name in names[:-1])
    return [
        Measurement(
            benchmark=benchmark,
            run=replace(benchmark, id=f"benchmark:{index}", params=dict(params)),
            quantities={"ms": numbers},
        )
        for index, (params, numbers) in enumerate(parts.items())
    ]


def made_up(name: str, selection: dict[str, str], metrics: dict[str, float]) -> Run:
    """A run with the selected parameters, of "a|b" the first; an evaluation if it was not scored as it was trained."""
    params = {key: value.split("|")[0] for key, value in selection.items()}
    if params.get("model") not in UNTRAINED:
        params["budget"] = "laptop"
    evaluation = params.get("test.scenes", "same") != "same" or any(key.startswith("trained.") for key in params)
    if evaluation:
        params.setdefault("test.scenes", "same")
    run = example_run(name, metrics=metrics, **{key.replace(".", "__"): value for key, value in params.items()})
    return replace(run, kind="evaluation") if evaluation else run


def clip_table(metric: str, level: float) -> pd.DataFrame:
    rows = [(scene, clip, level) for scene in SCENES for clip in (0, 1)]
    return pd.DataFrame(rows, columns=["scene", "clip", metric])


def frame_table(claim: Claim, level: float, contrary: float) -> pd.DataFrame:
    def value(frame: int) -> float:
        if claim.settles is not None:  # a step, after as many frames as the level says beyond 29
            return 1.0 if frame + 1 >= level - 29 else 0.0
        return level if claim.frames and claim.frames[0] <= frame <= claim.frames[1] else contrary

    rows = [(scene, clip, frame, value(frame)) for scene in SCENES for clip in (0, 1) for frame in range(FRAMES)]
    return pd.DataFrame(rows, columns=["scene", "clip", "frame", claim.metric])


def _own(claim: Claim, label: str) -> list[str]:
    """The words of a side's or step's own selection."""
    own = {step.label: step.select for step in claim.steps} if claim.stepwise else {"a": claim.a, "b": claim.b}
    return text({key: value.replace(" ", "") for key, value in (own[label] or {}).items()}).split()
