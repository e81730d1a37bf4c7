"""DLCTUS with the rewrites of the thesis's own implementation (Swensen 2021, 4.4.4), equal up to rounding."""

import copy
from abc import ABC
from typing import final

import torch
from torch import Tensor, nn

from supersampling.frames import Frame
from supersampling.models.dlctus import DLCTUS, STRIDE, WIDTH, Blending, pad_to_blocks
from supersampling.ops.resample import zero_upsample


class UnshuffledTrunk(nn.Module):
    """The network without its pixel shuffle: ``(B, ., ., .) -> (B, 32, H / 4, W / 4)``, for whole blocks only."""

    def __init__(self, down: nn.Conv2d, blocks: nn.ModuleList) -> None:
        super().__init__()
        self.down, self.blocks = down, blocks

    def forward(self, x: Tensor) -> Tensor:
        x = self.down(x)
        for block in self.blocks:
            x = block(x)
        return x


class Unshuffled(Blending, ABC):
    """DLCTUS without a pixel shuffle (optimisation 1): output construction reads the network's channels as a view."""

    network: UnshuffledTrunk

    def __init__(self, model: DLCTUS) -> None:
        super().__init__(model.scale, model.reproject, model.dilate, model.pad, model.accumulate, model.confine)

    def forward(self, frame: Frame, state: Tensor | None) -> tuple[Tensor, Tensor]:
        x, aligned, history = self.prepare_input(frame, state)
        return self.construct_image(aligned, history, self.network(pad_to_blocks(x)))

    def construct_image(self, aligned: Tensor, history: Tensor, x: Tensor) -> tuple[Tensor, Tensor]:
        """Return the image and the history from the network's output ``(B, 32, H / 4, W / 4)`` (4.4.3)."""
        height, width = aligned.shape[-2:]
        aligned, history = in_blocks(pad_to_blocks(aligned)), in_blocks(pad_to_blocks(history))
        history = self.construct(aligned, history, depth_to_space(x.unflatten(1, (2, STRIDE, STRIDE))))
        history = history.flatten(4, 5).flatten(2, 3)[..., :height, :width]
        return history[:, :3], history


@final
class DLCTUSWithoutShuffle(Unshuffled):
    """DLCTUS with the thesis's optimisation 1 only (4.4.4); its outputs equal those of the plain form up to rounding.

    Args:
        model: the plain form, which is copied.
    """

    def __init__(self, model: DLCTUS) -> None:
        model = copy.deepcopy(model)
        super().__init__(model)
        self.network = UnshuffledTrunk(model.network.down, model.network.blocks)
        self.train(model.training)


@final
class DLCTUSForInference(Unshuffled):
    """DLCTUS as the thesis deploys it (4.4.4); its outputs and states equal those of the plain form up to rounding.

    Optimisation 1: no pixel shuffle. Output construction reads the network's 32 channels in place, as a view.
    Optimisation 2: the 4x4 convolution of stride 4 becomes a space-to-depth and a 1x1 convolution with the same
    weights. The reordering takes no separate pass: input preparation writes the network's input in that order. The
    thesis then has to shuffle the history back for output construction; here it is also kept in image order, which
    avoids that.

    Args:
        model: the plain form, which is copied.
    """

    def __init__(self, model: DLCTUS) -> None:
        model = copy.deepcopy(model)
        super().__init__(model)
        plain = model.network.down
        # The order of pixel_unshuffle: channel, row, column.
        down: nn.Conv2d = nn.utils.skip_init(
            nn.Conv2d, plain.in_channels * STRIDE**2, WIDTH, 1, device=plain.weight.device, dtype=plain.weight.dtype
        )
        down.load_state_dict({"weight": plain.weight.reshape(WIDTH, -1, 1, 1), "bias": plain.bias})
        self.network = UnshuffledTrunk(down, model.network.blocks)
        self.train(model.training)

    def forward(self, frame: Frame, state: Tensor | None) -> tuple[Tensor, Tensor]:
        x, aligned, history = self.prepare_input(frame, state)
        return self.construct_image(aligned, history, self.network(x))

    def prepare_input(self, frame: Frame, state: Tensor | None) -> tuple[Tensor, Tensor, Tensor]:
        samples, jitter = self.samples(frame)
        aligned, history = self.prepare(frame, state)
        sparse = sparse_blocks(samples, jitter, self.scale)
        blocks = space_to_depth(in_blocks(pad_to_blocks(history)))
        return torch.cat((sparse, blocks), dim=1).flatten(1, 3), aligned, history


def in_blocks(image: Tensor) -> Tensor:
    """Return a view ``(B, C, H / 4, 4, W / 4, 4)`` of an image ``(B, C, H, W)``."""
    return image.unflatten(3, (-1, STRIDE)).unflatten(2, (-1, STRIDE))


def space_to_depth(blocks: Tensor) -> Tensor:
    """Return a view ``(B, C, 4, 4, H / 4, W / 4)`` of ``(B, C, H / 4, 4, W / 4, 4)``."""
    return blocks.permute(0, 1, 3, 5, 2, 4)


def depth_to_space(blocks: Tensor) -> Tensor:
    """Return a view ``(B, C, H / 4, 4, W / 4, 4)`` of ``(B, C, 4, 4, H / 4, W / 4)``."""
    return blocks.permute(0, 1, 4, 2, 5, 3)


def sparse_blocks(image: Tensor, jitter: Tensor, scale: int) -> Tensor:
    """Return `zero_upsample` of ``(B, C, h, w)``, padded, in space-to-depth order: ``(B, C, 4, 4, H / 4, W / 4)``.

    At the thesis's scales, 2 and 4, a block holds whole low-resolution pixels, and is written in that order directly.
    """
    b, _, h, w = image.shape
    pixels = STRIDE // scale  # per block, on each axis
    if STRIDE % scale or h % pixels or w % pixels:
        return space_to_depth(in_blocks(pad_to_blocks(zero_upsample(image, jitter, scale))))
    hit = zero_upsample(image.new_ones(b, 1, 1, 1), jitter, scale) > 0.0  # (B, 1, s, s)
    grouped = image.unflatten(3, (-1, pixels)).unflatten(2, (-1, pixels)).permute(0, 1, 3, 5, 2, 4)
    spread = torch.where(hit[:, :, None, :, None, :, None, None], grouped[:, :, :, None, :, None], image.new_zeros(()))
    return spread.flatten(4, 5).flatten(2, 3)
