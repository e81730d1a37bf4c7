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
from supersampling.commands.rendering import rendered_scenes, renderings
from supersampling.errors import UserError
from supersampling.models.precision import TYPES
from supersampling.profiling.backends import Backend
from supersampling.profiling.described import module_table, parameter_table
from supersampling.profiling.interleave import Outcome, Rounds, measure
from supersampling.profiling.stream import spread
from supersampling.profiling.traffic import Workload, workload
from supersampling.profiling.worker import Case, pin
from supersampling.runs import drift
from supersampling.runs.experiment import Experiment, experiment_of, machine
from supersampling.runs.subjects import Subject, subjects_by_name, subjects_of_run
from supersampling.runs.timing import MODULES, PARAMETERS, RENDERINGS, STAGES, Timing
from supersampling.runs.timing_log import log, log_times_of_jobs

LEAST = {"rounds": 1, "frames": 1, "depth": 0, "threads": 1}
LARGEST = 2**14  # pixels per side
# Columns of both tables that identify a row.
IDENTITY = (
    "method",
    "architecture",
    "scale",
    "width",
    "height",
    "backend",
    "precision",
    "device",
    "threads",
    "machine",
)


def benchmark(cfg: DictConfig) -> None:
    """Time each method at each size under each backend and precision, print a table, and log it to MLflow.

    The row of a combination that does not run has a reason instead of a time.

    Raises:
        UserError: a setting is invalid, or a method, backend, precision or run is unknown.
    """
    check_settings(cfg)
    pin(cfg.threads)
    experiment = experiment_of(cfg)
    subjects = _subjects(cfg, experiment)
    scenes = rendered_scenes(cfg)
    device = settings.device(cfg.device)
    backends: dict[str, Any] = OmegaConf.to_container(cfg.backends, resolve=True)  # type: ignore[assignment]
    timings, stages = time_cases(cfg, subjects, backends, device)
    show(timings, stages)
    tables = {
        STAGES: stages,
        PARAMETERS: parameter_table(subjects),
        MODULES: module_table(subjects, cfg.sizes, cfg.depth),
        RENDERINGS: renderings(cfg, subjects, scenes),
    }
    run_id = log(experiment, cfg, timings, tables)
    try:
        log_times_of_jobs(experiment, timings)
        if cfg.cost:
            changes = cost(cfg, experiment, {name: instantiate(backend) for name, backend in backends.items()})
            if len(changes):
                experiment.client.log_table(run_id, changes, drift.TABLE)
    except BaseException:
        experiment.finish(run_id, "FAILED")
        raise
    experiment.finish(run_id)


def check_settings(cfg: DictConfig) -> None:
    """Raise `UserError` for an invalid setting, with the key, its value and the valid ones."""
    for key, least in LEAST.items():
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
                    f"Invalid size {list(size)} in sizes, no multiple of the scale {scale}: use "
                    f"[{size[0] // scale * scale},{size[1] // scale * scale}] or another scale."
                )
    for key in ("sizes", "precisions", "backends"):
        if not cfg[key]:
            raise UserError(f"Invalid {key}={cfg[key]}, which leaves nothing to time: set at least one.")
    if cfg.cost and not cfg.run:
        raise UserError("cost=true needs trained weights: set run=RUN_ID or run=all.")
    if cfg.run and cfg.methods:
        raise UserError(f"run={cfg.run} and methods={list(cfg.methods)} exclude each other: set one of them.")


def _scales(cfg: DictConfig) -> list[int]:
    return [] if cfg.run else list(cfg.scales)


def _subjects(cfg: DictConfig, experiment: Experiment) -> list[Subject]:
    if cfg.run:
        return subjects_of_run(experiment, cfg.run)
    return subjects_by_name(list(cfg.methods), list(cfg.scales))


def time_cases(
    cfg: DictConfig, subjects: Sequence[Subject], backends: Mapping[str, Any], device: torch.device
) -> tuple[list[Timing], pd.DataFrame]:
    """Return the timing of each combination, and the table of parts of those that have any."""
    instances: dict[str, Backend] = {name: instantiate(config) for name, config in backends.items()}
    cases = [
        Case(
            method=s.name,
            model=s.model,
            scale=s.scale,
            jitter=s.jitter,
            size=tuple(size),
            backend=instances[key].name,
            backend_config=backends[key],
            precision=precision,
            device=device.type,
            threads=cfg.threads,
        )
        for size in cfg.sizes
        for s in subjects
        for key in instances
        for precision in cfg.precisions
    ]
    reasons = [_missing(case, instantiate(case.backend_config), device) for case in cases]
    runnable = [case for case, reason in zip(cases, reasons) if not reason]
    rounds = Rounds(cfg.rounds, cfg.frames, float(cfg.seconds), cfg.depth)
    outcomes = iter(measure(runnable, rounds, report=partial(print, flush=True)))
    workloads: dict[tuple[str, tuple[int, int]], Workload] = {}
    timings, stages = [], []
    for case, reason in zip(cases, reasons):
        outcome = Outcome(case=case, reason=reason) if reason else next(outcomes)
        if (key := (case.architecture, case.low_resolution)) not in workloads:
            workloads[key] = workload(case.model, *case.low_resolution)
        timings.append(timing_of(outcome, workloads[key]))
        stages += [_identity(timings[-1]) | vars(part) for part in outcome.parts]
    return _without_duplicates(timings), pd.DataFrame(stages)


def _without_duplicates(timings: Sequence[Timing]) -> list[Timing]:
    """Leave out the reason of a backend if another backend of its name runs (OpenVINO has an exact and an int8 one)."""
    identity = attrgetter("architecture", "width", "height", "backend", "precision")
    timed_identities = {identity(timing) for timing in timings if timing.runs}
    return [timing for timing in timings if timing.runs or identity(timing) not in timed_identities]


def _missing(case: Case, backend: Backend, device: torch.device) -> str:
    """Return why a case does not run, in one sentence; an empty string if it may."""
    if any(side % case.scale for side in case.size):
        return f"The size is no multiple of its scale, {case.scale}."
    return backend.missing(device, case.precision)


def _identity(timing: Timing) -> dict[str, Any]:
    return {name: getattr(timing, name) for name in IDENTITY}


def timing_of(outcome: Outcome, cost: Workload) -> Timing:
    """Return an outcome as it is logged."""
    case, ceiling = outcome.case, outcome.ceiling
    timed = bool(outcome.seconds) and ceiling is not None
    ms = spread([1e3 * s for s in outcome.seconds] if timed else [math.nan])
    rate = 1e3 / ms.median
    return Timing(
        method=case.method,
        architecture=case.architecture,
        scale=case.scale,
        width=case.size[0],
        height=case.size[1],
        backend=case.backend,
        precision=case.precision,
        device=case.device,
        threads=case.threads,
        machine=machine(),
        ms=ms.median,
        low=ms.low,
        high=ms.high,
        frames=len(outcome.seconds),
        peak_mb=outcome.peak / 1e6,
        parameters=cost.parameters,
        gmac=cost.macs / 1e9,
        gbytes=cost.bytes / 1e9,
        of_product=rate * cost.macs / ceiling.macs if ceiling else math.nan,
        of_copy=rate * cost.bytes / ceiling.bytes if ceiling else math.nan,
        reason=outcome.reason,
    )


def show(timings: Sequence[Timing], stages: pd.DataFrame) -> None:
    """Print both tables, and the reasons of the combinations that do not run."""
    rows = [
        {
            "method": t.method,
            "scale": t.scale,
            "target": f"{t.width}x{t.height}",
            "backend": t.backend,
            "precision": t.precision,
            "ms": f"{t.ms:.2f}",
            "quartiles": f"{t.low:.2f} to {t.high:.2f}",
            "frames": t.frames,
            "peak MB": f"{t.peak_mb:.0f}",
            "parameters": f"{t.parameters:,}",
            "GMAC": f"{t.gmac:.2f}",
            "GB": f"{t.gbytes:.3f}",
            "of product": f"{t.of_product:.0%}",
            "of copy": f"{t.of_copy:.0%}",
        }
        for t in timings
        if t.runs
    ]
    first = timings[0]
    print(f"{first.machine}: {first.device}, {first.threads} threads; milliseconds per frame, batch 1")
    print(pd.DataFrame(rows).to_string(index=False) if rows else "Nothing ran.")
    for t in timings:
        if not t.runs:
            print(f"{t.method} x{t.scale} {t.width}x{t.height} {t.backend} {t.precision}: {t.reason}")
    if stages.empty:
        return
    for _, group in stages.groupby(["method", "scale", "width", "height", "backend", "precision"], sort=False):
        row = group.iloc[0]
        print(f"\n{row.method} x{row.scale} to {row.width}x{row.height}, {row.backend} {row.precision}, part by part")
        columns = group[["part", "kind", "ms", "low", "high", "share"]].copy()
        for column in ("ms", "low", "high"):
            columns[column] = columns[column].map("{:.2f}".format)
        columns["share"] = columns["share"].map("{:.1%}".format)
        print(columns.to_string(index=False))
