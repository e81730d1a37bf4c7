"""Candidates as ordinary jobs of train.py: each is composed, trained unless it was before, and its clips' scores are read."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd
from hydra.utils import instantiate
from mlflow.entities import Run
from omegaconf import DictConfig

from supersampling.advice.halving import Values
from supersampling.advice.space import Composition, merged
from supersampling.config import composed
from supersampling.errors import UserError
from supersampling.models.base import Upsampler
from supersampling.runs import tags
from supersampling.runs.experiment import Experiment
from supersampling.runs.naming import is_learned
from supersampling.runs.scores import scores_of
from supersampling.training.check import check_numbers
from supersampling.training.job import Files, Job, fitting_buffers, scoring_buffers

METRIC = "psnr"


@dataclass(frozen=True)
class Composed:
    """A composition's configuration for train.py, and Hydra's choices."""

    cfg: DictConfig
    choices: Mapping[str, str]

    @classmethod
    def of(cls, overrides: Sequence[str]) -> "Composed":
        composition = composed("train", merged(["baselines=[]", "metrics=fast", *overrides]))
        check_numbers(composition.cfg)
        return cls(composition.cfg, composition.choices)

    @property
    def steps(self) -> int:
        """Optimizer steps of its training; 0 of a classical method."""
        return int(self.cfg.budget.epochs) * int(self.cfg.budget.steps) if is_learned(self.model()) else 0

    def model(self) -> Upsampler:
        model: Upsampler = instantiate(self.cfg.model)
        return model

    @property
    def reads(self) -> frozenset[str]:
        """What training and scoring read."""
        return fitting_buffers(self.cfg) | scoring_buffers(self.cfg)


@dataclass(frozen=True)
class Rungs:
    """Epochs and seeds of every rung, the cheapest first."""

    epochs: tuple[int, ...]
    seeds: tuple[int, ...]

    def overrides(self, rung: int, seed: int) -> list[str]:
        return [f"budget.epochs={self.epochs[rung]}", f"seed={seed}"]


@dataclass
class Trainings:
    """Trains and scores candidates; ``spent`` counts the steps that this search needed, ``minutes`` what they took, whether they
    were made now or before."""

    compositions: Sequence[Composition]
    rungs: Rungs
    files: Files
    experiment: Experiment
    spent: int = 0
    count: int = 0
    minutes: float = 0.0
    failures: dict[int, str] = field(default_factory=dict)
    places: list[tuple[str, int]] = field(default_factory=list)
    seen: set[str] = field(default_factory=set)
    made: dict[tuple[int, int, int], Composed] = field(default_factory=dict)

    def composed(self, candidate: int, rung: int, seed: int) -> Composed:
        key = candidate, rung, seed
        if key not in self.made:
            overrides = [*self.compositions[candidate].overrides, *self.rungs.overrides(rung, seed)]
            self.made[key] = Composed.of(overrides)
        return self.made[key]

    def steps(self, candidate: int, rung: int) -> int:
        """Of all seeds of a rung."""
        return self.composed(candidate, rung, 0).steps * self.rungs.seeds[rung]

    def score(self, candidate: int, rung: int) -> Values | None:
        """Values of every seed and clip ``(seeds, clips)``, or None where a training fails by what the user can mend."""
        rows = []
        for seed in range(self.rungs.seeds[rung]):
            print(f"[rung {rung + 1}] {self.compositions[candidate].name}, seed {seed}", flush=True)
            try:
                rows.append(self._one(candidate, rung, seed))
            except UserError as error:
                self.failures[candidate] = str(error)
                sys.stderr.write(f"{self.compositions[candidate].name} is left out: {error}\n")
                return None
        return np.stack(rows)

    def _one(self, candidate: int, rung: int, seed: int) -> np.ndarray[Any, np.dtype[np.float64]]:
        composed = self.composed(candidate, rung, seed)
        job = Job(composed.cfg, composed.choices, self.files, self.experiment, announce=False)
        before = self.experiment.find(job.identity)
        job.run()
        run = self.experiment.find(job.identity)
        if run is None:
            raise RuntimeError(
                f"The run of {job.name} disappeared from {self.experiment.tracking_uri} while it was scored"
            )
        key = job.identity.key
        if before is None and composed.steps and rung + 1 < len(self.rungs.epochs):
            self.experiment.client.set_tag(run.info.run_id, tags.SEARCH, str(rung + 1))
        if key not in self.seen:
            self.seen.add(key)
            self._count(composed, run)
        return self._values(run)

    def _count(self, composed: Composed, run: Run) -> None:
        self.spent += composed.steps
        self.count += 1
        self.minutes += run.data.metrics.get("train/minutes", 0.0)

    def _values(self, run: Run) -> np.ndarray[Any, np.dtype[np.float64]]:
        scores = scores_of(self.experiment, run.info.run_id)
        if scores is None:
            raise UserError(f"Run {run.info.run_id} has lost its scores: repeat it with train.py fresh=true.")
        table: pd.DataFrame = scores.clips.sort_values(["scene", "clip"])
        self.places = [(str(s), int(c)) for s, c in zip(table["scene"], table["clip"])]
        return table[METRIC].to_numpy(dtype=np.float64)
