"""One job of ``train.py``: render what is missing, find or begin its run, fit, score, log."""

import copy
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from filelock import FileLock, Timeout
from hydra import compose
from hydra.core.hydra_config import HydraConfig
from hydra.utils import instantiate
from mlflow.entities import Run
from omegaconf import DictConfig, OmegaConf, open_dict

from supersampling.data.module import DataSource, fingerprint
from supersampling.errors import let_go, was_interrupted
from supersampling.evaluation.result import evaluate
from supersampling.evaluation.score import evaluation_requires
from supersampling.metrics.selection import Metrics
from supersampling.models.base import Upsampler
from supersampling.profiling.count import size_of
from supersampling.training.check import check_numbers
from supersampling.training.fit import choose_constants, fit, load_weights
from supersampling.training.identity import WEIGHTS_ONLY, flat_parameters, identity
from supersampling.training.log import has_metrics, log_result, tuned_constants
from supersampling.training.sanity import score_sanity
from supersampling.training.tracking import PARENT_VARIABLE, Experiment, open_experiment

Files = Mapping[str, list[Path]]


def experiment_of(cfg: DictConfig) -> Experiment:
    """The MLflow experiment that a configuration names."""
    return open_experiment(cfg.logger.tracking_uri, cfg.logger.experiment, Path(cfg.paths.artifacts))


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


def is_learned(model: Upsampler) -> bool:
    """Whether there is anything to train."""
    return any(p.requires_grad for p in model.parameters())


def fitting_buffers(cfg: DictConfig) -> frozenset[str]:
    """All that decides a configuration's weights or constants: what its model, its loss and its choice of windows read."""
    return _fitting(cfg, instantiate(cfg.model))


def scoring_buffers(cfg: DictConfig) -> frozenset[str]:
    """What a configuration's model and metrics read of a test clip."""
    return evaluation_requires(instantiate(cfg.model), instantiate(cfg.metrics))


def _fitting(cfg: DictConfig, model: Upsampler) -> frozenset[str]:
    names = model.requires | {"target"}
    if is_learned(model):
        names |= model.compares | instantiate(cfg.loss).requires | instantiate(cfg.pick).requires
    return names


def data_files(cfg: DictConfig, jobs: Sequence[DictConfig]) -> Files:
    """The files of every split with the buffers that these jobs read; metrics read the test clips alone."""
    source: DataSource = instantiate(cfg.data)
    fitted = frozenset().union(*map(fitting_buffers, jobs))
    scored = fitted.union(*map(scoring_buffers, jobs))
    return source.files(("train", "val"), fitted) | source.files(("test",), scored)


@dataclass(frozen=True)
class Job:
    """A configured method on a data set, with the run that holds its result."""

    cfg: DictConfig
    choices: Mapping[str, str]
    files: Files
    experiment: Experiment
    announce: bool = True  # say so when there is nothing left to do

    def run(self) -> None:
        """Do the job unless its identity has finished; an unfinished one goes on from its checkpoint. A finished one that lacks a
        metric is scored again; what it has is kept."""
        model: Upsampler = instantiate(self.cfg.model)
        learned = is_learned(model)
        names = _fitting(self.cfg, model)
        content = {s: fingerprint(f, names) for s, f in self.files.items()}
        folder = Path(self.cfg.paths.checkpoints) / identity(self.cfg, content, learned, WEIGHTS_ONLY)
        folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / "lock")
        try:
            lock.acquire(timeout=0)
        except Timeout:
            print(f"{self._name(learned)}: another process is at this very job; waiting for it.", flush=True)
            lock.acquire()
        try:
            self._run_once(identity(self.cfg, content, learned), folder, learned)
        finally:
            lock.release()

    def _run_once(self, key: str, folder: Path, learned: bool) -> None:
        name = self._name(learned)
        metrics: Metrics = instantiate(self.cfg.metrics)
        found = None if self.cfg.fresh else self.experiment.find(key)
        finished = found is not None and found.info.status == "FINISHED"
        if found is not None and finished and has_metrics(found, metrics):
            if self.announce:
                print(f"{name}: finished before as run {found.info.run_id}; fresh=true repeats it.")
            return
        parent = os.environ.get(PARENT_VARIABLE)
        if found is None:
            run_id = self._begin(name, key, parent, learned)
            if self.cfg.fresh:
                (folder / "last.ckpt").unlink(missing_ok=True)
        else:
            run_id = found.info.run_id
            self.experiment.restart(run_id, parent)
            # What a run of an earlier version lacks.
            self.experiment.log_params(run_id, flat_parameters(self.cfg, self.choices, learned))
        try:
            print(f"{name}: run {run_id}{', scored again' if finished else ''}", flush=True)
            if found is not None and finished:
                model = self._finished(found, learned)
            elif learned:
                model = fit(self.cfg, self.files, folder, self.experiment, run_id)
            else:
                model = self._classical(run_id)
            result = evaluate(model, metrics, instantiate(self.cfg.protocol), self.files["test"])
            log_result(self.experiment, run_id, result, size_of(model))
            self.experiment.finish(run_id)
        except BaseException as error:
            let_go(error)  # what it cut short may hold the store's lock
            # Scores that could not be added leave a finished run as it was.
            status = "FINISHED" if finished else "KILLED" if was_interrupted(error) else "FAILED"
            self.experiment.finish(run_id, status)
            raise

    def _finished(self, run: Run, learned: bool) -> Upsampler:
        """The method of a finished run, with its weights or its tuned constants."""
        model: Upsampler = instantiate(self.cfg.model, **tuned_constants(run))
        if learned:
            load_weights(model, self.experiment.artifact(run.info.run_id, "checkpoint/last.ckpt"))
        return model

    def _name(self, learned: bool) -> str:
        parts = [method_name(self.choices)]
        if learned:
            theta = OmegaConf.select(self.cfg, "loss.theta")
            parts.append(f"theta={theta}" if theta is not None else str(self.choices["loss"]))
            parts.append(f"seed={self.cfg.seed}")
        return " ".join([*parts, f"x{self.cfg.task.scale}"])

    def _begin(self, name: str, key: str, parent: str | None, learned: bool) -> str:
        tags = {
            "ss.kind": "job",
            "ss.identity": key,
            "ss.dataset": fingerprint(self.files["test"], ["target"]),
            "ss.method": method_name(self.choices),
        }
        run_id = self.experiment.start(name, tags, parent)
        self.experiment.log_params(run_id, flat_parameters(self.cfg, self.choices, learned))
        self.experiment.client.log_text(run_id, OmegaConf.to_yaml(self.cfg, resolve=True), "config.yaml")
        return run_id

    def _classical(self, run_id: str) -> Upsampler:
        model, constants = choose_constants(self.cfg, self.files["train"])
        self.experiment.log_params(run_id, {f"tuned.{k}": v for k, v in constants.items()})
        return model


# The stages that a method is published with; a run that swaps one says so in its name.
_PUBLISHED = {
    "dlctus": {"reproject": "bicubic9", "dilate": "none", "pad": "jitter_aligned", "accumulate": "buffer"},
    "tus": {"reproject": "bicubic9", "dilate": "none", "pad": "jitter_aligned", "rectify": "clamp_rgb"},
    "nsrr": {
        "extract": "learned", "upsample": "zero", "warp_at": "target", "reweight": "learned", "colour_space": "ycbcr",
        "demodulate": "display", "guides": "none", "base": "none",
    },
    "nsrd": {
        "demodulate": "lighting", "motion_mask": "dual", "recur": "convlstm", "locate": "none", "base": "none",
    },
    "enss": {
        "flow": "motion_vectors", "history": "blended", "kernel_prediction": "both", "motion_grid": "block",
    },
}  # fmt: skip


def method_name(choices: Mapping[str, Any]) -> str:
    """``dlctus``, or ``dlctus reproject=bilinear`` when a stage differs from the published one."""
    model = choices["model"]
    stages = _PUBLISHED.get(str(model).partition("_")[0], {})  # a size or a faster form has the same stages
    swapped = [f"{s}={choices[f'model/{s}']}" for s in stages if choices.get(f"model/{s}", stages[s]) != stages[s]]
    return " ".join([model, *swapped])
