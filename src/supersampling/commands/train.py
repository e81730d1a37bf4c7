"""The command ``train``: the classical baselines that a data set still lacks, then the configured job."""

import copy
import sys

import torch
from omegaconf import DictConfig, open_dict

from supersampling import config
from supersampling.runs.experiment import experiment_of
from supersampling.runs.sanity import score_sanity
from supersampling.training.check import check_training, unread_jitter
from supersampling.training.job import Job, data_files

METHOD_KEYS = ("model", "tune")


def train(cfg: DictConfig) -> None:
    """Render what is missing, score the classical baselines once, then do the configured job.

    Raises:
        UserError: a setting, scene, store or device that the user can correct.
    """
    check_training(cfg)
    warning = unread_jitter(cfg, config.choices()["model"])
    if warning is not None:
        sys.stderr.write(f"warning: {warning}\n")
    torch.set_num_threads(cfg.threads)
    experiment = experiment_of(cfg)
    jobs = [*baselines(cfg), (cfg, config.choices())]
    files = data_files(cfg, [job_cfg for job_cfg, _ in jobs])
    score_sanity(cfg, files["test"], experiment)
    for job_cfg, choices in jobs:
        Job(job_cfg, choices, files, experiment, announce=job_cfg is cfg).run()


def baselines(cfg: DictConfig) -> list[tuple[DictConfig, dict[str, str]]]:
    """Return this job with each baseline's method, and its tuning, in place of its own; and Hydra's choices of each."""
    jobs = []
    for overrides in cfg.baselines:
        # Composed on its own: an experiment swaps stages that this method does not have.
        baseline = config.composed("train", list(overrides))
        choices = {k: v for k, v in config.choices().items() if k.split("/")[0] not in METHOD_KEYS}
        method = {k: v for k, v in baseline.choices.items() if k.split("/")[0] in METHOD_KEYS}
        job = copy.deepcopy(cfg)
        with open_dict(job):
            for key in METHOD_KEYS:
                job.pop(key, None)
                if key in baseline.cfg:
                    job[key] = baseline.cfg[key]
        jobs.append((job, choices | method))
    return jobs
