"""Candidates as ordinary jobs of train.py: each is composed, trained unless it was before, and scored."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from hydra.utils import instantiate
from mlflow.entities import Run
from omegaconf import DictConfig

from supersampling.advice.halving import Values
from supersampling.advice.space import ModelComposition, merge_overrides
from supersampling.config import composed
from supersampling.errors import UserError
from supersampling.models.base import Upsampler
from supersampling.runs import tags
from supersampling.runs.experiment import Experiment
from supersampling.runs.naming import is_learned
from supersampling.runs.scores import scores_of
from supersampling.training.check import check_training
from supersampling.training.job import Files, Job, fitting_buffers, scoring_buffers
from supersampling.training.schedule import optimizer_steps

METRIC = "psnr"


@dataclass(frozen=True)
class TrainingConfig:
    """A composition's configuration for train.py, and Hydra's choices."""

    cfg: DictConfig
    choices: Mapping[str, str]

    @classmethod
    def compose(cls, overrides: Sequence[str]) -> "TrainingConfig":
        """Return the configuration of train.py with these overrides."""
        composition = composed("train", merge_overrides(["baselines=[]", "metrics=fast", *overrides]))
        check_training(composition.cfg)
        return cls(composition.cfg, composition.choices)

    @property
    def steps(self) -> int:
        """Optimizer steps of the training; 0 for a classical method."""
        return optimizer_steps(self.cfg) if is_learned(self.model()) else 0

    def model(self) -> Upsampler:
        """Return the model with random weights."""
        model: Upsampler = instantiate(self.cfg.model)
        return model

    @property
    def buffers(self) -> frozenset[str]:
        """The buffers that training and scoring read."""
        return fitting_buffers(self.cfg) | scoring_buffers(self.cfg)


@dataclass(frozen=True)
class Rungs:
    """Epochs and seeds of every rung, the cheapest first."""

    epochs: tuple[int, ...]
    seeds: tuple[int, ...]

    @property
    def last(self) -> int:
        """The index of the last rung."""
        return len(self.epochs) - 1

    def overrides(self, rung: int, seed: int) -> list[str]:
        """Return the overrides of a training on a rung."""
        return [f"budget.epochs={self.epochs[rung]}", f"seed={seed}"]


@dataclass(kw_only=True)
class Trainings:
    """The trainings of the candidates, and their scores.

    ``spent`` is the number of steps, ``count`` the number of trainings and ``minutes`` the time that this search
    needed, whether they were trained now or earlier. ``places`` are the scene and clip of each value.
    """

    compositions: Sequence[ModelComposition]
    rungs: Rungs
    files: Files
    experiment: Experiment
    spent: int = 0
    count: int = 0
    minutes: float = 0.0
    failures: dict[int, str] = field(default_factory=dict)
    places: list[tuple[str, int]] = field(default_factory=list)
    counted: set[str] = field(default_factory=set)
    configs: dict[tuple[int, int, int], TrainingConfig] = field(default_factory=dict)

    def config(self, candidate: int, rung: int, seed: int) -> TrainingConfig:
        """Return the configuration of a candidate's training."""
        key = candidate, rung, seed
        if key not in self.configs:
            overrides = [*self.compositions[candidate].overrides, *self.rungs.overrides(rung, seed)]
            self.configs[key] = TrainingConfig.compose(overrides)
        return self.configs[key]

    def steps_per_seed(self, candidate: int, rung: int) -> int:
        """Return the steps of one training of a rung."""
        return self.config(candidate, rung, 0).steps

    def steps(self, candidate: int, rung: int) -> int:
        """Return the steps of all seeds of a rung."""
        return self.steps_per_seed(candidate, rung) * self.rungs.seeds[rung]

    def score(self, candidate: int, rung: int) -> Values | None:
        """Return the values of every seed and clip, ``(seeds, clips)``; None if training fails by a user error."""
        rows = []
        name = self.compositions[candidate].name
        for seed in range(self.rungs.seeds[rung]):
            print(f"[rung {rung + 1}] {name}, seed {seed}", flush=True)
            try:
                rows.append(self._train(candidate, rung, seed))
            except UserError as error:
                self.failures[candidate] = str(error)
                sys.stderr.write(f"{name} is left out: {error}\n")
                return None
        return np.stack(rows)

    def _train(self, candidate: int, rung: int, seed: int) -> Values:
        config = self.config(candidate, rung, seed)
        job = Job(config.cfg, config.choices, self.files, self.experiment, announce=False)
        before = self.experiment.find(job.identity)
        job.run()
        run = self.experiment.find(job.identity)
        if run is None:
            raise RuntimeError(f"The run of {job.name} disappeared from {self.experiment.location} while it was scored")
        if before is None and config.steps and rung < self.rungs.last:
            self.experiment.client.set_tag(run.info.run_id, tags.SEARCH, str(rung + 1))
        if job.identity.key not in self.counted:
            self.counted.add(job.identity.key)
            self._count(config, run)
        return self._read_values(run)

    def _count(self, config: TrainingConfig, run: Run) -> None:
        self.spent += config.steps
        self.count += 1
        self.minutes += run.data.metrics.get("train/minutes", 0.0)

    def _read_values(self, run: Run) -> Values:
        scores = scores_of(self.experiment, run.info.run_id)
        if scores is None:
            raise UserError(f"Run {run.info.run_id} has no scores: repeat it with train.py fresh=true.")
        table = scores.clips.sort_values(["scene", "clip"])
        self.places = [(str(scene), int(clip)) for scene, clip in zip(table["scene"], table["clip"])]
        values: Values = table[METRIC].to_numpy(dtype=np.float64)
        return values
