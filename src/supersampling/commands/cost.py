"""What the timed backends and precisions change in the quality of trained weights."""

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
from supersampling.profiling.drift import calibration
from supersampling.render.jitter import jitter_sequence
from supersampling.runs.drift import changes
from supersampling.runs.experiment import Experiment
from supersampling.runs.method import method_of
from supersampling.runs.naming import is_learned
from supersampling.runs.subjects import Subject, runs_with_subjects

EXACT = ("eager", "float32")  # what the others are compared with


def cost(cfg: DictConfig, experiment: Experiment, made: Mapping[str, Backend]) -> pd.DataFrame:
    """Roll the runs' methods over the first clip of each of the data's test scenes, under every backend and precision; print what
    each changes, and give the table, without rows where there is nothing to compare.

    Raises:
        UserError: the data are of another scale than a run, or its weights are gone.
    """
    tables = [_of_run(cfg.copy(), run_id, subject, made) for run_id, subject in runs_with_subjects(experiment, cfg.run)]
    found = pd.concat([pd.DataFrame(), *tables], ignore_index=True)
    if len(found):
        _show(found)
    return found


def _of_run(cfg: DictConfig, run_id: str, subject: Subject, made: Mapping[str, Backend]) -> pd.DataFrame:
    cfg.run = run_id
    model = method_of(cfg).model  # cfg.task becomes the run's
    if not is_learned(model):
        return pd.DataFrame()
    files = instantiate(cfg.data).files(("val", "test"), model.requires | {"target", "color"})
    jitters = None
    if "jitter" in model.requires:
        jitters = torch.from_numpy(jitter_sequence(subject.jitter, subject.scale))

    def real(of: Upsampler, size: tuple[int, int]) -> Iterable[Iterable[Frame]]:
        return calibration(files["val"], of, size)

    wanted = [(b.calibrated(real), p) for b in made.values() for p in cfg.precisions if (b.name, p) != EXACT]
    table, whys = costs.measure(model, wanted, files["test"], Continuous(), jitters, cfg.threads)
    for (backend, precision), why in whys.items():
        if (backend, precision) not in {*zip(table.get("backend", ()), table.get("precision", ()))}:
            print(f"{subject.name} {backend} {precision}: {why}")
    return table.assign(method=subject.name, architecture=subject.architecture, run=run_id)


def _show(found: pd.DataFrame) -> None:
    rows = [
        {
            "method": c.method, "backend": c.backend, "precision": c.precision, "PSNR, dB": f"{c.mean.mean:+.4f}",
            "95%": f"{c.mean.low:+.4f} to {c.mean.high:+.4f}", "dB a frame": f"{c.slope.mean:+.5f}",
            "largest": f"{c.largest:.2g}", "frames": c.frames,
        }
        for c in changes(found)
    ]  # fmt: skip
    print("\nAgainst PyTorch in float32, over whole clips")
    print(pd.DataFrame(rows).to_string(index=False))
