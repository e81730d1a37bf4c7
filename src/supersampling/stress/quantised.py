"""int8: an exported method, its convolutions quantised on the plain clip, that runs without PyTorch at the extremes."""

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
from supersampling.stress.cell import Cell, fit_drift, judge
from supersampling.stress.clip import Clip, make_clip, make_frame
from supersampling.stress.extreme import Extreme
from supersampling.stress.precision import INT8, explain_missing
from supersampling.stress.trial import Distance, roll_reference, split_frames

CALIBRATION_FRAMES = 16  # all positions of the jitter


def quantise_model(model: Upsampler, size: tuple[int, int], folder: Path) -> Runner:
    """Return the quantised method for one size of the low-resolution input, on OpenVINO; write its files to ``folder``.

    Raises:
        UserError: the model cannot be exported, or has nothing to quantise.
    """
    path = folder / "method.onnx"
    write(path, model, export(copy.deepcopy(model), size))
    plain = make_clip(model.requires, CALIBRATION_FRAMES, *size, model.scale)
    frames = [make_frame(inputs, torch.float32, "cpu") for inputs in split_frames(plain)]
    return Runner(quantise(path, [frames]), OpenVINO())


def measure_distance(runner: Runner, model: Upsampler, clip: Clip) -> Distance:
    """Return the distance of the displayed images from those in float64."""
    distance = Distance()
    runner.reset()
    for inputs, reference in zip(split_frames(clip), roll_reference(model, clip, "cpu")):
        image = torch.from_numpy(runner(arrays(make_frame(inputs, torch.float32, "cpu"))))
        distance.add(image, model.present(reference, make_frame(inputs, torch.float64, "cpu")))
    return distance


def int8_cells(name: str, model: Upsampler, extremes: Sequence[Extreme], size: tuple[int, int]) -> Iterator[Cell]:
    """Yield one cell per extreme that changes the clip; another size or scale would need another graph: not tried."""
    model = copy.deepcopy(model).cpu().eval()
    missing, runner = explain_missing("int8", "cpu"), None
    with tempfile.TemporaryDirectory(prefix="stress-") as folder:
        if not missing:
            try:
                runner = quantise_model(model, size, Path(folder))
            except UserError as error:
                missing = str(error)
        for extreme in extremes:
            if extreme.adjust is not None or not extreme.concerns(model):
                continue
            low_size, scale = extreme.low_size(size, model.scale), extreme.scale or model.scale
            cell = Cell(
                model=name,
                extreme=extreme.name,
                precision="int8",
                size=f"{low_size[0]}x{low_size[1]}",
                scale=scale,
                frames=extreme.frames,
                tolerance=INT8.tolerance,
                says=extreme.meaning,
            )
            if runner is None or low_size != size or scale != model.scale:
                yield replace(cell, reason=missing or "its graph is made for the plain size and scale")
                continue
            clip = extreme.change(make_clip(model.requires, extreme.frames, *size, model.scale))
            distance = measure_distance(runner, model, clip)
            verdict, reason = judge(distance.finite, distance.largest, distance.mean, "", INT8.limits)
            yield replace(
                cell,
                finite=distance.finite,
                largest=distance.largest,
                mean=distance.mean if distance.means else math.nan,
                drift=fit_drift(distance.means),
                verdict=verdict,
                reason=reason,
            )
