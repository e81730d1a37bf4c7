"""DLCTUS on every backend against the thesis's listing typed as it stands (``listing.py``), in turn, in one process.

    python scripts/timing/inference.py                                      1920x1080 at 4x4, two threads
    python scripts/timing/inference.py --backends native eager --repeats 31 --scale 2
    python scripts/timing/inference.py --threads 1 --clock cpu              on a machine that others use, too

The backends are PyTorch's operations (``eager`` as trained, ``deployed`` with the thesis's two rewrites, ``channels_last`` and
``compile`` the latter in that layout and compiled), the exported graph under ``onnxruntime`` and ``openvino``, and ``native``,
C++ passes. All have the same weights and roll over the same clip, each with a state of its own. A ratio is the median over rounds
of listing over backend, with its quartiles; ``apart`` is the largest difference of an image from the listing's over the clip,
``error`` that from the listing in float64: the first line's is the listing's own rounding.
"""

import argparse
import copy
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from listing import MasterNet
from torch import Tensor

from supersampling.deploy.check import arrays
from supersampling.deploy.describe import write
from supersampling.deploy.graph import export
from supersampling.deploy.runner import Runner
from supersampling.deploy.runtimes import OnnxRuntime, OpenVINO, Runtime
from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.models.dlctus import DLCTUS
from supersampling.models.dlctus_native import DLCTUSNative
from supersampling.stages.accumulate import AccumulationBuffer
from supersampling.stages.confine import StraightThrough
from supersampling.stages.dilate import NoDilation
from supersampling.stages.initialise import Balanced
from supersampling.stages.pad import JitterAligned
from supersampling.stages.reproject import Bicubic9

BACKENDS = "native", "eager", "deployed", "channels_last", "compile", "onnxruntime", "openvino"
CLOCKS = {"wall": time.perf_counter, "cpu": time.process_time}

Step = Callable[[int, Any], tuple[Tensor, Any]]  # (frame, state) -> (image, state)


def dlctus(scale: int) -> DLCTUS:
    """Seeded weights. The balanced start, so that most outputs lie inside of the clamp, as a trained network's do."""
    torch.manual_seed(0)
    return DLCTUS(
        scale,
        Bicubic9(),
        NoDilation(),
        JitterAligned(),
        AccumulationBuffer(),
        StraightThrough(),
        Balanced(),
    ).eval()


def clip(frames: int, h: int, w: int) -> list[Frame]:
    """A texture that moves, in places out of the image, with 5% of noise; nothing stands still."""
    generator = torch.Generator().manual_seed(0)
    y, x = torch.meshgrid(torch.linspace(0, 1, h), torch.linspace(0, 1, w), indexing="ij")
    made = []
    for t in range(frames):
        motion = torch.stack((0.004 * torch.sin(6 * x + t) + 0.006, 0.005 * torch.cos(5 * y - t) + 0.002))[None]
        waves = [torch.sin(k * 40 * (x + 0.006 * t) + 31 * y * (k + 1) + k) for k in range(3)]
        noise = 0.05 * torch.rand(1, 3, h, w, generator=generator)
        color = 0.475 + 0.45 * torch.stack(waves)[None] + noise
        depth = torch.rand(1, 1, h, w, generator=generator)
        made.append(Frame(color, None, depth, motion, None, torch.rand(1, 2, generator=generator) - 0.5))
    return made


def load(model: DLCTUS) -> MasterNet:
    net = MasterNet(model.scale)
    named = {"down.0": model.network.down}
    for k, block in enumerate(model.network.blocks, 1):
        named |= {f"cnn{k}.{place}": block[place] for place in (0, 2)}  # type: ignore[index]
    weights = {f"{name}.{key}": value for name, conv in named.items() for key, value in conv.state_dict().items()}
    net.load_state_dict(weights | {"zero_up.w": net.zero_up.w})
    return net.eval()


def inputs_of_listing(frame: Frame, dtype: torch.dtype) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Positions in place of motion, rounded once, and jitter in [0, 1): made beforehand, not timed."""
    assert frame.color is not None
    assert frame.depth is not None
    assert frame.motion is not None
    assert frame.jitter is not None
    h, w = frame.color.shape[-2:]
    x, y = ((2.0 * torch.arange(n, dtype=torch.float64) + 1.0) / n - 1.0 for n in (w, h))
    centres = torch.stack((x.expand(h, w), y[:, None].expand(h, w)), dim=-1)
    positions = centres + 2.0 * frame.motion.permute(0, 2, 3, 1).double()
    return (
        frame.color.to(dtype), frame.depth.to(dtype), positions.to(dtype), frame.jitter.to(dtype) + 0.5
    )  # fmt: skip


def listing(model: DLCTUS, frames: Sequence[Frame], dtype: torch.dtype = torch.float32) -> Step:
    net, given = load(model).to(dtype), [inputs_of_listing(frame, dtype) for frame in frames]
    if dtype == torch.float32:
        return lambda t, state: net(*given[t], state)

    def step(t: int, state: Any) -> tuple[Tensor, Any]:
        torch.set_default_dtype(dtype)  # the listing names none
        try:
            return net(*given[t], state)  # type: ignore[no-any-return]
        finally:
            torch.set_default_dtype(torch.float32)

    return step


def backend(name: str, model: DLCTUS, frames: Sequence[Frame], threads: int, folder: Path) -> Step:
    """Raises `UserError` where it does not run."""
    ours: Upsampler[Tensor] = model
    if name == "native":
        ours = DLCTUSNative(model)
    elif name != "eager":
        ours = model.for_inference()
    if name in ("onnxruntime", "openvino"):
        return exported(
            ours, frames, (OnnxRuntime if name == "onnxruntime" else OpenVINO)(threads=threads), folder / name
        )
    if name == "channels_last":
        ours = ours.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    run: Any = torch.compile(ours) if name == "compile" else ours
    return lambda t, state: run(frames[t], state)


def exported(model: Upsampler, frames: Sequence[Frame], runtime: Runtime, folder: Path) -> Step:
    assert frames[0].color is not None
    h, w = frames[0].color.shape[-2:]
    with torch.inference_mode(False), torch.no_grad():
        graphs = export(copy.deepcopy(model), (w, h))
    folder.mkdir()
    write(folder / "next.onnx", model, graphs)
    runner, given = Runner(folder / "next.onnx", runtime), [arrays(frame) for frame in frames]
    return lambda t, state: (torch.from_numpy(runner(given[t])), None)  # the runner keeps the state


def differences(steps: dict[str, Step], exact: Step, frames: int) -> dict[str, tuple[float, float, Any]]:
    """Of each: from the listing, from the exact one, and the state after the clip."""
    states: dict[str, Any] = dict.fromkeys(steps)
    apart, error = dict.fromkeys(steps, 0.0), dict.fromkeys(steps, 0.0)
    state = None
    for t in range(frames):
        true, state = exact(t, state)
        first = None
        for name, step in steps.items():
            image, states[name] = step(t, states[name])
            first = image.clone() if first is None else first
            apart[name] = max(apart[name], float((image - first).abs().max()))
            error[name] = max(error[name], float((image - true).abs().max()))
    return {name: (apart[name], error[name], states[name]) for name in steps}


def report(asked: argparse.Namespace, folder: Path) -> None:
    width, height = asked.size
    frames = clip(asked.frames, height // asked.scale, width // asked.scale)
    model, clock = dlctus(asked.scale), CLOCKS[asked.clock]
    steps = {"listing": listing(model, frames)}
    for name in asked.backends:
        try:
            steps[name] = backend(name, model, frames, asked.threads, folder)
        except (UserError, ImportError) as error:
            steps.pop(name, None)
            print(f"{name} does not run: {error}")
    found = differences(steps, listing(model, frames, torch.float64), asked.frames)
    seconds: dict[str, list[float]] = {name: [] for name in steps}
    for k in range(asked.repeats):
        for name, step in steps.items():
            start = clock()
            step(k % asked.frames, found[name][2])
            seconds[name].append(clock() - start)
    print(
        f"{asked.scale}x{asked.scale} to {width}x{height}, {asked.threads} threads, {asked.repeats} rounds, {asked.clock} clock"
    )
    print(f"{'':16s}{'median ms':>10s}{'fastest':>9s}{'times as fast':>26s}{'apart':>10s}{'error':>10s}")
    for name, times in seconds.items():
        low, middle, high = np.quantile(np.divide(seconds["listing"], times), (0.25, 0.5, 0.75))
        print(f"{name:16s}{1e3 * np.median(times):10.1f}{1e3 * min(times):9.1f}"
              f"{middle:14.2f} ({low:.2f}-{high:.2f}){found[name][0]:10.1e}{found[name][1]:10.1e}")  # fmt: skip


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--size", type=int, nargs=2, default=(1920, 1080), metavar=("WIDTH", "HEIGHT"))
    parser.add_argument("--scale", type=int, default=4)
    parser.add_argument("--frames", type=int, default=8, help="of the clip that differences are taken over")
    parser.add_argument("--repeats", type=int, default=15)
    parser.add_argument("--clock", choices=CLOCKS, default="wall", help="cpu: the process's own, one thread")
    parser.add_argument("--backends", nargs="+", choices=BACKENDS, default=BACKENDS)
    chosen = parser.parse_args()
    torch.set_num_threads(chosen.threads)
    with tempfile.TemporaryDirectory() as made, torch.inference_mode():
        report(chosen, Path(made))
