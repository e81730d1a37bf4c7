"""One job: find or begin its run, fit, score, log."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from filelock import FileLock, Timeout
from hydra.utils import instantiate
from mlflow.entities import Run
from omegaconf import DictConfig, OmegaConf

from supersampling.data.module import DataSource, fingerprint
from supersampling.errors import clear_traceback_frames, was_interrupted
from supersampling.evaluation.result import evaluate
from supersampling.evaluation.score import evaluation_requires
from supersampling.losses import Loss
from supersampling.metrics.selection import Metrics
from supersampling.models.base import Upsampler
from supersampling.models.count import size_of
from supersampling.runs import tags
from supersampling.runs.experiment import FINISHED, PARENT_VARIABLE, Experiment
from supersampling.runs.identity import SCHEME, Identity, flat_parameters, identity
from supersampling.runs.method import CONFIGURATION, load_weights_of_run
from supersampling.runs.naming import is_learned, method_name
from supersampling.runs.options import described
from supersampling.runs.scores import TUNED, has_metrics, log_result, tuned_constants
from supersampling.training.fit import choose_constants, fit

Files = Mapping[str, list[Path]]


def fitting_buffers(cfg: DictConfig) -> frozenset[str]:
    """Return the buffers that decide a configuration's weights or constants: those of model, loss and window choice."""
    model: Upsampler = instantiate(cfg.model)
    names = model.requires | {"target"}
    if is_learned(model):
        names |= model.compares | instantiate(cfg.loss).requires | instantiate(cfg.pick).requires
    return names


def scoring_buffers(cfg: DictConfig) -> frozenset[str]:
    """Return the buffers of a test clip that a configuration's model and metrics read."""
    return evaluation_requires(instantiate(cfg.model), instantiate(cfg.metrics))


def data_files(cfg: DictConfig, jobs: Sequence[DictConfig]) -> Files:
    """Return the files of every split, with the buffers that these jobs read; metrics read the test clips only."""
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
    announce: bool = True  # print a line when there is nothing left to do

    @cached_property
    def learned(self) -> bool:
        return is_learned(instantiate(self.cfg.model))

    @cached_property
    def _fingerprints(self) -> dict[str, str]:
        names = fitting_buffers(self.cfg)
        return {split: fingerprint(files, names) for split, files in self.files.items()}

    @cached_property
    def identity(self) -> Identity:
        """Of the job's run: the only place where one is computed."""
        return identity(self.cfg, self._fingerprints, self.learned)

    @cached_property
    def folder(self) -> Path:
        """Of the job's checkpoint and lock; jobs that differ in their protocol only share it."""
        weights = identity(self.cfg, self._fingerprints, self.learned, weights_only=True)
        folders = [Path(self.cfg.paths.checkpoints) / key for key in (weights.former, weights.key)]
        return next((folder for folder in folders if folder.exists()), folders[-1])

    @property
    def name(self) -> str:
        parts = [method_name(self.choices)]
        if self.learned:
            loss: Loss = instantiate(self.cfg.loss)
            parts += [loss.label or str(self.choices["loss"]), f"seed={self.cfg.seed}"]
        return " ".join([*parts, f"x{self.cfg.task.scale}"])

    def run(self) -> None:
        """Do the job unless its identity has finished; an unfinished one continues from its checkpoint.

        A finished one that lacks a metric is scored again; the scores that it has are kept.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(self.folder / "lock")
        try:
            lock.acquire(timeout=0)
        except Timeout:
            print(f"{self.name}: another process works on the same job; waiting for it.", flush=True)
            lock.acquire()
        try:
            self._run_locked()
        finally:
            lock.release()

    def _run_locked(self) -> None:
        metrics: Metrics = instantiate(self.cfg.metrics)
        previous = None if self.cfg.fresh else self.experiment.find(self.identity)
        finished = previous is not None and previous.info.status == FINISHED
        if previous is not None and finished and has_metrics(previous, metrics):
            if self.announce:
                print(f"{self.name}: finished before as run {previous.info.run_id}; fresh=true repeats it.")
            return
        run_id = self._begin() if previous is None else self._continue(previous)
        try:
            print(f"{self.name}: run {run_id}{', scored again' if finished else ''}", flush=True)
            model = self._finished_model(previous) if previous is not None and finished else self._fit(run_id)
            result = evaluate(model, metrics, instantiate(self.cfg.protocol), self.files["test"])
            log_result(self.experiment, run_id, result, size_of(model))
            self.experiment.finish(run_id)
        except BaseException as error:
            clear_traceback_frames(error)  # an interrupted transaction holds the store's lock
            # A finished run stays finished if further scores could not be added.
            status = FINISHED if finished else "KILLED" if was_interrupted(error) else "FAILED"
            self.experiment.finish(run_id, status)
            raise

    def _begin(self) -> str:
        run_tags = {
            tags.KIND: "job",
            tags.IDENTITY: self.identity.key,
            tags.SCHEME: SCHEME,
            tags.DATASET: fingerprint(self.files["test"], ["target"]),
            tags.METHOD: method_name(self.choices),
        }
        run_id = self.experiment.start(self.name, run_tags, os.environ.get(PARENT_VARIABLE))
        self.experiment.log_params(run_id, flat_parameters(self.cfg, self.choices, self.learned))
        config = OmegaConf.create(described(OmegaConf.to_container(self.cfg, resolve=True)))
        self.experiment.client.log_text(run_id, OmegaConf.to_yaml(config), CONFIGURATION)
        if self.cfg.fresh:
            (self.folder / "last.ckpt").unlink(missing_ok=True)
        return run_id

    def _continue(self, run: Run) -> str:
        run_id = str(run.info.run_id)
        self.experiment.restart(run_id, os.environ.get(PARENT_VARIABLE))
        # Parameters that a run of an earlier version does not have.
        self.experiment.log_params(run_id, flat_parameters(self.cfg, self.choices, self.learned))
        return run_id

    def _fit(self, run_id: str) -> Upsampler:
        if self.learned:
            return fit(self.cfg, self.files, self.folder, self.experiment, run_id)
        model, constants = choose_constants(self.cfg, self.files["train"])
        self.experiment.log_params(run_id, {f"{TUNED}{k}": v for k, v in constants.items()})
        return model

    def _finished_model(self, run: Run) -> Upsampler:
        """Return the method of a finished run, with its weights or its tuned constants."""
        model: Upsampler = instantiate(self.cfg.model, **tuned_constants(run))
        if self.learned:
            load_weights_of_run(model, self.experiment, run.info.run_id)
        return model
