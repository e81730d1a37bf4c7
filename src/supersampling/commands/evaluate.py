"""The command ``evaluate``: score a method, or frames that another program upscaled."""

import math
from collections.abc import Mapping
from pathlib import Path

import torch
from hydra.utils import instantiate
from omegaconf import DictConfig

from supersampling import settings
from supersampling.data.module import DataSource, fingerprint
from supersampling.evaluation import result
from supersampling.evaluation.folder import clip_files
from supersampling.evaluation.playback import (
    DisplayImages,
    Playback,
    RadianceImages,
    TargetImages,
    read_recorded_methods,
)
from supersampling.evaluation.result import Result
from supersampling.evaluation.score import evaluation_requires
from supersampling.metrics.selection import Metrics
from supersampling.models.base import Upsampler
from supersampling.runs import tags
from supersampling.runs.experiment import Experiment, experiment_of
from supersampling.runs.method import method_of
from supersampling.runs.sanity import UntrainedMethod, score_once, score_sanity
from supersampling.runs.scored import scored_parameters
from supersampling.runs.scores import log_result

RECORDINGS = {"display": (".png", DisplayImages), "radiance": (".exr", RadianceImages)}


def evaluate(cfg: DictConfig) -> None:
    """Score the configured method, or frames that another program upscaled, print a table by scene, log it.

    A method's evaluation is a run of kind ``evaluation``; parts of its model that the command line names replace those
    that it was trained with. Frames of another program become baselines (kind ``job``), which are scored once, as are
    the reference and the raw input (kind ``sanity``).

    Raises:
        UserError: no such run or checkpoint, or one of another scale or model; weights that do not fit; images that are
            missing or of another kind.
    """
    settings.exclusive(cfg, "checkpoint", "run", "capture", "frames")
    torch.set_num_threads(cfg.threads)
    experiment = experiment_of(cfg)
    if cfg.capture or cfg.frames:
        _score_recordings(experiment, cfg)
        return
    method = method_of(cfg, exchange=True)
    metrics: Metrics = instantiate(cfg.metrics)
    files = _test_files(cfg, method.model, metrics)
    sanity = score_sanity(cfg, files, experiment)
    scores = result.evaluate(method.model, metrics, instantiate(cfg.protocol), files)
    _print_table(method.name, scores, sanity)
    run_tags = {tags.KIND: "evaluation", tags.DATASET: fingerprint(files, ["target"]), tags.METHOD: method.name}
    run_id = experiment.start(f"evaluate {method.name}", run_tags, None)
    experiment.log_params(run_id, scored_parameters(cfg, method, files))
    log_result(experiment, run_id, scores, {})
    experiment.finish(run_id)


def _test_files(cfg: DictConfig, model: Upsampler, metrics: Metrics) -> list[Path]:
    source: DataSource = instantiate(cfg.data)
    return source.files(["test"], evaluation_requires(model, metrics))["test"]


def _score_recordings(experiment: Experiment, cfg: DictConfig) -> None:
    files = _test_files(cfg, Playback(cfg.task.scale, TargetImages([])), instantiate(cfg.metrics))
    sanity = score_sanity(cfg, files, experiment)
    methods = read_recorded_methods(Path(cfg.capture), files) if cfg.capture else _methods_of_folder(cfg, files)
    for name, model in methods.items():
        method = UntrainedMethod(kind="job", name=name, model=model, content=model.recording.fingerprint)
        scores, _ = score_once(cfg, experiment, method, files)
        if scores is None:
            print(f"{name}: scored before.")
        else:
            _print_table(name, scores, sanity)


def _methods_of_folder(cfg: DictConfig, files: list[Path]) -> dict[str, Playback]:
    suffix, images = RECORDINGS[settings.choice(cfg, "space", RECORDINGS)]
    folder = Path(cfg.frames)
    recording = images(clip_files(folder, files, suffix))
    return {cfg.name or folder.resolve().name: Playback(cfg.task.scale, recording)}


def _print_table(name: str, scores: Result, sanity: Mapping[str, Mapping[str, float]]) -> None:
    """Print the means of every scene and of all clips, beside those of the raw input and of the reference."""
    table = scores.clips.groupby("scene", sort=False)[scores.metrics].mean()
    table.loc["all clips"] = scores.clips[scores.metrics].mean()
    for row, means in sanity.items():
        table.loc[row] = [means.get(metric, math.nan) for metric in scores.metrics]
    print(f"{name}: {len(scores.clips)} clips of equal weight")
    print(table.round(4).T.to_string())
