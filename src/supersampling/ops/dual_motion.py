"""Dual motion vectors (Li et al. 2024, NSRD, supplement, section 2 and figure 3; after Zeng et al. 2021).

Legend, all in pixels of the current image: ``x`` a currently visible pixel, ``y = x + motion`` the position of its
point in the previous frame, ``z = y + forward(y)`` the current position of the surface that the previous frame showed
at ``y``. The relative motion from ``z`` to ``x``, applied to ``y``, gives ``x_O = y + (x - z)``, and the dual motion
vector is ``x_O - x = -forward(y)``: the occluder's motion. Where the point itself was visible at ``y``, ``z = x`` and
both vectors are equal.
"""

import torch
from torch import Tensor

# Fraction of the inverse depth by which an occluder must be nearer: tolerates rounding and coincident surfaces.
_TOLERANCE = 2e-3


def dual_motion(
    motion: Tensor, previous_depth: Tensor, jitter: Tensor, forward: Tensor, visible_depth: Tensor, margin: int
) -> Tensor:
    """Return dual motion vectors ``(B, 2, h, w)`` in pixels.

    A point counts as occluded where the previous frame shows, at the pixel nearest to ``y``, a surface nearer than the
    point was, by more than the depth of the point's surface changes within half a pixel. Points that were outside the
    previous image, or behind its camera, have no occluder: their two vectors are equal.

    Args:
        motion: ``(B, 2, h, w)`` backward motion in pixels of the samples at pixel centre + ``jitter``.
        previous_depth: ``(B, 1, h, w)`` view depth of each sample's point in the previous frame, metres; sky infinite.
        jitter: ``(B, 2)`` in pixels.
        forward: ``(B, 2, h + 2 margin, w + 2 margin)`` motion of the previous frame's surfaces to the current one,
            pixels.
        visible_depth: ``(B, 1, h + 2 margin, w + 2 margin)`` view depth in the previous frame, metres; sky infinite.
        margin: pixels that the previous frame extends beyond the image on each side.
    """
    batch, _, height, width = motion.shape
    rows, columns = torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij")
    pixel = torch.stack((columns, rows)).to(motion)
    # The pixel that contains y: centres are at + 0.5, so the floor of the position is its index.
    position = torch.floor(pixel + 0.5 + jitter[..., None, None] + motion + margin)
    limit = torch.tensor((width, height), dtype=motion.dtype, device=motion.device)[:, None, None] + 2 * margin
    inside = ((position >= 0) & (position < limit)).all(dim=1, keepdim=True) & (previous_depth > 0)
    x, y = torch.where(inside, position, 0.0).long().unbind(dim=1)
    index = (y * (width + 2 * margin) + x).flatten(1)[:, None]
    occluder = forward.flatten(2).gather(2, index.expand(batch, 2, -1)).view_as(motion)
    visible = visible_depth.flatten(2).gather(2, index).view_as(previous_depth)
    # Inverse depth is linear over the image on a plane, and 0 for the sky.
    inverse = torch.where(inside, 1.0 / previous_depth, 0.0)
    nearer = 1.0 / visible - inverse
    occluded = inside & (nearer > _slope(inverse) / 2.0 + _TOLERANCE * inverse)
    return torch.where(occluded, -occluder, motion)


def _slope(values: Tensor) -> Tensor:
    """Return ``|d/dx| + |d/dy|`` per pixel, taken on the neighbour on the same surface: the smaller difference."""
    total = torch.zeros_like(values)
    for dim in (-1, -2):
        if values.shape[dim] < 2:
            continue
        step = values.diff(dim=dim).abs()
        first, last = step.narrow(dim, 0, 1), step.narrow(dim, step.shape[dim] - 1, 1)
        total = total + torch.minimum(torch.cat((first, step), dim), torch.cat((step, last), dim))
    return total
