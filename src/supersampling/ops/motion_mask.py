"""Mask of unreliable motion vectors (Li et al. 2024, NSRD, section 3.2)."""

from torch import Tensor

# The published threshold. The paper gives no unit; the official code uses low-resolution pixels.
THRESHOLD = 0.1


def motion_mask(offset: Tensor, low: tuple[int, int], threshold: float = THRESHOLD) -> Tensor:
    """Return the motion mask ``(B, 1, H, W)``: 1 where the point was hidden in the previous frame, else 0; no gradient.

    "Subtract DMV with TMV and perform a binarization, which sets the pixel as 0 when its value is smaller than a
    threshold": smaller on both axes, so that a large offset on one axis is enough to mark a pixel.

    Args:
        offset: ``motion_dual - motion (B, 2, H, W)``, in units of the image. The loss's mask (equation 7) upsamples
            both vectors bilinearly, which equals upsampling their difference.
        low: ``(h, w)`` of the low-resolution image.
        threshold: low-resolution pixels, positive.
    """
    height, width = low
    x, y = (offset.abs() * scale < threshold for offset, scale in zip(offset.split(1, dim=1), (width, height)))
    return (~(x & y)).to(offset.dtype)
