"""Seconds per clip of each metric, and peak memory for the clip and for half of it, each in a separate process.

    python scripts/timing/metrics.py                                      all, 60 frames at 1080p, two threads: hours
    python scripts/timing/metrics.py psnr vmaf size=480x270 frames=16 threads=1

Memory is the peak of the process and its children; the row `nothing` is that of Python and the frames.
"""

import multiprocessing
import resource
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from multiprocessing.pool import Pool

import torch

from supersampling.errors import UserError
from supersampling.metrics.base import FrameMetric, Moment
from supersampling.metrics.flip import FLIP, FLIPHDR
from supersampling.metrics.lpips import LPIPS
from supersampling.metrics.radiance import PSNRMu
from supersampling.metrics.regions import Regions
from supersampling.metrics.still import PSNR, SSIM, SSIMUniform11, SSIMZeroPad11
from supersampling.metrics.temporal import Temporal
from supersampling.metrics.video.base import Scoring, VideoMetric, VideoSuite
from supersampling.metrics.video.colorvideovdp import ColorVideoVdp
from supersampling.metrics.video.static import StaticDeviation
from supersampling.metrics.video.strred import StRred
from supersampling.metrics.video.vmaf import Vmaf
from supersampling.metrics.video.warping import DualMotion, Photometric, WarpingError

METRICS: dict[str, Callable[[], FrameMetric | VideoMetric]] = {
    "nothing": VideoSuite,
    "psnr": PSNR,
    "ssim": SSIM,
    "ssim_uniform11": SSIMUniform11,
    "ssim_zero_pad11": SSIMZeroPad11,
    "spatial, temporal": Temporal,
    "regions": Regions,
    "psnr_hdr_mu": partial(PSNRMu, 1.0),
    "static_std": StaticDeviation,
    "warping_error": partial(WarpingError, DualMotion()),
    "warping_error_photometric": partial(WarpingError, Photometric()),
    "strred": StRred,
    "vmaf": Vmaf,
    "lpips_alex": partial(LPIPS, "alex"),
    "flip": FLIP,
    "flip_hdr": partial(FLIPHDR, -3, 3, 6),
    "cvvdp": ColorVideoVdp,
}


def clip(width: int, height: int, frames: int) -> Iterator[Moment]:
    """Yield a noisy pan by two pixels per frame, generated lazily; by its motion, three quarters of it are static."""
    panorama = torch.rand(1, 3, height, width + 512)
    motion = torch.zeros(1, 2, height // 4, width // 4)
    motion[:, 0, : height // 16] = 2 / width
    previous = None
    for t in range(frames):
        x = 2 * (t % 256)
        target = panorama[..., x : x + width].contiguous()
        output = (target + 0.02 * torch.rand_like(target)).clamp_(0.0, 1.0)
        yield Moment(
            output=output,
            target=target,
            previous=previous,
            motion=motion,
            motion_dual=motion,
            radiance=(output, target),
        )
        previous = (output, target)


class _Frames(Scoring):
    """A frame metric, timed as a clip metric."""

    def __init__(self, metric: FrameMetric) -> None:
        self._metric = metric

    def add(self, moment: Moment) -> None:
        self._metric(moment)

    def finish(self) -> dict[str, float]:
        return {}


def run(scoring: Scoring, moments: Iterator[Moment]) -> float:
    """Return the seconds spent in the metric, without generating the frames."""
    seconds = 0.0
    with scoring:
        for moment in moments:
            start = time.perf_counter()
            scoring.add(moment)
            seconds += time.perf_counter() - start
        start = time.perf_counter()
        scoring.finish()
        return seconds + time.perf_counter() - start


def measure(name: str, width: int, height: int, frames: int, threads: int) -> tuple[float, float] | str:
    """Return seconds and MiB, or the reason why the metric does not run."""
    torch.set_num_threads(threads)
    try:
        metric = METRICS[name]()
    except UserError as error:
        return str(error).split(":")[0]
    scoring = metric.begin() if isinstance(metric, VideoMetric) else _Frames(metric)
    with torch.inference_mode():
        seconds = run(scoring, clip(width, height, frames))
    peak = sum(resource.getrusage(process).ru_maxrss for process in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return seconds, peak / 1024


def main(arguments: list[str]) -> None:
    options = {"size": "1920x1080", "frames": "60", "threads": "2"} | dict(a.split("=") for a in arguments if "=" in a)
    width, height = (int(side) for side in options["size"].split("x"))
    frames, threads = int(options["frames"]), int(options["threads"])
    print(f"{width}x{height}, {frames} frames, {threads} threads\n")
    print(f"| metric | s | MiB, {frames // 2} frames | MiB, {frames} frames |\n|---|---:|---:|---:|", flush=True)
    for name in [a for a in arguments if "=" not in a] or METRICS:
        rows = []
        for count in (frames // 2, frames):
            with Pool(1, context=multiprocessing.get_context("spawn")) as pool:
                rows.append(pool.apply(measure, (name, width, height, count, threads)))
        half, full = rows
        if isinstance(half, str) or isinstance(full, str):
            print(f"| {name} | {full} | | |", flush=True)
        else:
            print(f"| {name} | {full[0]:.1f} | {half[1]:.0f} | {full[1]:.0f} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
