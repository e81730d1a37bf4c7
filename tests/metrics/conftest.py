"""A rendered clip with moving, still and disoccluded pixels, small enough to be rendered for every run."""

from dataclasses import dataclass

import pytest
import torch
import torch.nn.functional as F
import torchvision  # noqa: F401 - it loads triton's LLVM, which crashes when Mesa's, the renderer's, is there before it
from torch import Tensor

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.spec import CaptureSpec
from supersampling.metrics.base import Moment
from supersampling.render.pool import render_files

BUFFERS = frozenset({"color", "motion", "motion_dual", "target", "target_radiance"})
SPEC = CaptureSpec(
    scene="airstrip",
    split="test",
    clips=1,
    frames=8,
    targets=8,
    frame=(480, 270),
    window=(160, 96),
    scale=4,
    jitter="thesis",
    mip_bias="matched",
    samples=2,
    seed=3,
    candidates=1,
)


@dataclass(frozen=True)
class Film:
    """Frames ``(1, C, H, W)``; ``outputs`` are the low-resolution colours scaled up, like the output of a poor
    method."""

    outputs: list[Tensor]
    targets: list[Tensor]
    motions: list[Tensor]
    duals: list[Tensor]
    radiance: list[tuple[Tensor, Tensor]]

    def moment(self, t: int) -> Moment:
        previous = (self.outputs[t - 1], self.targets[t - 1]) if t else None
        return Moment(
            output=self.outputs[t],
            target=self.targets[t],
            previous=previous,
            motion=self.motions[t],
            motion_dual=self.duals[t],
            radiance=self.radiance[t],
        )


@pytest.fixture(scope="session")
def film(tmp_path_factory) -> Film:
    store = DatasetFile(render_files([SPEC], tmp_path_factory.mktemp("film"), BUFFERS)[0])
    buffers = {name: torch.from_numpy(store.read(name, 0, slice(None)))[:, None] for name in BUFFERS}
    store.close()
    buffers["color"] = torch.stack(
        [F.interpolate(image, scale_factor=4, mode="bilinear") for image in buffers["color"]]
    )
    frames = {name: list(images) for name, images in buffers.items()}
    light = [(F.interpolate(F.avg_pool2d(x, 4), scale_factor=4, mode="bilinear"), x) for x in frames["target_radiance"]]
    return Film(frames["color"], frames["target"], frames["motion"], frames["motion_dual"], light)
