"""Table of the metrics' sensitivity to faults: all faults on the targets of one clip, as in docs/metrics.md.

    python scripts/timing/blind.py FILE.h5 [CLIP [FRAMES]]

The file needs ``target``, ``motion``, ``motion_dual`` and ``target_radiance``.
"""

import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import torch
import torch.nn.functional as F
from torch import Tensor

from supersampling.data.dataset_file import DatasetFile
from supersampling.metrics.base import FrameMetric, Moment
from supersampling.metrics.directions import better
from supersampling.metrics.flip import FLIP, FLIPHDR
from supersampling.metrics.radiance import PSNRMu
from supersampling.metrics.regions import Regions
from supersampling.metrics.still import PSNR, SSIM, SSIMUniform11, SSIMZeroPad11
from supersampling.metrics.temporal import Temporal
from supersampling.metrics.video.base import VideoMetric
from supersampling.metrics.video.colorvideovdp import ColorVideoVdp
from supersampling.metrics.video.static import StaticDeviation
from supersampling.metrics.video.strred import StRred
from supersampling.metrics.video.vmaf import Vmaf
from supersampling.metrics.video.warping import DualMotion, Photometric, WarpingError
from supersampling.ops.resample import upsample_motion
from supersampling.ops.warp import warp

BUFFERS = ("target", "motion", "motion_dual", "target_radiance")
STILL_METRICS: tuple[FrameMetric, ...] = (PSNR(), SSIM(), SSIMUniform11(), SSIMZeroPad11(), FLIP())
FRAME_METRICS: list[FrameMetric] = [*STILL_METRICS, PSNRMu(1.0), FLIPHDR(-3, 3, 6), Temporal(), Regions()]
WARPING_METRICS: tuple[VideoMetric, ...] = (WarpingError(DualMotion()), WarpingError(Photometric()))
CLIP_METRICS: list[VideoMetric] = [StaticDeviation(), *WARPING_METRICS, StRred(), Vmaf(), ColorVideoVdp()]
# A metric is blind to a fault if it changes by less than this share of its largest change for any fault.
BLIND = 0.05


@dataclass(frozen=True)
class Clip:
    """Buffers of a clip, ``(T, C, H, W)``; both kinds of motion are in low resolution."""

    target: Tensor
    motion: Tensor
    motion_dual: Tensor
    target_radiance: Tensor


# Display colours and radiance of a method, ``(T, 3, H, W)`` each.
Images = tuple[Tensor, Tensor]


def apply_to_both(change: Callable[[Tensor], Tensor]) -> Callable[[Clip], Images]:
    """Return a fault that applies the same change to display colours and to radiance."""
    return lambda clip: (change(clip.target), change(clip.target_radiance))


def flicker(images: Tensor) -> Tensor:
    """Make the middle frame brighter by a tenth."""
    gain = torch.ones(len(images), 1, 1, 1)
    gain[len(images) // 2] = 1.1
    return images * gain


def ghost(clip: Clip) -> Images:
    """Blend every frame equally with the warped previous frame, also where nothing was visible before."""
    height, width = clip.target.shape[-2:]
    blended = []
    for images in (clip.target, clip.target_radiance):
        frames = [images[:1]]
        for image, motion in zip(images[1:], clip.motion[1:]):
            frames.append(0.5 * (image + warp(frames[-1], upsample_motion(motion[None], (height, width)))))
        blended.append(torch.cat(frames))
    return blended[0], blended[1]


def gamma(clip: Clip) -> Images:
    """Keep the radiance and replace the tone map by a power of 1/2.2."""
    return clip.target_radiance.clamp(0.0, 1.0) ** (1.0 / 2.2), clip.target_radiance


def blur(images: Tensor) -> Tensor:
    return F.avg_pool2d(F.pad(images, (1, 1, 1, 1), mode="replicate"), 3, stride=1)


def noise(images: Tensor) -> Tensor:
    """Add noise of deviation 0.03 that differs in each frame."""
    return images + 0.03 * torch.randn(images.shape, generator=torch.Generator().manual_seed(0))


def tint(images: Tensor) -> Tensor:
    """Shift blue to red at the same luma."""
    return images + torch.tensor((0.05, 0.0, -0.05 * 0.2126 / 0.0722))[:, None, None]


FAULTS: dict[str, Callable[[Clip], Images]] = {
    "none": apply_to_both(lambda images: images),
    "flicker": apply_to_both(flicker),
    "ghost": ghost,
    "shift": apply_to_both(lambda images: torch.roll(images, 1, dims=-1)),
    "tone map": gamma,
    "channels": apply_to_both(lambda images: images.flip(1)),
    "tint": apply_to_both(tint),
    "blur": apply_to_both(blur),
    "noise": apply_to_both(noise),
}


def moments(clip: Clip, images: Images) -> Iterator[Moment]:
    """Yield the metrics' inputs for every frame."""
    display, radiance = images[0].clamp(0.0, 1.0), images[1].clamp_min(0.0)
    for t in range(len(clip.target)):
        frame = slice(t, t + 1)
        yield Moment(
            output=display[frame],
            target=clip.target[frame],
            previous=(display[t - 1 : t], clip.target[t - 1 : t]) if t else None,
            motion=clip.motion[frame],
            motion_dual=clip.motion_dual[frame],
            radiance=(radiance[frame], clip.target_radiance[frame]),
        )


@torch.inference_mode()
def scores(clip: Clip, images: Images, metrics: list[FrameMetric], videos: list[VideoMetric]) -> dict[str, float]:
    """Return all scores by name; of frame metrics, the mean of the values that are not NaN."""
    result: dict[str, float] = {}
    for metric in metrics:
        rows = [metric(moment) for moment in moments(clip, images)]
        for name in metric.names:
            values = [row[name] for row in rows if not math.isnan(row[name])]
            result[name] = sum(values) / len(values) if values else math.nan
    for video in videos:
        with video.begin() as scoring:
            for moment in moments(clip, images):
                scoring.add(moment)
            result |= scoring.finish()
    return {name: value for name, value in result.items() if better(name) != "neither"}


def loss(name: str, value: float, perfect: float) -> float:
    """Convert a score to a loss: 0 for the target, larger is worse; decibels become the root mean square error."""
    if name.startswith("psnr"):
        return 10.0 ** (-value / 20.0)
    return perfect - value if better(name) == "higher" else value - perfect


def blind_to(name: str, values: dict[str, float]) -> set[str]:
    """Return the faults that barely change a metric or improve it over the target, given its values by fault."""
    losses = {fault: loss(name, value, values["none"]) for fault, value in values.items()}
    return {fault for fault in losses if fault != "none" and losses[fault] < BLIND * max(losses.values())}


def read(path: Path, number: int, frames: int) -> Clip:
    """Read the last frames of a clip."""
    store = DatasetFile(path)
    span = slice(store.spec.frames - frames, store.spec.frames)
    buffers = {name: torch.from_numpy(store.read(name, number, span)) for name in BUFFERS}
    store.close()
    return Clip(**buffers)


def main(path: str, number: int = 0, frames: int = 16) -> None:
    clip = read(Path(path), number, frames)
    table = {name: scores(clip, fault(clip), FRAME_METRICS, CLIP_METRICS) for name, fault in FAULTS.items()}
    print("| metric | " + " | ".join(table) + " |\n" + "|---" * (len(table) + 1) + "|")
    for name in table["none"]:
        blind = blind_to(name, {fault: row[name] for fault, row in table.items()})
        cells = [f"**{row[name]:.3g}**" if fault in blind else f"{row[name]:.3g}" for fault, row in table.items()]
        print(f"| `{name}` | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1], *(int(word) for word in sys.argv[2:4]))
