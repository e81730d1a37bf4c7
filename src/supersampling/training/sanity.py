"""Rows that say whether an evaluation can be trusted: what it gives to the targets themselves, and to the raw rendering."""

import hashlib
from pathlib import Path

from filelock import FileLock
from hydra.core.hydra_config import HydraConfig
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf

from supersampling.data.module import fingerprint
from supersampling.evaluation.playback import Playback, TargetImages
from supersampling.evaluation.result import Result, evaluate
from supersampling.metrics.selection import Metrics
from supersampling.models.base import Upsampler
from supersampling.models.nearest import Nearest
from supersampling.training.log import has_metrics, log_result, means_of
from supersampling.training.tracking import Experiment


def score_sanity(cfg: DictConfig, files: list[Path], experiment: Experiment) -> dict[str, dict[str, float]]:
    """Score the reference against itself and the raw input, once for a test set and protocol: runs of kind ``sanity``.

    The means over all clips, by metric, of either.
    """
    methods: dict[str, Upsampler] = {
        "reference": Playback(cfg.task.scale, TargetImages(files)),
        "raw input": Nearest(cfg.task.scale),
    }
    return {name: score_once(cfg, experiment, "sanity", name, model, "", files)[1] for name, model in methods.items()}


def score_once(
    cfg: DictConfig,
    experiment: Experiment,
    kind: str,
    name: str,
    model: Upsampler,
    content: str,
    files: list[Path],
) -> tuple[Result | None, dict[str, float]]:
    """Score a method that is not trained and log it as a run of this ``kind``, unless that was done; ``content`` tells methods of
    one name apart.

    The result, None if there was nothing to do, and the means over all clips, by metric.
    """
    said = OmegaConf.to_container(cfg.protocol, resolve=True)
    data = fingerprint(files, ["target", "color"])
    key = hashlib.sha256(f"{kind} {name} {content} {data} {said}".encode()).hexdigest()[:16]
    folder = Path(cfg.paths.checkpoints) / key
    folder.mkdir(parents=True, exist_ok=True)
    with FileLock(folder / "lock"):
        return _score_once(cfg, experiment, {"ss.kind": kind, "ss.identity": key, "ss.method": name}, model, files)


def _score_once(
    cfg: DictConfig, experiment: Experiment, tags: dict[str, str], model: Upsampler, files: list[Path]
) -> tuple[Result | None, dict[str, float]]:
    metrics: Metrics = instantiate(cfg.metrics)
    found = experiment.find(tags["ss.identity"])
    if found is not None and found.info.status == "FINISHED" and has_metrics(found, metrics):
        return None, means_of(found)
    result = evaluate(model, metrics, instantiate(cfg.protocol), files)
    name = tags["ss.method"]
    if found is None:
        tags = {**tags, "ss.dataset": fingerprint(files, ["target"])}
        run_id = experiment.start(f"{name} x{cfg.task.scale}", tags, None)
    else:
        run_id = found.info.run_id
        experiment.restart(run_id, None)
    experiment.log_params(run_id, {"model": name, "task.scale": cfg.task.scale, **protocol_parameters(cfg)})
    log_result(experiment, run_id, result, {})
    experiment.finish(run_id)
    return result, means_of(experiment.client.get_run(run_id))


def protocol_parameters(cfg: DictConfig) -> dict[str, str | int]:
    """How it was scored, as MLflow shows it: quantisation, warm-up, border."""
    return {
        "protocol": HydraConfig.get().runtime.choices["protocol"],
        "protocol.warm_up": cfg.protocol.warm_up,
        "protocol.border": cfg.protocol.border,
    }
