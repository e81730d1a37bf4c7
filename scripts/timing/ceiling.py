"""Share of a frame's time that its convolutions need, and the operations that take the rest, for every model.

    python scripts/timing/ceiling.py                                   all models to 1920x1080 at 4x4, two threads
    python scripts/timing/ceiling.py model=enss_s,dlctus threads=1 clock=cpu layout=channels_last

Two ceilings, relative to the time of the frame: *alone* is the time of the frame's convolutions only, with the same
shapes, one after another, each in the faster of the two layouts; *product* is the time of a large matrix product with
as many multiply-accumulates. A method with a different convolution algorithm (DLCTUS's native form uses Winograd's) may
exceed 1. Models without convolutions have neither. Below each line are the shares of the frame's operations, largest
first. ``clock=cpu`` counts processor time of the process instead of wall time, for one thread on a shared machine.
"""

import os
import statistics
import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import torch
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate
from torch.utils._python_dispatch import TorchDispatchMode

from supersampling.commands.resolvers import register
from supersampling.models.base import Upsampler
from supersampling.models.count import random_frame
from supersampling.models.dlctus import DLCTUS
from supersampling.models.dlctus_native import DLCTUSNative
from supersampling.profiling import memory
from supersampling.profiling.ceiling import Kernels

ROOT = Path(__file__).resolve().parents[2]
os.environ.setdefault("SUPERSAMPLING_ROOT", str(ROOT))
CONF = ROOT / "conf"
MODELS = "dlctus,dlctus:deployed,dlctus:native,nsrd,enss_s,enss_m,enss_l,tus,jau,bicubic,nsrr"
DEFAULTS = {
    "model": MODELS,
    "threads": "2",
    "repeats": "5",
    "size": "1920x1080",
    "scale": "4",
    "clock": "wall",
    "layout": "contiguous",
}
CLOCKS = {"wall": time.perf_counter, "cpu": time.process_time}

Call = tuple[Any, ...]


class Recorder(TorchDispatchMode):
    """Recorder of the time of every operation, by name, and of the arguments of convolutions."""

    def __init__(self, clock: Callable[[], float]) -> None:
        super().__init__()
        self.clock = clock
        self.seconds: dict[str, float] = {}
        self.calls: list[Call] = []

    def __torch_dispatch__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        start = self.clock()
        result = func(*args, **(kwargs or {}))
        name = func.overloadpacket.__name__
        self.seconds[name] = self.seconds.get(name, 0.0) + self.clock() - start
        if func is torch.ops.aten.convolution.default:
            self.calls.append(args)
        return result


def build(name: str, scale: int, layout: str) -> Upsampler:
    """Build a model of ``conf/model`` in the form after the colon: plain if none, ``deployed`` or ``native``."""
    name, _, form = name.partition(":")
    register()
    with initialize_config_dir(str(CONF), version_base="1.3"):
        cfg = compose("count", [f"model={name}", f"task.scale={scale}"])
    torch.manual_seed(0)
    model: Upsampler = instantiate(cfg.model).eval()
    if form and isinstance(model, DLCTUS):
        model = DLCTUSNative(model) if form == "native" else model.for_inference()
    if layout == "channels_last":
        model = model.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    return model


def macs(call: Call) -> int:
    """Return the multiply-accumulates of a convolution that is not transposed."""
    x, weight, _, stride, padding, dilation = call[:6]
    sides = [
        (n + 2 * p - d * (k - 1) - 1) // s + 1
        for n, k, s, p, d in zip(x.shape[2:], weight.shape[2:], stride, padding, dilation)
    ]
    return int(x.shape[0] * sides[0] * sides[1] * weight.numel())


def convolution_seconds(calls: list[Call], clock: Callable[[], float], repeats: int) -> float:
    """Return the seconds of the convolutions; equal shapes are timed once, each in its faster layout."""
    shapes = Counter((c[0].shape, c[1].shape, *map(tuple, c[3:6]), c[8]) for c in calls)
    total = 0.0
    for (x_shape, w_shape, stride, padding, dilation, groups), count in shapes.items():
        times = []
        for layout in (torch.contiguous_format, torch.channels_last):
            x = torch.rand(x_shape).contiguous(memory_format=layout)
            weight, bias = torch.rand(w_shape).contiguous(memory_format=layout), torch.rand(w_shape[0])
            run = partial(torch.conv2d, x, weight, bias, stride, padding, dilation, groups)
            run()
            times.append(fastest(run, clock, repeats))
        total += count * min(times)
    return total


def fastest(work: Callable[[], object], clock: Callable[[], float], repeats: int) -> float:
    times = []
    for _ in range(repeats):
        start = clock()
        work()
        times.append(clock() - start)
    return min(times)


def convolutions(model: Upsampler, width: int, height: int) -> list[Call]:
    """Return the convolutions of a frame."""
    recorder, frame = Recorder(time.perf_counter), random_frame(model, width, height, "cpu")
    state = model(frame, None)[1]
    with recorder:
        model(frame, state)
    return recorder.calls


def print_model(name: str, options: Mapping[str, str], rate: float) -> None:
    """Time one model and print its lines."""
    clock, repeats, scale = CLOCKS[options["clock"]], int(options["repeats"]), int(options["scale"])
    width, height = (int(n) // scale for n in options["size"].split("x"))
    model = build(name, scale, options["layout"])
    frames = [random_frame(model, width, height, "cpu", seed=t) for t in range(3)]
    # The native form has no PyTorch convolutions: count those of the deployed form.
    calls = convolutions(build(name.replace(":native", ":deployed"), scale, options["layout"]), width, height)
    state: Any = None
    for frame in frames:
        _, state = model(frame, state)
    times = []
    for t in range(repeats):
        start = clock()
        model(frames[t % 3], state)
        times.append(clock() - start)
    recorder = Recorder(clock)
    with recorder:
        model(frames[0], state)
    frame, work = min(times), sum(map(macs, calls))
    line = f"{name:16s}{1e3 * frame:9.1f} ms (median {1e3 * statistics.median(times):.1f}){work / 1e9:9.2f} GMAC"
    if work:
        bound = convolution_seconds(calls, clock, repeats)
        line += f"   alone {bound / frame:5.2f} ({work / bound / 1e9:.0f} GMAC/s)   product {work / rate / frame:5.2f}"
    print(line)
    total = max(frame, sum(recorder.seconds.values()))
    largest = sorted(recorder.seconds.items(), key=lambda item: -item[1])
    shares = [f"{op} {s / total:.0%}" for op, s in largest[:9] if s / total > 0.01]
    if name.endswith(":native"):
        shares = ["C++ instead of PyTorch operations"]
    print(" " * 8 + ", ".join(shares), flush=True)


def main() -> None:
    options = DEFAULTS | dict(argument.split("=", 1) for argument in sys.argv[1:])
    torch.set_num_threads(int(options["threads"]))
    memory.retain_freed()
    clock = CLOCKS[options["clock"]]
    kernels = Kernels(torch.device("cpu"), torch.float32)
    rate = kernels.macs / min(fastest(product, clock, 20) for product in kernels.products)
    setting = f"{options['size']} at {options['scale']}x{options['scale']}, {options['threads']} threads"
    print(f"{setting}, {options['layout']}, {options['clock']} clock; matrix product {rate / 1e9:.0f} GMAC/s")
    # Not inference mode, which hides convolutions from the recorder.
    with torch.no_grad():
        for name in options["model"].split(","):
            print_model(name, options, rate)


if __name__ == "__main__":
    main()
