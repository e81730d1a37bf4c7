"""A multirun is one parent run: a Hydra callback that begins it before the jobs and ends it after them."""

import atexit
import os
from typing import Any

from hydra.experimental.callback import Callback
from omegaconf import DictConfig

from supersampling.config import overrides_of


class ParentRun(Callback):
    """Begins an MLflow parent run for a multirun and hands its id to the jobs through the environment.

    Hydra calls nothing when an interrupt stops the sweep; the run is then ended as KILLED when the process exits.
    """

    def on_multirun_start(self, config: DictConfig, **kwargs: Any) -> None:
        from supersampling.commands.entry import run

        run(self._begin, config)

    def _begin(self, config: DictConfig) -> None:
        from supersampling.runs import tags
        from supersampling.runs.experiment import PARENT_VARIABLE, experiment_of

        name = "sweep " + (" ".join(overrides_of(config.hydra)) or "(no overrides)")
        os.environ[PARENT_VARIABLE] = experiment_of(config).start(name[:240], {tags.KIND: "sweep"}, None)
        atexit.register(self._end, config, "KILLED")

    def on_multirun_end(self, config: DictConfig, **kwargs: Any) -> None:
        from supersampling.commands.entry import FAILED

        self._end(config, "FAILED" if FAILED else "FINISHED")

    def _end(self, config: DictConfig, status: str) -> None:
        from supersampling.runs.experiment import PARENT_VARIABLE, experiment_of

        run_id = os.environ.pop(PARENT_VARIABLE, None)
        if run_id is not None:
            experiment_of(config).finish(run_id, status)
