"""The command ``export``: export a method as ONNX graphs and compare them with PyTorch."""

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import torch
from hydra.utils import instantiate
from omegaconf import DictConfig
from torch import Tensor

from supersampling import settings
from supersampling.data.module import DataSource
from supersampling.deploy import describe, graph
from supersampling.deploy.check import Difference, compare, compare_other_sizes, random_frames, recorded_frames
from supersampling.deploy.graph import MULTIPLES, Graphs
from supersampling.deploy.runner import Runner, sidecar
from supersampling.deploy.runtimes import OnnxRuntime, OpenVINO
from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.models.forms import Precomputable
from supersampling.render.jitter import jitter_sequence
from supersampling.runs.method import LoadedMethod, method_of

CHECKED_SIZE = 60, 34  # of random frames if the graph takes all sizes, rounded down to a possible one
KERNELS, FRAMES = ("precomputed", "mlp"), ("random", "data")


def export(cfg: DictConfig) -> None:
    """Export the method that ``checkpoint``, ``run`` or ``model`` names, and compare it with PyTorch in each runtime.

    Raises:
        UserError: a setting is invalid, the method cannot be exported, or a runtime differs from PyTorch by more than
            ``tolerance``; nothing is written then.
    """
    _check_settings(cfg)
    settings.exclusive(cfg, "checkpoint", "run")
    torch.set_num_threads(cfg.threads)
    out = Path(cfg.out)
    method = method_of(cfg)
    model, jitter, jitters = _deployment_form(method.model, cfg)
    graphs = graph.export(model, tuple(cfg.size) if cfg.size else None)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=out.parent, prefix=".export") as folder:
            path = Path(folder) / out.name
            files = describe.write(path, model, graphs, jitter, _origin(method))
            _check(cfg, method.model, graphs, path, jitters)
            for file in files:
                os.replace(file, out.parent / file.name)
    except PermissionError as error:
        raise UserError(f"No permission to write out={out}: use another file.") from error
    print(
        f"{out}: {method.name}, {_sizes(graphs)}, {len(graphs.state)} state tensors; see {sidecar(out).name} for use."
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


def _deployment_form(model: Upsampler, cfg: DictConfig) -> tuple[Upsampler, dict[str, Any], Tensor | None]:
    """Return the model to export, its jitter for the description, and the sequence ``(N, 2)`` if it reads a jitter."""
    if "jitter" not in model.requires:
        return model, {"pattern": None}, None
    sequence = torch.from_numpy(jitter_sequence(cfg.task.jitter, model.scale))
    description: dict[str, Any] = {"pattern": cfg.task.jitter, "sequence": sequence.tolist()}
    if isinstance(model, Precomputable) and cfg.kernels == "precomputed":
        description["kernels"] = "precomputed for this sequence: a jitter takes those of the nearest entry"
        return model.with_precomputed_kernels(sequence), description, sequence
    return model, description, sequence


def _origin(method: LoadedMethod) -> dict[str, Any]:
    known = {key: value for key, value in method.origin.items() if value}
    return {"method": method.name, **known, "model": method.config}


def _check(cfg: DictConfig, model: Upsampler, graphs: Graphs, path: Path, jitters: Tensor | None) -> None:
    """Print each runtime's difference from ``model``, the complete one; raise `UserError` above the tolerance."""
    runtimes = (OnnxRuntime(threads=cfg.threads), OpenVINO(threads=cfg.threads))
    runners = {runtime.name: Runner(path, runtime) for runtime in runtimes}
    differences = compare(model, runners, _frames(cfg, model, graphs, jitters))
    for name, difference in differences.items():
        print(f"{name}: {_summary(difference)} over {cfg.check} frames")
    name, worst = max(differences.items(), key=lambda item: item[1].largest)
    if worst.largest > cfg.tolerance:
        raise UserError(
            f"{name} differs from PyTorch by {worst.largest:.3g} at frame {worst.frame}, more than "
            f"tolerance={cfg.tolerance}, and nothing was written: set a larger tolerance if this is rounding, but do "
            "not use a graph that drifts."
        )
    if graphs.size is not None:
        return
    for (width, height), difference in compare_other_sizes(model, runners, graphs.multiple, jitters).items():
        if difference.largest > cfg.tolerance:
            raise UserError(
                f"The graph differs by {difference.largest:.3g} at {width}x{height}, so one graph for all sizes is not "
                "possible here: give size=[width,height] of the low-resolution input."
            )


def _summary(difference: Difference) -> str:
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
