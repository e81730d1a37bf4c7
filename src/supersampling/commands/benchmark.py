"""The command ``benchmark``: time methods in streaming use, whole and by parts."""

import math
from collections.abc import Mapping, Sequence
from functools import partial
from operator import attrgetter
from typing import Any

import pandas as pd
import torch
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf

from supersampling import settings
from supersampling.commands.cost import cost
from supersampling.errors import UserError
from supersampling.profiling.backends import Backend
from supersampling.profiling.interleave import Outcome, Rounds, measure
from supersampling.profiling.precision import TYPES
from supersampling.profiling.stream import spread
from supersampling.profiling.traffic import Work, work
from supersampling.profiling.worker import Case, pin
from supersampling.runs import drift
from supersampling.runs.experiment import Experiment, experiment_of, machine
from supersampling.runs.subjects import Subject, subjects_by_name, subjects_of_run
from supersampling.runs.timing import Timing
from supersampling.runs.timing_log import log, log_times_of_jobs

_WHOLE = {"rounds": 1, "frames": 1, "depth": 0, "threads": 1}  # the smallest allowed numbers
LARGEST = 2**14  # pixels a side
# What a row of either table is about.
IDENTIFYING = (
    "method", "architecture", "scale", "width", "height", "backend", "precision", "device", "threads", "machine",
)  # fmt: skip


def benchmark(cfg: DictConfig) -> None:
    """Time every method at every size under every backend and precision, print a table, and log it to MLflow.

    A combination that does not run is a row that says why.

    Raises:
        UserError: a setting that is not possible, or an unknown method, backend, precision or run.
    """
    check_settings(cfg)
    pin(cfg.threads)
    experiment = experiment_of(cfg)
    subjects = _subjects(cfg, experiment)
    device = settings.device(cfg.device)
    backends: dict[str, Any] = OmegaConf.to_container(cfg.backends, resolve=True)  # type: ignore[assignment]
    timings, stages = timed(cfg, subjects, backends, device)
    show(timings, stages)
    run_id = log(experiment, cfg, timings, stages)
    try:
        log_times_of_jobs(experiment, timings)
        if cfg.cost:
            made = {name: instantiate(backend) for name, backend in backends.items()}
            changed = cost(cfg, experiment, made)
            if len(changed):
                experiment.client.log_table(run_id, changed, drift.TABLE)
    except BaseException:
        experiment.finish(run_id, "FAILED")
        raise
    experiment.finish(run_id)


def check_settings(cfg: DictConfig) -> None:
    """Refuse what cannot be.

    Raises:
        UserError: names the key, the value and what is possible.
    """
    for key, least in _WHOLE.items():
        settings.whole(cfg, key, least)
    settings.positive(cfg, "seconds")
    for scale in _scales(cfg):
        if not isinstance(scale, int) or scale < 1:
            raise UserError(f"Invalid scale {scale} in scales: use whole numbers of at least 1.")
    for precision in cfg.precisions:
        if precision not in TYPES:
            raise UserError(f"Unknown precision {precision} in precisions: use {', '.join(TYPES)}.")
    for size in cfg.sizes:
        if not settings.is_size(size, LARGEST):
            raise UserError(f"Invalid size {size} in sizes: use [[width,height],...] of the target in pixels.")
        for scale in _scales(cfg):
            if any(side % scale for side in size):
                raise UserError(
                    f"sizes={list(size)} is no multiple of the scale {scale}: use "
                    f"[{size[0] // scale * scale},{size[1] // scale * scale}] or another scale."
                )
    for key in ("sizes", "precisions", "backends"):
        if not cfg[key]:
            raise UserError(f"{key}={cfg[key]} leaves nothing to time: give one or more.")
    if cfg.cost and not cfg.run:
        raise UserError("cost=true needs trained weights: name them with run=RUN_ID, or run=all.")
    if cfg.run and cfg.methods:
        raise UserError(f"run={cfg.run} and methods={list(cfg.methods)} exclude each other: give one.")


def _scales(cfg: DictConfig) -> list[int]:
    return [] if cfg.run else list(cfg.scales)


def _subjects(cfg: DictConfig, experiment: Experiment) -> list[Subject]:
    if cfg.run:
        return subjects_of_run(experiment, cfg.run)
    return subjects_by_name(list(cfg.methods), list(cfg.scales))


def timed(
    cfg: DictConfig, subjects: Sequence[Subject], backends: Mapping[str, Any], device: torch.device
) -> tuple[list[Timing], pd.DataFrame]:
    """Every combination's timing, and the table of parts of those that have any."""
    made: dict[str, Backend] = {name: instantiate(config) for name, config in backends.items()}
    cases = [
        Case(s.name, s.model, s.scale, s.jitter, tuple(size), made[key].name, backends[key], precision, device.type, cfg.threads)
        for size in cfg.sizes for s in subjects for key in made for precision in cfg.precisions
    ]  # fmt: skip
    whys = [_why(case, instantiate(case.backend), device) for case in cases]
    able = [case for case, why in zip(cases, whys) if not why]
    rounds = Rounds(cfg.rounds, cfg.frames, float(cfg.seconds), cfg.depth)
    measured = iter(measure(able, rounds, say=partial(print, flush=True)))
    works: dict[tuple[str, tuple[int, int]], Work] = {}
    timings, stages = [], []
    for case, why in zip(cases, whys):
        outcome = Outcome(case, why=why) if why else next(measured)
        if (key := (case.architecture, case.low)) not in works:
            works[key] = work(case.model, *case.low)
        timings.append(timing_of(outcome, works[key]))
        stages += [_identified(timings[-1]) | vars(part) for part in outcome.parts]
    return _once(timings), pd.DataFrame(stages)


def _once(timings: Sequence[Timing]) -> list[Timing]:
    """Without the reasons of a backend where another one of its name does run (OpenVINO's, exact and quantised)."""
    identity = attrgetter("architecture", "width", "height", "backend", "precision")
    ran = {identity(timing) for timing in timings if timing.runs}
    return [timing for timing in timings if timing.runs or identity(timing) not in ran]


def _why(case: Case, backend: Backend, device: torch.device) -> str:
    if any(side % case.scale for side in case.size):
        return f"The size is no multiple of its scale, {case.scale}."
    return backend.missing(device, case.precision)


def _identified(timing: Timing) -> dict[str, Any]:
    return {name: getattr(timing, name) for name in IDENTIFYING}


def timing_of(outcome: Outcome, cost: Work) -> Timing:
    """An outcome as it is logged."""
    case, ran = outcome.case, bool(outcome.seconds) and outcome.ceiling is not None
    ms = spread([1e3 * s for s in outcome.seconds] if ran else [math.nan])
    rate = 1e3 / ms.median
    return Timing(
        method=case.method, architecture=case.architecture, scale=case.scale, width=case.size[0], height=case.size[1],
        backend=case.name, precision=case.precision, device=case.device, threads=case.threads, machine=machine(),
        ms=ms.median, low=ms.low, high=ms.high, frames=len(outcome.seconds), peak_mb=outcome.peak / 1e6,
        parameters=cost.parameters, gmac=cost.macs / 1e9, gbytes=cost.bytes / 1e9,
        of_product=rate * cost.macs / outcome.ceiling.macs if outcome.ceiling else math.nan,
        of_copy=rate * cost.bytes / outcome.ceiling.bytes if outcome.ceiling else math.nan,
        why=outcome.why,
    )  # fmt: skip


def show(timings: Sequence[Timing], stages: pd.DataFrame) -> None:
    """Print both tables, and why what is missing is."""
    rows = [
        {
            "method": t.method, "scale": t.scale, "target": f"{t.width}x{t.height}", "backend": t.backend,
            "precision": t.precision, "ms": f"{t.ms:.2f}", "quartiles": f"{t.low:.2f} to {t.high:.2f}", "frames": t.frames,
            "peak MB": f"{t.peak_mb:.0f}", "parameters": f"{t.parameters:,}", "GMAC": f"{t.gmac:.2f}",
            "GB": f"{t.gbytes:.3f}", "of product": f"{t.of_product:.0%}", "of copy": f"{t.of_copy:.0%}",
        }
        for t in timings if t.runs
    ]  # fmt: skip
    first = timings[0]
    print(f"{first.machine}: {first.device}, {first.threads} threads; milliseconds a frame, batch 1")
    print(pd.DataFrame(rows).to_string(index=False) if rows else "Nothing ran.")
    for t in timings:
        if not t.runs:
            print(f"{t.method} x{t.scale} {t.width}x{t.height} {t.backend} {t.precision}: {t.why}")
    if stages.empty:
        return
    for _, of_one in stages.groupby(["method", "scale", "width", "height", "backend", "precision"], sort=False):
        one = of_one.iloc[0]
        print(f"\n{one.method} x{one.scale} to {one.width}x{one.height}, {one.backend} {one.precision}, part by part")
        shown = of_one[["part", "kind", "ms", "low", "high", "share"]].copy()
        for column in ("ms", "low", "high"):
            shown[column] = shown[column].map("{:.2f}".format)
        shown["share"] = shown["share"].map("{:.1%}".format)
        print(shown.to_string(index=False))
