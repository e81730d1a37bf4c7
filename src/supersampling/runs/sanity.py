"""Rows that tell whether an evaluation can be trusted: scores of the targets themselves, and of the raw rendering."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from filelock import FileLock
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf

from supersampling.config import choices
from supersampling.data.module import fingerprint
from supersampling.evaluation.playback import Playback, TargetImages
from supersampling.evaluation.result import Result, evaluate
from supersampling.metrics.selection import Metrics
from supersampling.models.base import Upsampler
from supersampling.models.nearest import Nearest
from supersampling.runs import tags
from supersampling.runs.experiment import FINISHED, Experiment
from supersampling.runs.identity import SCHEME, Identity, digest, with_former_paths
from supersampling.runs.options import described
from supersampling.runs.scores import has_metrics, log_result, means_of


@dataclass(frozen=True, kw_only=True)
class UntrainedMethod:
    """A method that is scored without training. ``content`` distinguishes methods of the same name and kind of run."""

    kind: str
    name: str
    model: Upsampler
    content: str = ""


def score_sanity(cfg: DictConfig, files: list[Path], experiment: Experiment) -> dict[str, dict[str, float]]:
    """Score the reference against itself and the raw input, once per test set and protocol: runs of kind ``sanity``.

    Returns the means over all clips of each, by metric.
    """
    rows: dict[str, Upsampler] = {
        "reference": Playback(cfg.task.scale, TargetImages(files)),
        "raw input": Nearest(cfg.task.scale),
    }
    return {
        name: score_once(cfg, experiment, UntrainedMethod(kind="sanity", name=name, model=model), files)[1]
        for name, model in rows.items()
    }


def score_once(
    cfg: DictConfig, experiment: Experiment, method: UntrainedMethod, files: list[Path]
) -> tuple[Result | None, dict[str, float]]:
    """Score a method and log it, unless that was done.

    Returns the result, None if there was nothing to do, and the means over all clips by metric.
    """
    key = _identity(cfg, method, files)
    folder = Path(cfg.paths.checkpoints) / key.key
    folder.mkdir(parents=True, exist_ok=True)
    with FileLock(folder / "lock"):
        return _score(cfg, experiment, method, key, files)


def _identity(cfg: DictConfig, method: UntrainedMethod, files: list[Path]) -> Identity:
    protocol: Any = OmegaConf.to_container(cfg.protocol, resolve=True)
    data = fingerprint(files, ["target", "color"])
    text = f"{method.kind} {method.name} {method.content} {data} {with_former_paths(protocol)}"
    return Identity(
        digest([method.kind, method.name, method.content, data, described(protocol)]),
        hashlib.sha256(text.encode()).hexdigest()[:16],
    )


def _score(
    cfg: DictConfig, experiment: Experiment, method: UntrainedMethod, key: Identity, files: list[Path]
) -> tuple[Result | None, dict[str, float]]:
    metrics: Metrics = instantiate(cfg.metrics)
    run = experiment.find(key)
    if run is not None and run.info.status == FINISHED and has_metrics(run, metrics):
        return None, means_of(run)
    result = evaluate(method.model, metrics, instantiate(cfg.protocol), files)
    if run is None:
        run_tags = {
            tags.KIND: method.kind,
            tags.IDENTITY: key.key,
            tags.SCHEME: SCHEME,
            tags.METHOD: method.name,
            tags.DATASET: fingerprint(files, ["target"]),
        }
        run_id = experiment.start(f"{method.name} x{cfg.task.scale}", run_tags, None)
    else:
        run_id = run.info.run_id
        experiment.restart(run_id, None)
    parameters = {"model": method.name, "task.scale": cfg.task.scale, **protocol_parameters(cfg)}
    experiment.log_params(run_id, parameters)
    log_result(experiment, run_id, result, {})
    experiment.finish(run_id)
    return result, means_of(experiment.client.get_run(run_id))


def protocol_parameters(cfg: DictConfig) -> Mapping[str, str | int]:
    """Return how a method was scored, as MLflow shows it: quantisation, warm-up, border."""
    return {
        "protocol": choices()["protocol"],
        "protocol.warm_up": cfg.protocol.warm_up,
        "protocol.border": cfg.protocol.border,
    }
