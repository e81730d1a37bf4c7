"""Proposals of compositions in a space too large to walk: Optuna's multi-objective TPE, for quality and time at once.

Hydra's Optuna sweeper (1.3) pins Optuna 2, whose database does not work with the SQLAlchemy 2 that MLflow requires, and
without a database a stopped search could not continue. So Optuna is called directly.
"""

from collections.abc import Callable, Sequence
from pathlib import Path

from supersampling.advice.space import ModelComposition, Space
from supersampling.errors import UserError

SEED = 0
Evaluate = Callable[[ModelComposition], "tuple[float, float] | None"]
"""Returns the mean quality in dB and the relative time of a composition, or None if it failed."""


def propose(space: Space, trials: int, storage: Path, name: str, evaluate: Evaluate) -> list[ModelComposition]:
    """Return the compositions that Optuna tried, in its order, each once.

    The database ``storage`` keeps them, so that a stopped search continues.

    Raises:
        UserError: Optuna is not installed.
    """
    try:
        import optuna
    except ImportError as error:
        raise UserError(
            "search=optuna needs Optuna: run pip install 'supersampling[advise]', or use search=halving."
        ) from error
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    storage.parent.mkdir(parents=True, exist_ok=True)
    study = optuna.create_study(
        study_name=name, storage=f"sqlite:///{storage}", directions=["maximize", "minimize"], load_if_exists=True
    )
    remaining = trials - sum(trial.state.is_finished() for trial in study.trials)
    for _ in range(max(remaining, 0)):
        # Seeded by the number of the trial, so that a search that was stopped proposes the same compositions.
        study.sampler = optuna.samplers.TPESampler(
            seed=SEED + len(study.trials), n_startup_trials=_count_random_trials(space)
        )
        trial = study.ask()
        options = space.settle({s.name: trial.suggest_categorical(s.name, list(s.options)) for s in space.switches})
        result = evaluate(space.compose(options))
        if result is None:
            study.tell(trial, state=optuna.trial.TrialState.FAIL)
        else:
            study.tell(trial, result)
    return _unique_compositions(space, [trial.params for trial in study.trials if trial.params])


def _count_random_trials(space: Space) -> int:
    """Return the number of random trials before the model is used: a few for each option of the widest switch."""
    return 3 * max(len(switch.options) for switch in space.switches)


def _unique_compositions(space: Space, params: Sequence[dict[str, str]]) -> list[ModelComposition]:
    options = [space.settle({s.name: trial[s.name] for s in space.switches}) for trial in params]
    return list({c.name: c for c in map(space.compose, options)}.values())
