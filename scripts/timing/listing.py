"""The thesis's PyTorch listing (Swensen 2021, appendix A.1), line by line, for `inference.py` to time.

The only changes are those needed to run it here: ``cuda`` is removed, the caller's motion is not modified, and depth is
linear.
"""

import torch
import torch.nn as nn
import torch.nn.functional as F
from torch import Tensor


class ZeroUpsampling(nn.Module):
    def __init__(self, factor: int, channels: int) -> None:
        super().__init__()
        self.factor, self.channels = factor, channels
        w = torch.zeros(factor, factor)
        w[0, 0] = 1.0
        self.register_buffer("w", w.expand(channels, 1, factor, factor))

    def forward(self, x: Tensor) -> Tensor:
        return F.conv_transpose2d(x, self.w, stride=self.factor, groups=self.channels)  # type: ignore[arg-type]


def jitter_align(img: Tensor, jitter: Tensor, factor: int, mode: str = "constant") -> Tensor:
    jitter_index = torch.floor(jitter * factor).int()
    img = F.pad(img, (factor, factor, factor, factor), mode=mode)
    out = []
    for b in range(len(img)):
        i, j = int(jitter_index[b, 1]), int(jitter_index[b, 0])
        out.append(img[b, :, factor - i : -factor - i, factor - j : -factor - j])
    return torch.stack(out)


def jitter_aligned_interpolation(img: Tensor, jitter: Tensor, factor: int, mode: str = "bilinear") -> Tensor:
    n, c, h, w = img.shape
    theta = []
    for i in range(n):
        shift = [2.0 * (0.5 - float(jitter[i, 0])) / w, 2.0 * (0.5 - float(jitter[i, 1])) / h]
        theta.append(torch.tensor([[1.0, 0.0, shift[0]], [0.0, 1.0, shift[1]]]))
    grid = F.affine_grid(torch.stack(theta), [n, c, h * factor, w * factor], align_corners=False)
    return F.grid_sample(img, grid, mode=mode, align_corners=False, padding_mode="border")


def identity_grid(shape: torch.Size) -> Tensor:
    n, h, w, c = shape
    theta = torch.tensor([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).unsqueeze(0).expand(n, -1, -1)
    return F.affine_grid(theta, [n, c, h, w], align_corners=False)


def residual() -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(32, 32, 3, stride=1, padding=1, padding_mode="replicate"),
        nn.ReLU(),
        nn.Conv2d(32, 32, 3, stride=1, padding=1, padding_mode="replicate"),
    )


class MasterNet(nn.Module):
    """The listing's network.

    ``forward(frame (N, 3, h, w), depth (N, 1, h, w), mv (N, h, w, 2), jitter (N, 2), history) -> (colour, history)``;
    ``mv`` are normalised positions in the previous image, ``jitter`` lies in [0, 1).
    """

    def __init__(self, factor: int) -> None:
        super().__init__()
        self.factor = factor
        self.zero_up = ZeroUpsampling(factor, 4)
        self.down = nn.Sequential(nn.Conv2d(8, 32, 4, stride=4))
        self.cnn1, self.cnn2, self.cnn3, self.cnn4 = (residual() for _ in range(4))
        self.up = nn.Sequential(nn.PixelShuffle(4))

    def forward(
        self, frame: Tensor, depth: Tensor, mv: Tensor, jitter: Tensor, history: Tensor | None
    ) -> tuple[Tensor, Tensor]:
        mini_batch, _, height, width = frame.shape
        frame_ones = torch.cat((frame, torch.ones(mini_batch, 1, height, width)), dim=1)

        # Frame upsampling
        frame_bilinear = jitter_aligned_interpolation(frame_ones, jitter, self.factor)
        frame = torch.cat((frame, depth), dim=1)
        frame = self.zero_up(frame)
        frame = jitter_align(frame, jitter, self.factor)

        if history is None:  # First frame is handled by its own
            history = frame_bilinear
        else:
            # Upscaling motion vector
            mv = mv - identity_grid(mv.shape)
            mv = torch.movedim(mv, 3, 1)
            mv = F.interpolate(mv, scale_factor=self.factor, mode="bilinear", align_corners=False)
            mv = torch.movedim(mv, 1, 3)
            mv += identity_grid(mv.shape)

            # History reprojection
            history = F.grid_sample(history, mv, mode="bicubic", align_corners=False, padding_mode="border")

            # Special case for padding
            mask = torch.logical_or(torch.greater(mv, 1.0), torch.less(mv, -1.0))
            mask = torch.logical_or(mask[:, :, :, 0], mask[:, :, :, 1])
            mask = mask.unsqueeze(1)
            mask = mask.expand(mini_batch, 4, height * self.factor, width * self.factor)
            history[mask] = frame_bilinear[mask]

        # Execute network
        small_input = torch.cat((frame, history), dim=1)
        small_input = self.down(small_input)
        small_input = small_input + self.cnn1(small_input)
        small_input = small_input + self.cnn2(small_input)
        small_input = small_input + self.cnn3(small_input)
        small_input = small_input + self.cnn4(small_input)
        residual = self.up(small_input)

        # Output construction
        residual = torch.clamp(residual, 0.0, 1.0)
        alpha = residual[:, 0:1, :, :]
        history = history * (1.0 - alpha) + frame_bilinear * alpha
        history_start = history[:, 0:3, :, :]
        history_end = history[:, 3:4, :, :] * residual[:, 1:2, :, :]
        history = torch.cat((history_start, history_end), dim=1)
        history = torch.clamp(history, 0.0, 1.0)
        return history[:, :3, :, :], history
