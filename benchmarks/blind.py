"""Which metric sees which fault: every fault on the targets of one clip of a data set file, as docs/metrics.md has it.

    python benchmarks/blind.py FILE.h5 [CLIP [FRAMES]]

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
from supersampling.metrics.still import PSNR, SSIM, MSSIMThesis, SSIMUniform11
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
FRAME_METRICS: list[FrameMetric] = [
    *(PSNR(), SSIM(), SSIMUniform11(), MSSIMThesis(), FLIP(), PSNRMu(1.0), FLIPHDR(-3, 3, 6), Temporal(), Regions()),
]
CLIP_METRICS: list[VideoMetric] = [
    *(StaticDeviation(), WarpingError(DualMotion()), WarpingError(Photometric()), StRred(), Vmaf(), ColorVideoVdp()),
]
BLIND = 0.05
"""Of the most that a metric makes of any fault here: what it makes less of, it hardly sees."""


@dataclass(frozen=True)
class Clip:
    """``(T, C, H, W)``; low resolution for both motions."""

    target: Tensor
    motion: Tensor
    motion_dual: Tensor
    target_radiance: Tensor


Pictures = tuple[Tensor, Tensor]
"""A method's display colours and radiance, ``(T, 3, H, W)`` each."""


def each(change: Callable[[Tensor], Tensor]) -> Callable[[Clip], Pictures]:
    """The same of display colours and of radiance."""
    return lambda clip: (change(clip.target), change(clip.target_radiance))


def flicker(images: Tensor) -> Tensor:
    """The middle frame is a tenth brighter."""
    gain = torch.ones(len(images), 1, 1, 1)
    gain[len(images) // 2] = 1.1
    return images * gain


def ghost(clip: Clip) -> Pictures:
    """Half of what is shown is the frame before, carried along the motion, even to where nothing was seen before."""
    height, width = clip.target.shape[-2:]
    shown = []
    for images in (clip.target, clip.target_radiance):
        frames = [images[:1]]
        for image, motion in zip(images[1:], clip.motion[1:]):
            frames.append(0.5 * (image + warp(frames[-1], upsample_motion(motion[None], (height, width)))))
        shown.append(torch.cat(frames))
    return shown[0], shown[1]


def gamma(clip: Clip) -> Pictures:
    """The radiance is right, its tone map is a power of 1/2.2."""
    return clip.target_radiance.clamp(0.0, 1.0) ** (1.0 / 2.2), clip.target_radiance


def blur(images: Tensor) -> Tensor:
    return F.avg_pool2d(F.pad(images, (1, 1, 1, 1), mode="replicate"), 3, stride=1)


def noise(images: Tensor) -> Tensor:
    """Another one in each frame, 0.03."""
    return images + 0.03 * torch.randn(images.shape, generator=torch.Generator().manual_seed(0))


def tint(images: Tensor) -> Tensor:
    """Red for blue, at the same luma."""
    return images + torch.tensor((0.05, 0.0, -0.05 * 0.2126 / 0.0722))[:, None, None]


FAULTS: dict[str, Callable[[Clip], Pictures]] = {
    "none": each(lambda images: images),
    "flicker": each(flicker),
    "ghost": ghost,
    "shift": each(lambda images: torch.roll(images, 1, dims=-1)),
    "tone map": gamma,
    "channels": each(lambda images: images.flip(1)),
    "tint": each(tint),
    "blur": each(blur),
    "noise": each(noise),
}


def moments(clip: Clip, pictures: Pictures) -> Iterator[Moment]:
    shown, light = pictures[0].clamp(0.0, 1.0), pictures[1].clamp_min(0.0)
    for t in range(len(clip.target)):
        now = slice(t, t + 1)
        yield Moment(
            output=shown[now],
            target=clip.target[now],
            previous=(shown[t - 1 : t], clip.target[t - 1 : t]) if t else None,
            motion=clip.motion[now],
            motion_dual=clip.motion_dual[now],
            radiance=(light[now], clip.target_radiance[now]),
        )


@torch.inference_mode()
def scores(clip: Clip, pictures: Pictures, metrics: list[FrameMetric], videos: list[VideoMetric]) -> dict[str, float]:
    """Frames' values as means of those that there are."""
    found: dict[str, float] = {}
    for metric in metrics:
        rows = [metric(moment) for moment in moments(clip, pictures)]
        for name in metric.names:
            values = [row[name] for row in rows if not math.isnan(row[name])]
            found[name] = sum(values) / len(values) if values else math.nan
    for video in videos:
        with video.begin() as scoring:
            for moment in moments(clip, pictures):
                scoring.add(moment)
            found |= scoring.finish()
    return {name: value for name, value in found.items() if better(name) != "neither"}


def loss(name: str, value: float, perfect: float) -> float:
    """0 for the target itself, more is worse; of decibels, the error's root mean square."""
    if name.startswith("psnr"):
        return 10.0 ** (-value / 20.0)
    return perfect - value if better(name) == "higher" else value - perfect


def blind_to(name: str, values: dict[str, float]) -> set[str]:
    """The faults, of the metric's values by fault, that it hardly sees or that it takes for better than the target."""
    losses = {fault: loss(name, value, values["none"]) for fault, value in values.items()}
    return {fault for fault in losses if fault != "none" and losses[fault] < BLIND * max(losses.values())}


def read(path: Path, number: int, frames: int) -> Clip:
    """The clip's last frames."""
    store = DatasetFile(path)
    span = slice(store.spec.frames - frames, store.spec.frames)
    held = {name: torch.from_numpy(store.read(name, number, span)) for name in BUFFERS}
    store.close()
    return Clip(**held)


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
