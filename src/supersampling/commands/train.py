"""The command ``train``: the classical baselines that a data set still lacks, then the configured job."""

import copy

import torch
from hydra import compose
from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig, open_dict

from supersampling.runs.experiment import experiment_of
from supersampling.runs.sanity import score_sanity
from supersampling.training.check import check_numbers
from supersampling.training.job import Job, data_files


def train(cfg: DictConfig) -> None:
    """What ``train.py`` does: the classical baselines that this data set still lacks, then the configured job."""
    check_numbers(cfg)
    torch.set_num_threads(cfg.threads)
    experiment = experiment_of(cfg)
    jobs = [*_baselines(cfg), (cfg, dict(HydraConfig.get().runtime.choices))]
    files = data_files(cfg, [composed for composed, _ in jobs])
    score_sanity(cfg, files["test"], experiment)
    for composed, choices in jobs:
        Job(composed, choices, files, experiment, announce=composed is cfg).run()


def _baselines(cfg: DictConfig) -> list[tuple[DictConfig, dict[str, str]]]:
    """This job with each baseline's method, and how that is tuned, in place of its own."""
    hydra = HydraConfig.get()
    theirs = ("model", "tune")
    jobs = []
    for baseline in cfg.baselines:
        # By itself: an experiment swaps stages of a method that this one lacks.
        composed = compose(hydra.job.config_name, list(baseline), return_hydra_config=True)
        ours = {k: v for k, v in hydra.runtime.choices.items() if k.split("/")[0] not in theirs}
        method = {k: v for k, v in composed.hydra.runtime.choices.items() if k.split("/")[0] in theirs}
        job = copy.deepcopy(cfg)
        with open_dict(job):
            for key in theirs:
                job.pop(key, None)
                if key in composed:
                    job[key] = composed[key]
        jobs.append((job, ours | method))
    return jobs
