"""DLCTUS on every backend against the thesis's listing (``listing.py``), alternating in one process.

    python scripts/timing/inference.py                                      1920x1080 at 4x4, two threads
    python scripts/timing/inference.py --backends native eager --repeats 31 --scale 2
    python scripts/timing/inference.py --threads 1 --clock cpu              on a shared machine

The backends are PyTorch's operations (``eager`` as trained, ``deployed`` with the thesis's two rewrites,
``channels_last`` and ``compile`` the deployed form in that layout and compiled), the exported graph under
``onnxruntime`` and ``openvino``, and ``native``, C++ passes. All have the same weights and process the same clip, each
with its own state. A ratio is the median over rounds of listing over backend, with its quartiles; ``apart`` is the
largest difference of an image from the listing's over the clip, ``error`` that from the listing in float64: in the
first line it is the listing's rounding error.
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
    """Build DLCTUS with seeded weights, balanced so that most outputs lie within the clamp, as after training."""
    torch.manual_seed(0)
    stages = (Bicubic9(), NoDilation(), JitterAligned(), AccumulationBuffer(), StraightThrough(), Balanced())
    return DLCTUS(scale, *stages).eval()


def moving_texture(frames: int, h: int, w: int) -> list[Frame]:
    """Return a texture with 5% of noise that moves everywhere, in places out of the image."""
    generator = torch.Generator().manual_seed(0)
    y, x = torch.meshgrid(torch.linspace(0, 1, h), torch.linspace(0, 1, w), indexing="ij")
    clip = []
    for t in range(frames):
        motion = torch.stack((0.004 * torch.sin(6 * x + t) + 0.006, 0.005 * torch.cos(5 * y - t) + 0.002))[None]
        waves = [torch.sin(k * 40 * (x + 0.006 * t) + 31 * y * (k + 1) + k) for k in range(3)]
        noise = 0.05 * torch.rand(1, 3, h, w, generator=generator)
        color = 0.475 + 0.45 * torch.stack(waves)[None] + noise
        depth = torch.rand(1, 1, h, w, generator=generator)
        jitter = torch.rand(1, 2, generator=generator) - 0.5
        clip.append(Frame(color=color, depth=depth, motion=motion, jitter=jitter))
    return clip


def load_listing(model: DLCTUS) -> MasterNet:
    net = MasterNet(model.scale)
    convolutions = {"down.0": model.network.down}
    for k, block in enumerate(model.network.blocks, 1):
        convolutions |= {f"cnn{k}.{index}": block[index] for index in (0, 2)}  # type: ignore[index]
    weights = {
        f"{name}.{key}": value for name, conv in convolutions.items() for key, value in conv.state_dict().items()
    }
    net.load_state_dict(weights | {"zero_up.w": net.zero_up.w})
    return net.eval()


def listing_inputs(frame: Frame, dtype: torch.dtype) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Return the inputs of the listing, untimed: positions instead of motion, rounded once; jitter in [0, 1)."""
    color, depth, motion, jitter = frame.need("color", "depth", "motion", "jitter")
    h, w = color.shape[-2:]
    x, y = ((2.0 * torch.arange(n, dtype=torch.float64) + 1.0) / n - 1.0 for n in (w, h))
    centres = torch.stack((x.expand(h, w), y[:, None].expand(h, w)), dim=-1)
    positions = centres + 2.0 * motion.permute(0, 2, 3, 1).double()
    return color.to(dtype), depth.to(dtype), positions.to(dtype), jitter.to(dtype) + 0.5


def listing(model: DLCTUS, frames: Sequence[Frame], dtype: torch.dtype = torch.float32) -> Step:
    net, inputs = load_listing(model).to(dtype), [listing_inputs(frame, dtype) for frame in frames]
    if dtype == torch.float32:
        return lambda t, state: net(*inputs[t], state)

    def step(t: int, state: Any) -> tuple[Tensor, Any]:
        # The listing creates tensors without a dtype.
        torch.set_default_dtype(dtype)
        try:
            return net(*inputs[t], state)  # type: ignore[no-any-return]
        finally:
            torch.set_default_dtype(torch.float32)

    return step


def backend(name: str, model: DLCTUS, frames: Sequence[Frame], threads: int, folder: Path) -> Step:
    """Return the step of a backend; raise `UserError` if it does not run."""
    method: Upsampler[Tensor] = model
    if name == "native":
        method = DLCTUSNative(model)
    elif name != "eager":
        method = model.for_inference()
    if name in ("onnxruntime", "openvino"):
        runtime = OnnxRuntime if name == "onnxruntime" else OpenVINO
        return export_step(method, frames, runtime(threads=threads), folder / name)
    if name == "channels_last":
        method = method.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    run: Any = torch.compile(method) if name == "compile" else method
    return lambda t, state: run(frames[t], state)


def export_step(model: Upsampler, frames: Sequence[Frame], runtime: Runtime, folder: Path) -> Step:
    h, w = frames[0].need("color").shape[-2:]
    with torch.inference_mode(False), torch.no_grad():
        graphs = export(copy.deepcopy(model), (w, h))
    folder.mkdir()
    write(folder / "next.onnx", model, graphs)
    runner, inputs = Runner(folder / "next.onnx", runtime), [arrays(frame) for frame in frames]
    return lambda t, state: (torch.from_numpy(runner(inputs[t])), None)  # the runner keeps the state


def differences(steps: dict[str, Step], exact: Step, frames: int) -> dict[str, tuple[float, float, Any]]:
    """Return by name the differences from the listing and from the exact step, and the state after the clip."""
    states: dict[str, Any] = dict.fromkeys(steps)
    apart, error = dict.fromkeys(steps, 0.0), dict.fromkeys(steps, 0.0)
    state = None
    for t in range(frames):
        reference, state = exact(t, state)
        first = None
        for name, step in steps.items():
            image, states[name] = step(t, states[name])
            first = image.clone() if first is None else first
            apart[name] = max(apart[name], float((image - first).abs().max()))
            error[name] = max(error[name], float((image - reference).abs().max()))
    return {name: (apart[name], error[name], states[name]) for name in steps}


def report(options: argparse.Namespace, folder: Path) -> None:
    width, height = options.size
    frames = moving_texture(options.frames, height // options.scale, width // options.scale)
    model, clock = dlctus(options.scale), CLOCKS[options.clock]
    steps = {"listing": listing(model, frames)}
    for name in options.backends:
        try:
            steps[name] = backend(name, model, frames, options.threads, folder)
        except (UserError, ImportError) as error:
            steps.pop(name, None)
            print(f"{name} does not run: {error}")
    results = differences(steps, listing(model, frames, torch.float64), options.frames)
    seconds: dict[str, list[float]] = {name: [] for name in steps}
    for k in range(options.repeats):
        for name, step in steps.items():
            start = clock()
            step(k % options.frames, results[name][2])
            seconds[name].append(clock() - start)
    setting = f"{options.scale}x{options.scale} to {width}x{height}, {options.threads} threads"
    print(f"{setting}, {options.repeats} rounds, {options.clock} clock")
    print(f"{'':16s}{'median ms':>10s}{'fastest':>9s}{'times as fast':>26s}{'apart':>10s}{'error':>10s}")
    for name, times in seconds.items():
        low, middle, high = np.quantile(np.divide(seconds["listing"], times), (0.25, 0.5, 0.75))
        apart, error, _ = results[name]
        ratio = f"{middle:14.2f} ({low:.2f}-{high:.2f})"
        print(f"{name:16s}{1e3 * np.median(times):10.1f}{1e3 * min(times):9.1f}{ratio}{apart:10.1e}{error:10.1e}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--size", type=int, nargs=2, default=(1920, 1080), metavar=("WIDTH", "HEIGHT"))
    parser.add_argument("--scale", type=int, default=4)
    parser.add_argument("--frames", type=int, default=8, help="length of the clip for the differences")
    parser.add_argument("--repeats", type=int, default=15)
    parser.add_argument("--clock", choices=CLOCKS, default="wall", help="cpu: processor time, for one thread")
    parser.add_argument("--backends", nargs="+", choices=BACKENDS, default=BACKENDS)
    options = parser.parse_args()
    torch.set_num_threads(options.threads)
    with tempfile.TemporaryDirectory() as folder, torch.inference_mode():
        report(options, Path(folder))
