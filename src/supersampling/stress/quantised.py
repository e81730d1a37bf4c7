"""int8: a method exported, its convolutions quantised on the plain clip, and run outside of PyTorch at the extremes."""

import copy
import math
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import torch

from supersampling.deploy.check import arrays
from supersampling.deploy.describe import write
from supersampling.deploy.graph import export
from supersampling.deploy.quantise import quantise
from supersampling.deploy.runner import Runner
from supersampling.deploy.runtimes import OpenVINO
from supersampling.errors import UserError
from supersampling.models.base import Upsampler
from supersampling.stress.cell import Cell, drift_of, judge
from supersampling.stress.clip import Clip, clip_of, frame_of
from supersampling.stress.extreme import Extreme
from supersampling.stress.precision import INT8, lacks
from supersampling.stress.trial import Distance, frames_of, reference_of

CALIBRATED = 16  # frames, all of the jitter's positions


def runner_of(model: Upsampler, size: tuple[int, int], folder: Path) -> Runner:
    """The quantised method for one size of the low-resolution input, on OpenVINO; files go to ``folder``.

    Raises:
        UserError: it cannot be exported, or has nothing to quantise.
    """
    path = folder / "method.onnx"
    write(path, model, export(copy.deepcopy(model), size))
    plain = clip_of(model.requires, CALIBRATED, *size, model.scale)
    frames = [frame_of(inputs, torch.float32, "cpu") for inputs in frames_of(plain)]
    out = quantise(path, [frames])
    return Runner(out, OpenVINO())


def distance_of(runner: Runner, model: Upsampler, clip: Clip) -> Distance:
    """Of the displayed images from those in float64."""
    found = Distance()
    runner.reset()
    for inputs, output in zip(frames_of(clip), reference_of(model, clip, "cpu")):
        image = torch.from_numpy(runner(arrays(frame_of(inputs, torch.float32, "cpu"))))
        found.add(image, model.present(output, frame_of(inputs, torch.float64, "cpu")))
    return found


def int8_cells(name: str, model: Upsampler, extremes: Sequence[Extreme], size: tuple[int, int]) -> Iterator[Cell]:
    """A cell for each extreme that is a change of the clip; those of the size and the scale would be other graphs."""
    model = copy.deepcopy(model).cpu().eval()
    why, runner = lacks("int8", "cpu"), None
    with tempfile.TemporaryDirectory(prefix="stress-") as folder:
        if not why:
            try:
                runner = runner_of(model, size, Path(folder))
            except UserError as error:
                why = str(error)
        for extreme in extremes:
            if extreme.adjust is not None or not extreme.concerns(model):
                continue
            width, height = extreme.low(size, model.scale)
            scale = extreme.scale or model.scale
            bare = Cell(
                name, extreme.name, "int8", f"{width}x{height}", scale, extreme.frames,
                tolerance=INT8.tolerance, says=extreme.says,
            )  # fmt: skip
            other = (width, height) != size or scale != model.scale
            if runner is None or other:
                yield replace(bare, why=why or "its graph is made for the plain size and scale")
                continue
            clip = extreme.change(clip_of(model.requires, extreme.frames, *size, model.scale))
            found = distance_of(runner, model, clip)
            verdict, broken = judge(found.finite, found.largest, found.mean, "", INT8.limits)
            yield replace(
                bare,
                finite=found.finite,
                largest=found.largest,
                mean=found.mean if found.means else math.nan,
                drift=drift_of(found.means),
                verdict=verdict,
                why=broken,
            )
