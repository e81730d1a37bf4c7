"""The search itself: candidates, what they cost, rounds of trainings, and what they say."""

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass

from omegaconf import DictConfig, OmegaConf

from supersampling.advice.answer import Found
from supersampling.advice.contributions import Contribution, contributions
from supersampling.advice.cost import Cost, Remembered, buffer_rows, frame_times, key_of, rendering
from supersampling.advice.halving import Terms, Values, decide, halve
from supersampling.advice.prior import Reason
from supersampling.advice.proposals import propose
from supersampling.advice.settings import Settings
from supersampling.advice.space import Composition, Space
from supersampling.advice.trainings import Composed, Trainings
from supersampling.errors import UserError
from supersampling.runs.experiment import Experiment
from supersampling.runs.statistics import Estimate
from supersampling.training.job import Files


@dataclass(frozen=True)
class Question:
    """What is searched: of the ``whole`` space what is left, ``space``, with the ``reasons``, on the ``files`` of ``scenes``."""

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
        return f"{'_'.join(self.scenes)}_{self.space.name}".replace("/", "_")


def varied(space: Space) -> list[Composed]:
    """Compositions that together read what all of them do: the fullest, with every option in turn."""
    fullest = {switch.name: next(iter(switch.options)) for switch in space.switches}
    chosen = {
        space.compose({**fullest, switch.name: option}).overrides
        for switch in space.switches
        for option in switch.options
    }
    return [Composed.of(overrides) for overrides in sorted(chosen | {space.compose(fullest).overrides})]


def search(question: Question) -> Found:
    """Train, compare, decide.

    Raises:
        UserError: too many compositions or steps, or nothing that trains.
    """
    settings, space = question.settings, question.space
    compositions = _candidates(question)
    trainings = Trainings(compositions, settings.rungs, question.files, question.experiment)
    costs = _costs(question, compositions)
    _check_steps(settings, trainings)
    places: list[str] = []  # each clip's scene, known with the first scores
    terms = Terms(
        [c.ms for c in costs],
        settings.margin,
        places,
        lambda rung: _room(settings, trainings, rung),
        [(c.low, c.high) for c in costs],
        [space.parts(c.options) for c in compositions],
    )

    def score(candidate: int, rung: int) -> Values | None:
        values = trainings.score(candidate, rung)
        places[:] = [scene for scene, _ in trainings.places]
        return values

    found = halve(range(len(compositions)), len(settings.rungs.epochs), terms, score)
    if not found.values:
        reason = next(iter(trainings.failures.values()), "there was none")
        raise UserError(f"None of the {len(compositions)} compositions could be trained: {reason}")
    decided = decide({c: v for (rung, c), v in found.values.items() if rung == found.last}, terms)
    chosen = trainings.composed(decided.chosen, 0, 0)
    every = frozenset[str]().union(*(c.model().requires for c in varied(question.whole)))
    seconds = rendering(question.scenes[0], question.cfg.path) if settings.render_costs else {}
    return Found(
        scene=",".join(question.scenes),
        space=space.name,
        margin=settings.margin,
        size=settings.size,
        total=len(question.whole.compositions()),
        compositions=compositions,
        costs=costs,
        reasons=question.reasons,
        trainings=trainings,
        search=found,
        answer=decided,
        parts=[
            *contributions(space, compositions, found.values, terms.cost, places),
            *_not_searched(question, compositions[decided.chosen]),
        ],
        buffers=buffer_rows(every, chosen.model().requires, settings.size, int(chosen.cfg.task.scale), seconds),
    )


def _not_searched(question: Question, chosen: Composition) -> list[Contribution]:
    """What each part that was left out would have taken: of the answer with it, and without."""
    gone = [
        (switch, next(iter(switch.options)), kept.plainest)
        for switch, kept in zip(question.whole.switches, question.space.switches)
        if len(kept.options) == 1 < len(switch.options)
    ]
    others = [question.whole.compose({**chosen.options, switch.name: part}) for switch, part, _ in gone]
    if not others:
        return []
    plain, *fuller = _costs(question, [chosen, *others], "left_out")
    nothing = Estimate(math.nan, math.nan, math.nan, 0)
    return [
        Contribution(switch.name, part, without, 0, 0, nothing, cost.ms - plain.ms)
        for (switch, part, without), cost in zip(gone, fuller)
        if part != without
    ]


def _check_steps(settings: Settings, trainings: Trainings) -> None:
    first = sum(trainings.steps(c, 0) for c in range(len(trainings.compositions)))
    if settings.steps is not None and first > settings.steps:
        raise UserError(
            f"steps={settings.steps} is not possible: the first round of {len(trainings.compositions)} compositions alone takes "
            f"{first}; allow more, set smaller rungs, or fix a switch on the command line."
        )


def _room(settings: Settings, trainings: Trainings, rung: int) -> int:
    """How many trainings of a rung the steps that are left allow."""
    count = len(trainings.compositions)
    dearest = max(trainings.steps(c, rung) for c in range(count))
    if settings.steps is None or not dearest:
        return count
    return (settings.steps - trainings.spent) // dearest


def _candidates(question: Question) -> list[Composition]:
    settings, space, name = question.settings, question.space, question.name
    if settings.search == "halving":
        every = space.compositions()
        if len(every) > settings.walk:
            raise UserError(
                f"The space {space.name} has {len(every)} compositions, more than walk={settings.walk}: set search=optuna, a "
                "larger walk, or fix a switch on the command line."
            )
        return every
    reference = Composed.of(space.compositions()[0].overrides).model()

    def attempt(composition: Composition) -> tuple[float, float] | None:
        trainings = Trainings([composition], settings.rungs, question.files, question.experiment)
        values = trainings.score(0, 0)
        if values is None:
            return None
        model = trainings.composed(0, 0, 0).model()
        ours, theirs = frame_times([model, reference], settings.size, settings.frames)
        return float(values.mean()), ours.ms / theirs.ms

    # Another margin or later round asks the same of the first one.
    key = f"{name} {settings.rungs.epochs[0]} {' '.join(space.recipe)}"
    tried = propose(space, settings.trials, settings.out / f"{name}.optuna.db", key, attempt)
    if not tried:
        raise UserError(f"None of trials={settings.trials} compositions could be trained.")
    sys.stdout.write(f"Optuna tried {len(tried)} of {len(space.compositions())} compositions.\n")
    return tried


def _costs(question: Question, compositions: Sequence[Composition], what: str = "times") -> list[Cost]:
    settings, name = question.settings, question.name
    made = [Composed.of(c.overrides) for c in compositions]
    keys = [
        key_of(
            OmegaConf.to_container(c.cfg.model, resolve=True),
            c.cfg.task.scale,
            settings.size,
            settings.frames,
        )
        for c in made
    ]
    remembered = Remembered(settings.out / f"{name}.{what}.json")
    return remembered.times(keys, [c.model() for c in made], settings.size, settings.frames)
