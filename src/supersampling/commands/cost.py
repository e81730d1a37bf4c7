"""Effect of the timed backends and precisions on the quality of trained weights."""

from collections.abc import Iterable, Mapping

import pandas as pd
import torch
from hydra.utils import instantiate
from omegaconf import DictConfig

from supersampling.frames import Frame
from supersampling.metrics.prepare import Continuous
from supersampling.models.base import Upsampler
from supersampling.profiling import costs
from supersampling.profiling.backends import Backend
from supersampling.profiling.drift import calibration_clips
from supersampling.render.jitter import jitter_sequence
from supersampling.runs.drift import changes
from supersampling.runs.experiment import Experiment
from supersampling.runs.method import method_of
from supersampling.runs.naming import is_learned
from supersampling.runs.subjects import Subject, runs_with_subjects

EXACT = ("eager", "float32")  # the reference of the comparison


def cost(cfg: DictConfig, experiment: Experiment, backends: Mapping[str, Backend]) -> pd.DataFrame:
    """Roll the runs' methods over the first clip of each test scene of the data, under each backend and precision.

    Print the effect of each, and return the table, which has no rows if there is nothing to compare.

    Raises:
        UserError: the data have another scale than a run, or a run's weights are missing.
    """
    runs = runs_with_subjects(experiment, cfg.run)
    tables = [_run_table(cfg.copy(), run_id, subject, backends) for run_id, subject in runs]
    rows = pd.concat([pd.DataFrame(), *tables], ignore_index=True)
    if len(rows):
        _show(rows)
    return rows


def _run_table(cfg: DictConfig, run_id: str, subject: Subject, backends: Mapping[str, Backend]) -> pd.DataFrame:
    cfg.run = run_id
    model = method_of(cfg).model  # this sets cfg.task to the run's
    if not is_learned(model):
        return pd.DataFrame()
    files = instantiate(cfg.data).files(("val", "test"), model.requires | {"target", "color"})
    jitters = None
    if "jitter" in model.requires:
        jitters = torch.from_numpy(jitter_sequence(subject.jitter, subject.scale))

    def validation_clips(model: Upsampler, size: tuple[int, int]) -> Iterable[Iterable[Frame]]:
        return calibration_clips(files["val"], model, size)

    combinations = [
        (backend.with_calibration(validation_clips), precision)
        for backend in backends.values()
        for precision in cfg.precisions
        if (backend.name, precision) != EXACT
    ]
    table, reasons = costs.measure(model, combinations, files["test"], Continuous(), jitters, cfg.threads)
    measured = {*zip(table.get("backend", ()), table.get("precision", ()))}
    for (backend, precision), reason in reasons.items():
        if (backend, precision) not in measured:
            print(f"{subject.name} {backend} {precision}: {reason}")
    return table.assign(method=subject.name, architecture=subject.architecture, run=run_id)


def _show(table: pd.DataFrame) -> None:
    rows = [
        {
            "method": c.method,
            "backend": c.backend,
            "precision": c.precision,
            "PSNR, dB": f"{c.mean.mean:+.4f}",
            "95%": f"{c.mean.low:+.4f} to {c.mean.high:+.4f}",
            "dB per frame": f"{c.slope.mean:+.5f}",
            "largest": f"{c.largest:.2g}",
            "frames": c.frames,
        }
        for c in changes(table)
    ]
    print("\nDifference from PyTorch in float32, over whole clips")
    print(pd.DataFrame(rows).to_string(index=False))
