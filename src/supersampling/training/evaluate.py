"""What ``evaluate.py`` does."""

import math
from collections.abc import Mapping
from pathlib import Path

import torch
from hydra.utils import instantiate
from omegaconf import DictConfig

from supersampling.data.module import DataSource, fingerprint
from supersampling.errors import UserError
from supersampling.evaluation.folder import clip_files
from supersampling.evaluation.playback import (
    DisplayImages,
    Playback,
    RadianceImages,
    TargetImages,
    read_recorded_methods,
)
from supersampling.evaluation.result import Result, evaluate
from supersampling.evaluation.score import evaluation_requires
from supersampling.metrics.selection import Metrics
from supersampling.models.base import Upsampler
from supersampling.training.job import experiment_of
from supersampling.training.log import log_result
from supersampling.training.method import method_of
from supersampling.training.sanity import protocol_parameters, score_once, score_sanity
from supersampling.training.tracking import Experiment

RECORDINGS = {"display": (".png", DisplayImages), "radiance": (".exr", RadianceImages)}


def evaluate_command(cfg: DictConfig) -> None:
    """Score the configured method, or frames that another program upscaled, print a table by scene, and log it to MLflow.

    A method's evaluation is a run of kind ``evaluation``; frames of another program become baselines (kind ``job``), which are
    scored once, and so do the reference and the raw input (kind ``sanity``).

    Raises:
        UserError: no such run or checkpoint, or one of another scale or model; images that are missing or of another kind.
    """
    chosen = [key for key in ("checkpoint", "run", "capture", "frames") if cfg[key]]
    if len(chosen) > 1:
        raise UserError(f"{chosen[0]}={cfg[chosen[0]]} and {chosen[1]}={cfg[chosen[1]]} exclude each other: give one.")
    torch.set_num_threads(cfg.threads)
    experiment = experiment_of(cfg)
    if cfg.capture or cfg.frames:
        _score_recordings(experiment, cfg)
        return
    method = method_of(cfg)
    metrics: Metrics = instantiate(cfg.metrics)
    files = _test_files(cfg, method.model, metrics)
    sanity = score_sanity(cfg, files, experiment)
    result = evaluate(method.model, metrics, instantiate(cfg.protocol), files)
    _print(method.name, result, sanity)
    tags = {"ss.kind": "evaluation", "ss.dataset": fingerprint(files, ["target"]), "ss.method": method.name}
    run_id = experiment.start(f"evaluate {method.name}", tags, None)
    experiment.log_params(run_id, {**method.parameters, **protocol_parameters(cfg)})
    log_result(experiment, run_id, result, {})
    experiment.finish(run_id)


def _test_files(cfg: DictConfig, model: Upsampler, metrics: Metrics) -> list[Path]:
    source: DataSource = instantiate(cfg.data)
    return source.files(["test"], evaluation_requires(model, metrics))["test"]


def _score_recordings(experiment: Experiment, cfg: DictConfig) -> None:
    files = _test_files(cfg, Playback(cfg.task.scale, TargetImages([])), instantiate(cfg.metrics))
    sanity = score_sanity(cfg, files, experiment)
    methods = read_recorded_methods(Path(cfg.capture), files) if cfg.capture else _of_folder(cfg, files)
    for name, model in methods.items():
        result, _ = score_once(cfg, experiment, "job", name, model, model.recording.fingerprint, files)
        if result is None:
            print(f"{name}: scored before.")
        else:
            _print(name, result, sanity)


def _of_folder(cfg: DictConfig, files: list[Path]) -> dict[str, Playback]:
    if cfg.space not in RECORDINGS:
        raise UserError(f"space={cfg.space} is none of {', '.join(RECORDINGS)}: say what the frames hold.")
    suffix, images = RECORDINGS[cfg.space]
    folder = Path(cfg.frames)
    recording = images(clip_files(folder, files, suffix))
    return {cfg.name or folder.resolve().name: Playback(cfg.task.scale, recording)}


def _print(name: str, result: Result, sanity: Mapping[str, Mapping[str, float]]) -> None:
    """The means of every scene and of all clips, beside those of the raw input and of the reference."""
    table = result.clips.groupby("scene", sort=False)[result.metrics].mean()
    table.loc["all clips"] = result.clips[result.metrics].mean()
    for other, means in sanity.items():
        table.loc[other] = [means.get(metric, math.nan) for metric in result.metrics]
    print(f"{name}: {len(result.clips)} clips, each of which weighs the same")
    print(table.round(4).T.to_string())
