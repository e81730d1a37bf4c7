"""One job of ``train.py``: render what is missing, find or begin its run, fit, score, log."""

import copy
import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
import torch
from filelock import FileLock, Timeout
from hydra import compose
from hydra.core.hydra_config import HydraConfig
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf, open_dict

from supersampling.data.module import Source, fingerprint
from supersampling.data.spec import SPLITS
from supersampling.errors import was_interrupted
from supersampling.metrics.suite import Suite
from supersampling.models.base import Upsampler
from supersampling.training.check import check_numbers
from supersampling.training.crops import save_crops, strip
from supersampling.training.evaluation import by_clip, evaluation_requires, score, summary, whole_clips
from supersampling.training.fit import choose_constants, fit
from supersampling.training.identity import flat_parameters, identity
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
    source: Source = instantiate(cfg.data)
    jobs = [*_baselines(cfg), (cfg, dict(HydraConfig.get().runtime.choices))]
    files = source.files(SPLITS, frozenset().union(*(required_buffers(composed) for composed, _ in jobs)))
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


def required_buffers(cfg: DictConfig) -> frozenset[str]:
    """All that a configuration reads: what its model and metrics read and, if it is trained, its loss and choice of windows."""
    return _required(cfg, instantiate(cfg.model))


def _required(cfg: DictConfig, model: Upsampler) -> frozenset[str]:
    names = evaluation_requires(model, instantiate(cfg.metrics))
    if is_learned(model):
        names |= model.compares | instantiate(cfg.loss).requires | instantiate(cfg.pick).requires
    return names


@dataclass(frozen=True)
class Job:
    """A configured method on a data set, with the run that holds its result."""

    cfg: DictConfig
    choices: Mapping[str, str]
    files: Files
    experiment: Experiment
    announce: bool = True  # say so when there is nothing left to do

    def run(self) -> None:
        """Do the job unless its identity has finished; an unfinished one goes on from its checkpoint."""
        model: Upsampler = instantiate(self.cfg.model)
        learned = is_learned(model)
        names = _required(self.cfg, model)
        key = identity(self.cfg, {s: fingerprint(f, names) for s, f in self.files.items()}, learned)
        folder = Path(self.cfg.paths.checkpoints) / key
        folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / "lock")
        try:
            lock.acquire(timeout=0)
        except Timeout:
            print(f"{self._name(learned)}: another process is at this very job; waiting for it.", flush=True)
            lock.acquire()
        try:
            self._run_once(key, folder, learned)
        finally:
            lock.release()

    def _run_once(self, key: str, folder: Path, learned: bool) -> None:
        name = self._name(learned)
        found = self.experiment.find(key)
        if found is not None and found.info.status == "FINISHED" and not self.cfg.fresh:
            if self.announce:
                print(f"{name}: finished before as run {found.info.run_id}; fresh=true repeats it.")
            return
        parent = os.environ.get(PARENT_VARIABLE)
        if found is None or self.cfg.fresh:
            run_id = self._begin(name, key, parent, learned)
            (folder / "last.ckpt").unlink(missing_ok=True)
        else:
            run_id = found.info.run_id
            self.experiment.restart(run_id, parent)
        try:
            print(f"{name}: run {run_id}", flush=True)
            model = (
                fit(self.cfg, self.files, folder, self.experiment, run_id)
                if learned
                else self._classical(run_id)
            )
            self._score(model, run_id)
        except BaseException as error:
            self.experiment.finish(run_id, "KILLED" if was_interrupted(error) else "FAILED")
            raise
        self.experiment.finish(run_id)

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

    def _score(self, model: Upsampler, run_id: str) -> None:
        result = evaluate(model, instantiate(self.cfg.metrics), self.files["test"])
        count = sum(p.numel() for p in model.parameters())
        log_result(self.experiment, run_id, result, {"model/parameters": float(count)})


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
    swapped = [
        f"{s}={choices[f'model/{s}']}" for s in stages if choices.get(f"model/{s}", stages[s]) != stages[s]
    ]
    return " ".join([model, *swapped])


@dataclass(frozen=True)
class Result:
    """What a test run gives: per-frame and per-clip tables, and a folder of crops."""

    frames: pd.DataFrame
    clips: pd.DataFrame
    crops: tempfile.TemporaryDirectory


def evaluate(model: Upsampler, metrics: Suite, paths: list[Path]) -> Result:
    """Score ``model`` on whole test clips and keep the crops of each scene's first clip's last frame."""
    crops = tempfile.TemporaryDirectory(prefix="crops")
    scored: list[dict] = []
    scenes: list[str] = []
    for frame in score(model, metrics, whole_clips(paths, evaluation_requires(model, metrics))):
        scored.append(frame.row)
        if frame.index == frame.length - 1 and frame.name.clip == 0:
            save_crops(frame, Path(crops.name), len(scenes))
            scenes.append(frame.name.scene)
    frames = pd.DataFrame(scored)
    return Result(frames, by_clip(frames), crops)


def log_result(experiment: Experiment, run_id: str, result: Result, more: Mapping[str, float]) -> None:
    """Log the means as metrics, the tables and the crops as artifacts."""
    client = experiment.client
    experiment.log_metrics(run_id, {**summary(result.clips), **more})
    client.log_table(run_id, result.clips, "clips.json")
    client.log_table(run_id, result.frames, "frames.json")
    client.log_artifacts(run_id, result.crops.name, "crops")
    client.log_image(run_id, strip(Path(result.crops.name)), "crops.png")
    result.crops.cleanup()
