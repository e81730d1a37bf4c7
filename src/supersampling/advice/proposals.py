"""Which compositions of a space too large to walk are tried: Optuna's multi-objective TPE, quality and time at once.

Hydra's Optuna sweeper (1.3) pins Optuna 2, whose database does not open beside the SQLAlchemy 2 that MLflow brings; without a
database a search could not be taken up again. So Optuna itself is called.
"""

from collections.abc import Callable, Sequence
from pathlib import Path

from supersampling.advice.space import Composition, Space
from supersampling.errors import UserError

SEED = 0
Try = Callable[[Composition], "tuple[float, float] | None"]
"""Mean quality in dB and milliseconds of a composition, or None of one that failed."""


def propose(space: Space, trials: int, storage: Path, name: str, attempt: Try) -> list[Composition]:
    """The compositions that Optuna tried, in its order, each once; ``storage`` remembers them, so that a stopped search goes on.

    Raises:
        UserError: Optuna is not installed.
    """
    try:
        import optuna
    except ImportError as error:
        raise UserError(
            "search=optuna needs Optuna: pip install 'supersampling[advise]', or use search=halving."
        ) from error
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    storage.parent.mkdir(parents=True, exist_ok=True)
    study = optuna.create_study(
        study_name=name,
        storage=f"sqlite:///{storage}",
        directions=["maximize", "minimize"],
        load_if_exists=True,
    )
    left = trials - sum(trial.state.is_finished() for trial in study.trials)
    for _ in range(max(left, 0)):
        # Seeded by the trial's number: a search that was stopped proposes what it would have.
        study.sampler = optuna.samplers.TPESampler(seed=SEED + len(study.trials), n_startup_trials=_start(space))
        trial = study.ask()
        options = space.settle({s.name: trial.suggest_categorical(s.name, list(s.options)) for s in space.switches})
        found = attempt(space.compose(options))
        if found is None:
            study.tell(trial, state=optuna.trial.TrialState.FAIL)
        else:
            study.tell(trial, found)
    return _tried(space, [trial.params for trial in study.trials if trial.params])


def _start(space: Space) -> int:
    """Random trials before the model: each option of the widest switch a few times."""
    return 3 * max(len(switch.options) for switch in space.switches)


def _tried(space: Space, params: Sequence[dict[str, str]]) -> list[Composition]:
    found = [space.compose(space.settle({s.name: given[s.name] for s in space.switches})) for given in params]
    return list({composition.name: composition for composition in found}.values())
