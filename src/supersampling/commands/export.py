"""The command ``export``: a method as ONNX graphs, checked against PyTorch."""

import json
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import torch
from hydra.utils import instantiate
from omegaconf import DictConfig
from torch import Tensor

from supersampling import settings
from supersampling.data.module import DataSource
from supersampling.deploy import graph
from supersampling.deploy.check import Difference, at_other_sizes, compare, random_frames, recorded_frames
from supersampling.deploy.describe import describe
from supersampling.deploy.graph import MULTIPLES, Graphs
from supersampling.deploy.runner import Runner, sidecar
from supersampling.deploy.runtimes import OnnxRuntime, OpenVINO
from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.render.jitter import jitter_sequence
from supersampling.runs.method import Method, method_of

CHECKED_SIZE = 60, 34  # of random frames where any size goes, rounded down to what does
KERNELS, FRAMES = ("precomputed", "mlp"), ("random", "data")


@runtime_checkable
class Precomputes(Protocol):
    """A method whose kernels can be made beforehand for a jitter sequence."""

    def with_precomputed_kernels(self, jitters: Tensor) -> Upsampler: ...


def export(cfg: DictConfig) -> None:
    """Export what ``checkpoint``, ``run`` or ``model`` name, compare it with PyTorch in each runtime, then put it in place.

    Raises:
        UserError: a setting that is not possible, a method that cannot be exported, or a runtime that is further from
            PyTorch than ``tolerance``; nothing is written then.
    """
    _check_settings(cfg)
    settings.exclusive(cfg, "checkpoint", "run")
    torch.set_num_threads(cfg.threads)
    out = Path(cfg.out)
    method = method_of(cfg)
    model, jitter, jitters = _deployed(method.model, cfg)
    graphs = graph.export(model, tuple(cfg.size) if cfg.size else None)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=out.parent, prefix=".export") as folder:
            written = _write(Path(folder) / out.name, model, graphs, jitter, method)
            _check(cfg, method.model, graphs, Path(folder) / out.name, jitters)
            for path in written:
                os.replace(path, out.parent / path.name)
    except PermissionError as error:
        raise UserError(f"{out} cannot be written: choose another out=FILE.onnx.") from error
    print(
        f"{out}: {method.name}, {_sizes(graphs)}, {len(graphs.state)} state tensors; {sidecar(out).name} says how to use it."
    )


def _check_settings(cfg: DictConfig) -> None:
    if cfg.size:
        settings.size(cfg.size, "size")
    if Path(cfg.out).suffix != ".onnx":
        raise UserError(f"Invalid out={cfg.out}: use a name that ends with .onnx.")
    settings.choice(cfg, "kernels", KERNELS)
    settings.choice(cfg, "frames", FRAMES)
    settings.whole(cfg, "check")
    settings.number(cfg, "tolerance", 0.0, 1.0)


def _deployed(model: Upsampler, cfg: DictConfig) -> tuple[Upsampler, dict[str, Any], Tensor | None]:
    """The model as it is exported, what the description says of jitter, and the sequence ``(N, 2)``, if one is read."""
    if "jitter" not in model.requires:
        return model, {"pattern": None}, None
    said: dict[str, Any] = {"pattern": cfg.task.jitter}
    sequence = torch.from_numpy(jitter_sequence(cfg.task.jitter, model.scale))
    said["sequence"] = sequence.tolist()
    if isinstance(model, Precomputes) and cfg.kernels == "precomputed":
        said["kernels"] = "made beforehand for this sequence: a jitter takes the nearest entry's"
        return model.with_precomputed_kernels(sequence), said, sequence
    return model, said, sequence


def _write(path: Path, model: Upsampler, graphs: Graphs, jitter: dict[str, Any], method: Method) -> list[Path]:
    first = path.with_suffix(".first.onnx") if graphs.state else path
    graphs.other.save(str(path))
    if graphs.state:
        graphs.first.save(str(first))
    about = {
        "method": method.name,
        **{key: value for key, value in method.origin.items() if value},
        "model": method.config,
    }
    description = describe(model, graphs, (first.name, path.name), jitter, about)
    sidecar(path).write_text(json.dumps(description, indent=2) + "\n")
    return sorted({path, first, sidecar(path)})


def _check(cfg: DictConfig, model: Upsampler, graphs: Graphs, path: Path, jitters: Tensor | None) -> None:
    """Print each runtime's difference from ``model``, the one with all its parts, and refuse one above the tolerance."""
    runtimes = (OnnxRuntime(threads=cfg.threads), OpenVINO(threads=cfg.threads))
    runners = {runtime.name: Runner(path, runtime) for runtime in runtimes}
    found = compare(model, runners, _frames(cfg, model, graphs, jitters))
    for name, difference in found.items():
        print(f"{name}: {_said(difference)} over {cfg.check} frames")
    name, worst = max(found.items(), key=lambda item: item[1].largest)
    if worst.largest > cfg.tolerance:
        raise UserError(
            f"{name} differs from PyTorch by {worst.largest:.3g} at frame {worst.frame}, more than tolerance={cfg.tolerance}: "
            "nothing was written. A graph that drifts is no use; if this is rounding, set a larger tolerance."
        )
    if graphs.size is not None:
        return
    for (width, height), difference in at_other_sizes(model, runners, graphs.multiple, jitters).items():
        if difference.largest > cfg.tolerance:
            raise UserError(
                f"The graph is off by {difference.largest:.3g} at {width}x{height}, so one for all sizes is not possible here: "
                "give size=[width,height] of the low-resolution input."
            )


def _said(difference: Difference) -> str:
    return (
        f"at most {difference.largest:.2e} from PyTorch (frame {difference.frame}), {difference.mean:.2e} on average,"
    )


def _frames(cfg: DictConfig, model: Upsampler, graphs: Graphs, jitters: Tensor | None) -> Iterator[Frame]:
    if cfg.frames == "data":
        source: DataSource = instantiate(cfg.data)
        files = source.files(["test"], model.requires)["test"]
        return recorded_frames(files[0], model.requires, graphs.size, graphs.multiple, cfg.check)
    width, height = (n // MULTIPLES[-1] * MULTIPLES[-1] for n in CHECKED_SIZE)
    if graphs.multiple == 1:  # odd sizes are where a graph goes wrong first
        width, height = width - 3, height - 1
    return random_frames(model, graphs.size or (width, height), cfg.check, jitters)


def _sizes(graphs: Graphs) -> str:
    if graphs.size is not None:
        return f"input {graphs.size[0]}x{graphs.size[1]}"
    return "any input size" if graphs.multiple == 1 else f"any input size in multiples of {graphs.multiple}"
