"""Where motion vectors cannot be trusted (Li et al. 2024, NSRD, section 3.2)."""

from torch import Tensor

THRESHOLD = 0.1
"""The published one. The paper gives no unit; the official code has low-resolution pixels."""


def motion_mask(offset: Tensor, low: tuple[int, int], threshold: float = THRESHOLD) -> Tensor:
    """The motion mask ``(B, 1, H, W)``: 1 where the point was hidden in the previous frame, else 0; no gradient.

    "Subtract DMV with TMV and perform a binarization, which sets the pixel as 0 when its value is smaller than a threshold":
    on both axes, so that one axis is enough to distrust a pixel.

    Args:
        offset: ``motion_dual - motion (B, 2, H, W)``, in units of the image. The loss's mask (equation 7) has both vectors
            upsampled bilinearly, which is their difference upsampled.
        low: ``(h, w)`` of the low-resolution image, whose pixels ``threshold`` counts.
        threshold: low-resolution pixels, above 0.
    """
    height, width = low
    x, y = (offset.abs() * scale < threshold for offset, scale in zip(offset.split(1, dim=1), (width, height)))
    return (~(x & y)).to(offset.dtype)
