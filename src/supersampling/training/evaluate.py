"""What ``evaluate.py`` does."""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from hydra.core.hydra_config import HydraConfig
from hydra.utils import instantiate
from omegaconf import DictConfig

from supersampling.data.module import Source, fingerprint
from supersampling.errors import UserError
from supersampling.metrics.suite import Suite
from supersampling.models.base import Upsampler
from supersampling.training.evaluation import evaluation_requires, metrics_of
from supersampling.training.job import Result, evaluate, experiment_of, log_result
from supersampling.training.method import method_of
from supersampling.training.playback import Playback, recorded_methods
from supersampling.training.tracking import Experiment


def evaluate_command(cfg: DictConfig) -> None:
    """Score the configured method, or the images that a capture ships, print a table by scene, and log it to MLflow.

    A method's evaluation is a run of kind ``evaluation``; shipped images become baselines, which are scored once.

    Raises:
        UserError: no such run or checkpoint, or one of another scale or model; images that are missing.
    """
    chosen = [key for key in ("checkpoint", "run", "capture") if cfg[key]]
    if len(chosen) > 1:
        raise UserError(
            f"{chosen[0]}={cfg[chosen[0]]} and {chosen[1]}={cfg[chosen[1]]} exclude each other: give one."
        )
    torch.set_num_threads(cfg.threads)
    experiment = experiment_of(cfg)
    if cfg.capture:
        _score_capture(experiment, cfg)
        return
    method = method_of(cfg)
    metrics: Suite = instantiate(cfg.metrics)
    files = _test_files(cfg, method.model, metrics)
    tags = {"ss.kind": "evaluation", "ss.dataset": fingerprint(files, ["target"]), "ss.method": method.name}
    result = evaluate(method.model, metrics, files)
    _log(experiment, f"evaluate {method.name}", tags, method.parameters, result)


def _test_files(cfg: DictConfig, model: Upsampler, metrics: Suite) -> list[Path]:
    source: Source = instantiate(cfg.data)
    return source.files(["test"], evaluation_requires(model, metrics))["test"]


def _score_capture(experiment: Experiment, cfg: DictConfig) -> None:
    metrics: Suite = instantiate(cfg.metrics)
    files = _test_files(cfg, Playback(cfg.task.scale, []), metrics)
    dataset = fingerprint(files, ["target"])
    for method, model in recorded_methods(Path(cfg.capture), files).items():
        content = f"{method} {model.fingerprint} {dataset} {HydraConfig.get().runtime.choices['metrics']}"
        key = hashlib.sha256(content.encode()).hexdigest()[:16]
        found = experiment.find(key)
        if found is not None and found.info.status == "FINISHED":
            print(f"{method}: scored before.")
            continue
        print(method)
        tags = {"ss.kind": "job", "ss.identity": key, "ss.dataset": dataset, "ss.method": method}
        params = {"model": method, "task.scale": cfg.task.scale}
        _log(experiment, f"{method} x{cfg.task.scale}", tags, params, evaluate(model, metrics, files))


def _log(
    experiment: Experiment, name: str, tags: dict[str, str], params: Mapping[str, Any], result: Result
) -> None:
    """Print a result by scene, and log it as a run."""
    print(result.clips.groupby("scene", sort=False)[metrics_of(result.clips)].mean().round(4).to_string())
    print(
        f"mean over {len(result.clips)} clips: {result.clips['psnr'].mean():.2f} dB, SSIM {result.clips['ssim'].mean():.4f}"
    )
    run_id = experiment.start(name, tags, None)
    experiment.log_params(run_id, params)
    log_result(experiment, run_id, result, {})
    experiment.finish(run_id)
