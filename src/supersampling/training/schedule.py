"""The learning rate's schedule, which counts the optimizer steps that a training takes."""

import copy
import math

from omegaconf import DictConfig, OmegaConf

from supersampling.training.trainer_settings import epoch_batches


def epoch_steps(cfg: DictConfig) -> int:
    """Return the optimizer steps of an epoch: ``budget.steps``, unless ``trainer.`` limits or accumulates batches."""
    batches = epoch_batches(OmegaConf.select(cfg, "trainer.limit_train_batches"), int(cfg.budget.steps))
    return math.ceil(batches / (OmegaConf.select(cfg, "trainer.accumulate_grad_batches") or 1))


def optimizer_steps(cfg: DictConfig) -> int:
    """Return the optimizer steps of the whole training."""
    return int(cfg.budget.epochs) * epoch_steps(cfg)


def scheduled(cfg: DictConfig) -> DictConfig:
    """Return the configuration with ``budget.scheduler`` for the optimizer steps that are taken.

    ``conf/budget`` writes the schedules in terms of ``budget.steps``. Numbers that the user sets stay.
    """
    counted, result = copy.deepcopy(cfg), copy.deepcopy(cfg)
    counted.budget.steps = epoch_steps(cfg)
    result.budget.scheduler = OmegaConf.create(OmegaConf.to_container(counted.budget.scheduler, resolve=True))
    return result
