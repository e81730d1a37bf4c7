"""Accumulation of motion over several frames."""

from collections.abc import Sequence

from torch import Tensor

from supersampling.ops.warp import warp


def chain(vectors: Tensor, earlier: Sequence[Tensor]) -> tuple[Tensor, ...]:
    """Return vectors to the 1st, 2nd, ... frame before the current one, each ``(B, V, h, w)`` in units of the image.

    ``V_1(x) = v(x)`` and ``V_k(x) = v(x) + E_{k-1}(x + m(x))``: the previous frame's vectors are read at the position
    that the point had in that frame, not at ``x``.

    Args:
        vectors: ``v (B, V, h, w)`` to the previous frame; its first two channels are the motion ``m``.
        earlier: ``E_1, E_2, ...``, the results of this function for the previous frame; any number of them.
    """
    motion = vectors[:, :2]
    return vectors, *(vectors + warp(previous, motion) for previous in earlier)
