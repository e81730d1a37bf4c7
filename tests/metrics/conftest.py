"""A rendered clip, small enough to be made anew for every run, in which some things move, others rest and some are uncovered."""

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
SPEC = CaptureSpec("airstrip", "test", 1, 8, 8, (480, 270), (160, 96), 4, "thesis", "matched", 2, 3, 1)


@dataclass(frozen=True)
class Film:
    """Frames ``(1, C, H, W)``; ``outputs`` are the low-resolution colours scaled up, as a poor method would have it."""

    outputs: list[Tensor]
    targets: list[Tensor]
    motions: list[Tensor]
    duals: list[Tensor]
    radiance: list[tuple[Tensor, Tensor]]

    def moment(self, t: int) -> Moment:
        previous = (self.outputs[t - 1], self.targets[t - 1]) if t else None
        return Moment(
            output=self.outputs[t], target=self.targets[t], previous=previous, motion=self.motions[t],
            motion_dual=self.duals[t], radiance=self.radiance[t],
        )  # fmt: skip


@pytest.fixture(scope="session")
def film(tmp_path_factory) -> Film:
    store = DatasetFile(render_files([SPEC], tmp_path_factory.mktemp("film"), BUFFERS)[0])
    held = {name: torch.from_numpy(store.read(name, 0, slice(None)))[:, None] for name in BUFFERS}
    store.close()
    held["color"] = torch.stack([F.interpolate(image, scale_factor=4, mode="bilinear") for image in held["color"]])
    frames = {name: list(images) for name, images in held.items()}
    light = [(F.interpolate(F.avg_pool2d(x, 4), scale_factor=4, mode="bilinear"), x) for x in frames["target_radiance"]]
    return Film(frames["color"], frames["target"], frames["motion"], frames["motion_dual"], light)
