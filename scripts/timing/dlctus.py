"""DLCTUS as trained against its deployed form with two optimisations (Swensen 2021, 4.4.4; its tables 7 and 8).

    python scripts/timing/dlctus.py                      one frame of 1920x1080 at 4x4 and at 2x2, one thread
    python scripts/timing/dlctus.py --threads 2 --size 960 540

Both forms alternate, so that a drift of the machine's speed affects both equally; a ratio is the median over such
pairs, with its quartiles. Tests never assert speed.
"""

import argparse
import statistics
import time
from collections.abc import Callable

import torch
import torch.nn.functional as F
from torch import Tensor

from supersampling.frames import Frame
from supersampling.models.dlctus import DLCTUS, STRIDE
from supersampling.models.dlctus_inference import (
    DLCTUSForInference,
    depth_to_space,
    in_blocks,
    space_to_depth,
    sparse_blocks,
)
from supersampling.ops.resample import zero_upsample
from supersampling.stages.accumulate import AccumulationBuffer
from supersampling.stages.confine import Clamp
from supersampling.stages.dilate import NoDilation
from supersampling.stages.initialise import Published
from supersampling.stages.pad import JitterAligned
from supersampling.stages.reproject import Bicubic9

Work = Callable[[], object]


def milliseconds(work: Work) -> float:
    start = time.perf_counter()
    work()
    return 1e3 * (time.perf_counter() - start)


def pairs(model: DLCTUS, deployed: DLCTUSForInference, frame: Frame, state: Tensor) -> dict[str, tuple[Work, Work]]:
    """Return the parts of one frame in both forms; the reprojection, equal in both, is only part of "whole frame"."""
    samples, jitter = model.samples(frame)
    aligned, history = model.prepare(frame, state)
    size = (aligned.shape[-2], aligned.shape[-1])
    sparse = zero_upsample(samples, jitter, model.scale)
    whole = torch.cat((sparse, history), dim=1)
    blocks = space_to_depth(in_blocks(whole)).flatten(1, 3).contiguous()
    low = model.network.down(whole)

    def write() -> Tensor:
        return torch.cat((zero_upsample(samples, jitter, model.scale), history), dim=1)

    def write_blocks() -> Tensor:
        parts = (sparse_blocks(samples, jitter, model.scale), space_to_depth(in_blocks(history)))
        return torch.cat(parts, dim=1).flatten(1, 3)

    def residual() -> Tensor:
        x = low
        for block in deployed.network.blocks:
            x = block(x)
        return x

    def construct() -> Tensor:
        return model.construct(aligned, history, F.pixel_shuffle(low, STRIDE))

    def construct_from_view() -> Tensor:
        predicted = depth_to_space(low.unflatten(1, (2, STRIDE, STRIDE)))
        built = deployed.construct(in_blocks(aligned), in_blocks(history), predicted)
        return built.flatten(4, 5).flatten(2, 3).view(1, -1, *size)

    return {
        "writing the network's input": (write, write_blocks),
        "first convolution": (lambda: model.network.down(whole), lambda: deployed.network.down(blocks)),
        "both, optimisation 2": (lambda: model.network.down(write()), lambda: deployed.network.down(write_blocks())),
        "residual blocks": (residual, residual),
        "output construction, optimisation 1": (construct, construct_from_view),
        "whole frame": (lambda: model(frame, state), lambda: deployed(frame, state)),
    }


def report(scale: int, width: int, height: int, repeats: int) -> None:
    torch.manual_seed(0)
    model = DLCTUS(scale, Bicubic9(), NoDilation(), JitterAligned(), AccumulationBuffer(), Clamp(), Published())
    low = (height // scale, width // scale)
    frame = Frame(
        color=torch.rand(1, 3, *low),
        depth=torch.rand(1, 1, *low),
        motion=torch.randn(1, 2, 1, 1).expand(1, 2, *low) * 0.01,
        jitter=torch.rand(1, 2) - 0.5,
    )
    state, deployed = torch.rand(1, 4, height, width), DLCTUSForInference(model)
    difference = (model(frame, state)[1] - deployed(frame, state)[1]).abs().max().item()
    setting = f"{scale}x{scale} to {width}x{height}, {torch.get_num_threads()} threads, {repeats} pairs"
    print(f"\n{setting}; largest difference {difference:.1e}")
    print(f"{'':36s}{'plain ms':>18s}{'deployed ms':>18s}{'ratio':>20s}")
    for name, (plain, rewritten) in pairs(model, deployed, frame, state).items():
        plain(), rewritten()
        measured = [(milliseconds(plain), milliseconds(rewritten)) for _ in range(repeats)]
        columns = [[a for a, _ in measured], [b for _, b in measured]]
        ratios = sorted(b / a for a, b in measured)
        spreads = [f"{statistics.median(c):8.1f} +-{spread(c):5.1f}" for c in columns]
        quartiles = f"{ratios[len(ratios) // 4]:.2f} to {ratios[-1 - len(ratios) // 4]:.2f}"
        print(f"{name:36s}{spreads[0]:>18s}{spreads[1]:>18s}{statistics.median(ratios):7.2f} ({quartiles})")


def spread(times: list[float]) -> float:
    """Return half of the interquartile range."""
    low, _, high = statistics.quantiles(times, n=4)
    return 0.5 * (high - low)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--size", type=int, nargs=2, default=(1920, 1080), metavar=("WIDTH", "HEIGHT"))
    parser.add_argument("--scale", type=int, nargs="+", default=(4, 2))
    parser.add_argument("--repeats", type=int, default=9)
    options = parser.parse_args()
    torch.set_num_threads(options.threads)
    with torch.no_grad():
        for factor in options.scale:
            report(factor, *options.size, options.repeats)
