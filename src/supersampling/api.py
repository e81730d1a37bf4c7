"""The public face: compose a method, load weights, run it over a clip, score it, look at data, read finished runs.

``from supersampling import NAME`` gives everything here; docs/python.md shows how. Nothing else is meant to be imported
from outside: all other modules may change.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd
import torch
from hydra.utils import instantiate
from numpy.typing import NDArray
from omegaconf import OmegaConf
from torch import Tensor

import supersampling
from supersampling.commands.resolvers import register
from supersampling.commands.show import sheet
from supersampling.config import composed
from supersampling.data.dataset_file import DatasetFile
from supersampling.errors import UserError
from supersampling.evaluation.result import Result, evaluate
from supersampling.frames import BUFFERS, Frame
from supersampling.models.base import Upsampler
from supersampling.runs import tags
from supersampling.runs.checkpoint import build, load_weights, read_metadata
from supersampling.runs.experiment import FINISHED, Experiment, open_experiment
from supersampling.runs.scores import scores_of
from supersampling.runs.statistics import Estimate as Estimate
from supersampling.runs.statistics import paired_difference as paired_difference
from supersampling.show import drawings, paint
from supersampling.show.checks import WarpCheck, check_warp, read_lighting
from supersampling.show.checks import disoccluded as disoccluded
from supersampling.show.checks import gradient_energy as gradient_energy
from supersampling.show.clip import ClipView
from supersampling.show.paint import Picture
from supersampling.show.scales import Scales, error_scale, in_pixels
from supersampling.show.sheet import display_size

__all__ = supersampling.__all__


def compose_model(name: str = "dlctus", *switches: str, scale: int = 4) -> Upsampler:
    """Return a method with random weights, as ``train.py model=NAME model/SLOT=OPTION`` composes it.

    Args:
        name: a file of ``conf/model``.
        switches: ``reproject=bilinear`` for the option of a slot, ``previous=2`` for a number of the model.
        scale: the upsampling factor on each axis, 2 to 6.

    Raises:
        UserError: no such method, slot, option or number.
    """
    register()
    overrides = [f"model={name}", f"task.scale={scale}"]
    slots = composed("evaluate", overrides).cfg.model
    for switch in switches:
        slot, _, _ = switch.partition("=")
        overrides.append(f"model/{switch}" if OmegaConf.is_dict(slots.get(slot)) else f"model.{switch}")
    model: Upsampler = instantiate(composed("evaluate", overrides).cfg.model)
    return model.eval()


def load_model(checkpoint: str | Path) -> Upsampler:
    """Return the method of a checkpoint file with its weights. No code of the file is run.

    Raises:
        UserError: the file is missing, broken, or holds no description of its model.
    """
    register()
    path = Path(checkpoint)
    metadata = read_metadata(path)
    if metadata is None:
        raise UserError(f"{path} does not describe its model: compose it with compose_model, then load the state dict.")
    model = build(metadata["model"], str(path))
    load_weights(model, path)
    return model.eval()


def render_data(*overrides: str, split: str = "test", buffers: Sequence[str] = tuple(BUFFERS)) -> list[Path]:
    """Render the missing data set files of ``render.py OVERRIDES`` and return the paths of a split.

    Raises:
        UserError: no such scene, buffer or split, or a setting that is not valid.
    """
    register()
    source = instantiate(composed("render", overrides).cfg.data)
    paths: list[Path] = source.files([split], frozenset(buffers))[split]
    return paths


@dataclass(frozen=True)
class Clip:
    """One clip of a data set file, its frames read when they are used."""

    view: ClipView

    @classmethod
    def open(cls, path: str | Path, index: int = 0) -> "Clip":
        """Open clip number ``index`` of a file.

        Raises:
            UserError: the file is missing or broken, or does not have this clip.
        """
        return cls(ClipView(DatasetFile(Path(path)), index))

    def __len__(self) -> int:
        return self.view.frames

    @property
    def scene(self) -> str:
        return str(self.view.file.spec.scene)

    @property
    def scale(self) -> int:
        return int(self.view.file.spec.scale)

    def has(self, name: str, t: int) -> bool:
        """Return whether frame ``t`` has a buffer; high-resolution buffers may exist for the last frames only."""
        return self.view.has(name, t)

    def read(self, name: str, t: int) -> NDArray[Any]:
        """Return a buffer of frame ``t``: float32 ``(C, h, w)``, ``(C, H, W)``, or ``(2,)`` for the jitter."""
        return self.view.read(name, t)

    def frame(self, t: int) -> Frame:
        """Return all input buffers of frame ``t`` as tensors with a batch of 1."""
        names = [name for name in BUFFERS if name in Frame.__dataclass_fields__ and self.has(name, t)]
        return Frame(**{name: torch.from_numpy(self.read(name, t))[None] for name in names})

    def target(self, t: int) -> Tensor:
        """Return the target of frame ``t``, ``(3, H, W)`` in [0, 1]."""
        return torch.from_numpy(self.read("target", t))

    def sheet(self, t: int, width: int = 256, columns: int = 8) -> Picture:
        """Return a picture of every buffer of frame ``t``, each at most ``width`` screen pixels wide."""
        return sheet(self.view, t, display_size(self.view.size, self.scale, width), columns)

    def motion_image(self, t: int) -> Picture:
        """Return the motion vectors of frame ``t`` as hues."""
        return paint.motion(in_pixels(self.view, self.read("motion", t)), self.largest_motion(t))

    def motion_wheel(self, t: int, size: int = 256) -> Picture:
        """Return the legend of `motion_image`."""
        return drawings.wheel((size, size), self.largest_motion(t))

    def largest_motion(self, t: int) -> float:
        """Return the length in low-resolution pixels that has full colour in `motion_image`."""
        return Scales.measure(self.view, t).motion

    def warp_check(self, t: int) -> WarpCheck | None:
        """Compare the target of frame ``t`` with the previous one, as it was and warped; None if a buffer is
        missing."""
        return check_warp(self.view, t)

    def lighting(self, t: int) -> NDArray[Any] | None:
        """Return the demodulated lighting of frame ``t`` (NSRD, equation 4), None if a buffer is missing."""
        return read_lighting(self.view, t)

    def image(self, t: int, mask: NDArray[Any] | None = None) -> Picture:
        """Return the rendered colour of frame ``t``, with the pixels of ``mask`` marked."""
        picture = paint.colour(self.read("color", t))
        return picture if mask is None else paint.masked(picture, mask)


def warp_images(check: WarpCheck) -> dict[str, Picture]:
    """Return the warped previous target and both differences of a warp check, on one scale."""
    difference = partial(paint.difference, full=error_scale(check.still_error), inside=check.inside)
    return {
        "previous target, warped": paint.colour(check.warped),
        "|warped - target|": difference(check.error),
        "|previous - target|": difference(check.still_error),
    }


@torch.inference_mode()
def upsample(model: Upsampler, clip: Clip) -> Iterator[Tensor]:
    """Yield the output for each frame of a clip, ``(3, H, W)`` in [0, 1]; the state is carried along."""
    state: Any = None
    for t in range(len(clip)):
        frame = clip.frame(t)
        output, state = model(frame, state)
        yield model.present(output, frame)[0]


def score(model: Upsampler, files: Sequence[str | Path], metrics: str = "fast", protocol: str = "continuous") -> Result:
    """Score a method on every clip of data set files: tables by frame and by clip, and crops.

    Args:
        metrics: a file of ``conf/metrics``.
        protocol: a file of ``conf/protocol``.

    Raises:
        UserError: a file without a buffer that the method or a metric reads, or of another scale.
    """
    register()
    cfg = composed("evaluate", [f"metrics={metrics}", f"protocol={protocol}"]).cfg
    return evaluate(model, instantiate(cfg.metrics), instantiate(cfg.protocol), [Path(file) for file in files])


def _experiment(tracking_uri: str | None) -> Experiment:
    register()
    cfg = composed("evaluate", []).cfg
    uri = cfg.tracking_uri if tracking_uri is None else tracking_uri
    return open_experiment(uri, cfg.experiment_name, Path(cfg.paths.artifacts))


def finished_runs(tracking_uri: str | None = None) -> pd.DataFrame:
    """Return the finished jobs of a store, the newest first: ``run, name, method, dataset`` and all means and
    parameters.

    Args:
        tracking_uri: of the MLflow store; by default the one that ``train.py`` writes to.
    """
    experiment = _experiment(tracking_uri)
    jobs = f"{tags.equals(tags.KIND, 'job')} and attributes.status = '{FINISHED}'"
    runs = experiment.client.search_runs([experiment.id], jobs, order_by=["attributes.start_time DESC"])
    rows = [
        {
            "run": run.info.run_id,
            "name": run.info.run_name,
            "method": run.data.tags.get(tags.METHOD, ""),
            "dataset": run.data.tags.get(tags.DATASET, ""),
            **{name.removeprefix("test/"): value for name, value in run.data.metrics.items()},
            **run.data.params,
        }
        for run in runs
    ]
    return pd.DataFrame(rows)


def frame_scores(run: str, tracking_uri: str | None = None) -> pd.DataFrame:
    """Return every metric of every frame of a run, with ``scene``, ``clip`` and ``frame``.

    Raises:
        UserError: the run has no scores.
    """
    scores = scores_of(_experiment(tracking_uri), run)
    if scores is None:
        raise UserError(f"Run {run} has no scores: score it with evaluate.py run={run}.")
    return scores.frames
