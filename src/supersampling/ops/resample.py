"""Upsampling of jittered low-resolution buffers.

Symbols: ``s`` scale, ``h w`` low and ``H W = s*h, s*w`` high resolution.
The sample of low-resolution pixel ``(i, j)`` lies at ``(j + 0.5 + jitter_x, i + 0.5 + jitter_y)``.
"""

import torch
import torch.nn.functional as F
from torch import Tensor

from supersampling.errors import UserError

# Tolerance in target pixels: larger than the error of jitter stored in half precision, at every scale up to 6.
BOUNDARY = 2.0**-8


def check_scale(scale: int) -> int:
    """Return the scale; raise `UserError` unless it is a whole number and at least 1."""
    if int(scale) != scale or scale < 1:
        raise UserError(f"Invalid task.scale={scale}: use a whole number that is at least 1, e.g. 2 or 4.")
    return int(scale)


def pixel_centres(size: int, like: Tensor) -> Tensor:
    """Return normalised positions ``(size,)`` of the pixel centres in [-1, 1], rounded once from float64."""
    centres = (2.0 * torch.arange(size, dtype=torch.float64, device=like.device) + 1.0) / size - 1.0
    return centres.to(like.dtype)


def repeat_upsample(image: Tensor, scale: int) -> Tensor:
    """Repeat every pixel of ``(..., h, w)`` over the target pixels that it covers, ``(..., H, W)``."""
    return image.repeat_interleave(scale, dim=-2).repeat_interleave(scale, dim=-1)


def jitter_aligned_upsample(image: Tensor, jitter: Tensor, scale: int, mode: str = "bilinear") -> Tensor:
    """Upsample so that every sample keeps its position (Swensen 2021, 4.1.1 and A.1).

    Target position ``P`` (low-resolution pixels) reads the image at ``P - jitter``; borders are repeated.

    Args:
        image: ``(B, C, h, w)``.
        jitter: ``(B, 2)`` (x, y), low-resolution pixels in [-0.5, 0.5).
        scale: ``s``.
        mode: ``bilinear`` or ``bicubic``.

    Returns:
        ``(B, C, H, W)``.
    """
    b, _, h, w = image.shape
    x = pixel_centres(w * scale, image) - 2.0 * jitter[:, :1] / w
    y = pixel_centres(h * scale, image) - 2.0 * jitter[:, 1:] / h
    size = (b, h * scale, w * scale)
    grid = torch.stack((x[:, None, :].expand(size), y[:, :, None].expand(size)), dim=-1)
    return F.grid_sample(image, grid, mode=mode, padding_mode="border", align_corners=False)


def zero_upsample(image: Tensor, jitter: Tensor, scale: int) -> Tensor:
    """Write every pixel to the target pixel that contains its sample, zeros elsewhere (Swensen 2021, 4.1.1 and A.1).

    The position in each ``s x s`` block is ``floor((jitter + 0.5) * s)``. A sample less than `BOUNDARY` before a target
    pixel is assigned to that pixel: the thirds of Halton's sequence lie on boundaries at scales 3 and 6, where the
    result would otherwise depend on each program's rounding. Shapes as in `jitter_aligned_upsample`.
    """
    b, c, h, w = image.shape
    # Clamp: a jitter one rounding step below 0.5 would otherwise land in the next block.
    position = torch.floor((jitter + 0.5) * scale + BOUNDARY).clamp(0, scale - 1)
    steps = torch.arange(scale, device=image.device)
    # (B, s, s): rows, columns.
    hit = (position[:, 1, None, None] == steps[:, None]) & (position[:, 0, None, None] == steps)
    spread = torch.where(hit[:, None, None, :, None, :], image[:, :, :, None, :, None], image.new_zeros(()))
    return spread.reshape(b, c, h * scale, w * scale)


def jitter_as_motion(change: Tensor, height: int, width: int) -> Tensor:
    """Convert a jitter difference ``(B, 2)``, pixels of an ``h x w`` image, to motion ``(B, 2, 1, 1)``, image units."""
    # Do not divide by a tensor of (w, h): an exporter would store it as two constants.
    return torch.stack((change[:, 0] / width, change[:, 1] / height), dim=-1)[:, :, None, None]


def upsample_motion(motion: Tensor, size: tuple[int, int]) -> Tensor:
    """Upsample motion ``(B, 2, h, w)`` bilinearly to ``(B, 2, H, W)``; image units need no rescaling."""
    return F.interpolate(motion, size=size, mode="bilinear", align_corners=False)


def gaussian_upsample(image: Tensor, jitter: Tensor, scale: int, sigma: float) -> tuple[Tensor, Tensor]:
    """Reconstruct with a Gaussian from the 3x3 nearest low-resolution samples (Swensen 2021, eqs 38, 41, 42).

    Distances are in target pixels. Neighbours outside the image are ignored. The kernel is separable, so the normalised
    weights are two softmaxes, which stay finite where every unnormalised weight underflows (small sigma).

    Args:
        image: ``(B, C, h, w)``.
        jitter: ``(B, 2)``, low-resolution pixels in [-0.5, 0.5).
        scale: ``s``.
        sigma: standard deviation in target pixels, positive.

    Returns:
        The reconstruction ``(B, C, H, W)``, and ``beta (B, 1, H, W)``, the largest weight before normalisation,
        in [0, 1].
    """
    b, c, h, w = image.shape
    log_x = _tap_log_weights(jitter[:, 0], w, scale, sigma)  # (B, w, s, 3)
    log_y = _tap_log_weights(jitter[:, 1], h, scale, sigma)
    weight_x, weight_y = log_x.softmax(-1)[:, None, None], log_y.softmax(-1)[:, None, :, :, None]
    padded = F.pad(image, (1, 1, 1, 1), mode="replicate")
    wide = sum(padded[..., k : k + w, None] * weight_x[..., k] for k in range(3))
    assert isinstance(wide, Tensor)
    wide = wide.reshape(b, c, h + 2, w * scale)
    tall = sum(wide[:, :, k : k + h, None] * weight_y[..., k] for k in range(3))
    assert isinstance(tall, Tensor)
    best_x, best_y = log_x.amax(-1).reshape(b, -1), log_y.amax(-1).reshape(b, -1)
    beta = (best_y[:, :, None] + best_x[:, None, :]).exp()
    return tall.reshape(b, c, h * scale, w * scale), beta[:, None]


def _tap_log_weights(jitter: Tensor, size: int, scale: int, sigma: float) -> Tensor:
    """Return log weights ``(B, size, s, 3)`` of the previous, current and next sample on one axis; -inf outside."""
    taps = torch.arange(-1, 2, device=jitter.device, dtype=jitter.dtype)
    inside_block = torch.arange(scale, device=jitter.device, dtype=jitter.dtype) + 0.5
    distance = (taps + 0.5 + jitter[:, None]).unsqueeze(1) * scale - inside_block[:, None]  # (B, s, 3)
    pixel = torch.arange(size, device=jitter.device)[:, None, None] + taps
    outside = (pixel < 0) | (pixel >= size)
    log_weight = (-0.5 * (distance / sigma) ** 2).unsqueeze(1).expand(-1, size, -1, -1)
    return log_weight.masked_fill(outside, -torch.inf)
