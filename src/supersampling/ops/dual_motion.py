"""Dual motion vectors (Li et al. 2024, NSRD, supplement, section 2 and figure 3; after Zeng et al. 2021).

Legend, all in pixels of the current image: ``x`` a pixel that is visible now, ``y = x + motion`` where its point was in the
previous frame, ``z = y + forward(y)`` where that which was seen at ``y`` is now. The relative motion from ``z`` to ``x``, applied
to ``y``, gives ``x_O = y + (x - z)``, and the dual motion vector is ``x_O - x = -forward(y)``: the occluder's own motion. Where
the point itself was seen at ``y``, ``z = x`` and both vectors are equal.
"""

import torch
from torch import Tensor

# Share of the inverse depth by which an occluder has to be nearer: rounding, and surfaces that lie on each other.
_APART = 2e-3


def dual_motion(
    motion: Tensor, depth_then: Tensor, jitter: Tensor, forward: Tensor, depth_seen: Tensor, margin: int
) -> Tensor:
    """Dual motion vectors ``(B, 2, h, w)`` in pixels.

    A point counts as occluded where the previous frame shows, at the pixel nearest to ``y``, something nearer than the point
    was, by more than the point's surface slopes within half a pixel. Points that were out of the previous image, or behind its
    camera, have no occluder: their two vectors are equal.

    Args:
        motion: ``(B, 2, h, w)`` backward motion in pixels of the samples at pixel centre + ``jitter``.
        depth_then: ``(B, 1, h, w)`` view depth of each sample's point at the previous instant, metres; infinite for the sky.
        jitter: ``(B, 2)`` in pixels.
        forward: ``(B, 2, h + 2 margin, w + 2 margin)`` motion of what the previous frame showed to the current one, pixels.
        depth_seen: ``(B, 1, h + 2 margin, w + 2 margin)`` view depth of what the previous frame showed, metres; sky infinite.
        margin: pixels that the previous frame extends beyond the image on each side.
    """
    batch, _, height, width = motion.shape
    rows, columns = torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij")
    pixel = torch.stack((columns, rows)).to(motion)
    # The pixel that holds y: centres are at + 0.5, so the floor of the position is its index.
    place = torch.floor(pixel + 0.5 + jitter[..., None, None] + motion + margin)
    limit = torch.tensor((width, height), dtype=motion.dtype, device=motion.device)[:, None, None] + 2 * margin
    inside = ((place >= 0) & (place < limit)).all(dim=1, keepdim=True) & (depth_then > 0)
    x, y = torch.where(inside, place, 0.0).long().unbind(dim=1)
    index = (y * (width + 2 * margin) + x).flatten(1)[:, None]
    there = forward.flatten(2).gather(2, index.expand(batch, 2, -1)).view_as(motion)
    seen = depth_seen.flatten(2).gather(2, index).view_as(depth_then)
    # Inverse depth is linear over the image on a plane, and 0 for the sky.
    inverse = torch.where(inside, 1.0 / depth_then, 0.0)
    nearer = 1.0 / seen - inverse
    occluded = inside & (nearer > _slope(inverse) / 2.0 + _APART * inverse)
    return torch.where(occluded, -there, motion)


def _slope(values: Tensor) -> Tensor:
    """``|d/dx| + |d/dy|`` per pixel, of the two neighbours the one on the same surface: the smaller difference."""
    total = torch.zeros_like(values)
    for dim in (-1, -2):
        if values.shape[dim] < 2:
            continue
        step = values.diff(dim=dim).abs()
        first, last = step.narrow(dim, 0, 1), step.narrow(dim, step.shape[dim] - 1, 1)
        total = total + torch.minimum(torch.cat((first, step), dim), torch.cat((step, last), dim))
    return total
