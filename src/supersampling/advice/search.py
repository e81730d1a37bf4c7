"""The search: candidates, their costs, rounds of trainings, and the decision."""

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from omegaconf import DictConfig, OmegaConf

from supersampling.advice.answer import SearchResult
from supersampling.advice.contributions import Contribution, estimate_contributions
from supersampling.advice.cost import (
    FrameTime,
    TimeCache,
    buffer_rows,
    cache_key,
    measure_frame_times,
    measure_rendering,
)
from supersampling.advice.halving import Criteria, Values, decide, halve
from supersampling.advice.prior import Reason
from supersampling.advice.proposals import propose
from supersampling.advice.settings import Settings
from supersampling.advice.space import ModelComposition, Space
from supersampling.advice.trainings import TrainingConfig, Trainings
from supersampling.errors import UserError
from supersampling.runs.experiment import Experiment
from supersampling.runs.statistics import Estimate
from supersampling.training.job import Files


@dataclass(frozen=True, kw_only=True)
class Question:
    """The question of a search.

    ``space`` is what remains of the ``whole`` space for the ``reasons``; ``files`` are those of the ``scenes``.
    """

    cfg: DictConfig
    settings: Settings
    whole: Space
    space: Space
    reasons: Sequence[Reason]
    files: Files
    experiment: Experiment
    scenes: Sequence[str]

    @property
    def name(self) -> str:
        """A name for files."""
        return f"{'_'.join(self.scenes)}_{self.space.name}".replace("/", "_")


def representative_configs(space: Space) -> list[TrainingConfig]:
    """Return compositions that together read what all of them do: the fullest, with every option in turn."""
    fullest = {switch.name: switch.fullest for switch in space.switches}
    overrides = {
        space.compose({**fullest, switch.name: option}).overrides
        for switch in space.switches
        for option in switch.options
    }
    overrides.add(space.compose(fullest).overrides)
    return [TrainingConfig.compose(item) for item in sorted(overrides)]


def search(question: Question) -> SearchResult:
    """Train the candidates, compare them, and decide.

    Raises:
        UserError: there are too many compositions or steps, or no composition can be trained.
    """
    settings, space = question.settings, question.space
    compositions = _select_candidates(question)
    trainings = _trainings(question, compositions)
    costs = _measure_costs(question, compositions)
    _check_steps(settings, trainings)
    scenes: list[str] = []  # of each clip, known with the first scores
    criteria = Criteria(
        cost=[cost.ms for cost in costs],
        margin=settings.margin,
        scenes=scenes,
        capacity=lambda rung: _count_affordable(settings, trainings, rung),
        spread=[(cost.low, cost.high) for cost in costs],
        parts=[space.count_parts(composition.options) for composition in compositions],
    )

    def score(candidate: int, rung: int) -> Values | None:
        values = trainings.score(candidate, rung)
        scenes[:] = [scene for scene, _ in trainings.places]
        return values

    halving = halve(range(len(compositions)), len(settings.rungs.epochs), criteria, score)
    if not halving.values:
        reason = next(iter(trainings.failures.values()), "there was none")
        raise UserError(f"None of the {len(compositions)} compositions could be trained: {reason}")
    decision = decide(halving.finalists, criteria)
    answer = compositions[decision.selected]
    return SearchResult(
        scene=",".join(question.scenes),
        space=space.name,
        margin=settings.margin,
        size=settings.size,
        total=len(question.whole.compositions()),
        compositions=compositions,
        costs=costs,
        reasons=question.reasons,
        trainings=trainings,
        halving=halving,
        decision=decision,
        contributions=[
            *estimate_contributions(space, compositions, halving.values, criteria.cost, scenes),
            *_estimate_pruned(question, answer),
        ],
        buffers=_buffer_rows(question, trainings.config(decision.selected, 0, 0)),
    )


def _trainings(question: Question, compositions: Sequence[ModelComposition]) -> Trainings:
    return Trainings(
        compositions=compositions, rungs=question.settings.rungs, files=question.files, experiment=question.experiment
    )


def _buffer_rows(question: Question, answer: TrainingConfig) -> list[dict[str, Any]]:
    configs = representative_configs(question.whole)
    names = frozenset[str]().union(*(config.model().requires for config in configs))
    seconds = measure_rendering(question.scenes[0], question.cfg.path) if question.settings.render_costs else {}
    return buffer_rows(names, answer.model().requires, question.settings.size, int(answer.cfg.task.scale), seconds)


def _estimate_pruned(question: Question, answer: ModelComposition) -> list[Contribution]:
    """Return the time that each part which was not searched would take: of the answer with the part and without."""
    pruned = [
        (switch, switch.fullest, remaining.plainest)
        for switch, remaining in zip(question.whole.switches, question.space.switches)
        if len(remaining.options) == 1 < len(switch.options)
    ]
    fuller = [question.whole.compose({**answer.options, switch.name: part}) for switch, part, _ in pruned]
    if not fuller:
        return []
    plain_cost, *costs = _measure_costs(question, [answer, *fuller], "left_out")
    unknown = Estimate(math.nan, math.nan, math.nan, 0)
    return [
        Contribution(
            switch=switch.name, part=part, without=without, rung=0, pairs=0, db=unknown, ms=cost.ms - plain_cost.ms
        )
        for (switch, part, without), cost in zip(pruned, costs)
        if part != without
    ]


def _check_steps(settings: Settings, trainings: Trainings) -> None:
    count = len(trainings.compositions)
    first = sum(trainings.steps(c, 0) for c in range(count))
    if settings.steps is not None and first > settings.steps:
        raise UserError(
            f"Invalid steps={settings.steps}: the first round of {count} compositions takes {first}; allow more, set "
            "smaller rungs, or fix a switch on the command line."
        )


def _count_affordable(settings: Settings, trainings: Trainings, rung: int) -> int:
    """Return how many candidates the remaining steps allow on a rung."""
    count = len(trainings.compositions)
    largest = max(trainings.steps(c, rung) for c in range(count))
    if settings.steps is None or not largest:
        return count
    return (settings.steps - trainings.spent) // largest


def _select_candidates(question: Question) -> list[ModelComposition]:
    settings, space = question.settings, question.space
    if settings.search == "optuna":
        return _propose_candidates(question)
    compositions = space.compositions()
    if len(compositions) > settings.walk:
        raise UserError(
            f"The space {space.name} has {len(compositions)} compositions, more than walk={settings.walk}: set "
            "search=optuna, a larger walk, or fix a switch on the command line."
        )
    return compositions


def _propose_candidates(question: Question) -> list[ModelComposition]:
    settings, space, name = question.settings, question.space, question.name
    reference = TrainingConfig.compose(space.compositions()[0].overrides).model()

    def evaluate(composition: ModelComposition) -> tuple[float, float] | None:
        trainings = _trainings(question, [composition])
        values = trainings.score(0, 0)
        if values is None:
            return None
        model = trainings.config(0, 0, 0).model()
        time, reference_time = measure_frame_times([model, reference], settings.size, settings.frames)
        return float(values.mean()), time.ms / reference_time.ms

    # The first round, and so the study, does not depend on the margin or on later rounds.
    study = f"{name} {settings.rungs.epochs[0]} {' '.join(space.recipe)}"
    candidates = propose(space, settings.trials, settings.out / f"{name}.optuna.db", study, evaluate)
    if not candidates:
        raise UserError(f"None of trials={settings.trials} compositions could be trained: see the messages above.")
    sys.stdout.write(f"Optuna tried {len(candidates)} of {len(space.compositions())} compositions.\n")
    return candidates


def _measure_costs(
    question: Question, compositions: Sequence[ModelComposition], file: str = "times"
) -> list[FrameTime]:
    size, frames = question.settings.size, question.settings.frames
    configs = [TrainingConfig.compose(composition.overrides) for composition in compositions]
    keys = [
        cache_key(OmegaConf.to_container(config.cfg.model, resolve=True), config.cfg.task.scale, size, frames)
        for config in configs
    ]
    cache = TimeCache(question.settings.out / f"{question.name}.{file}.json")
    return cache.times(keys, [config.model() for config in configs], size, frames)
