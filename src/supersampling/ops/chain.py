"""Motion over several frames."""

from collections.abc import Sequence

from torch import Tensor

from supersampling.ops.warp import warp


def chain(vectors: Tensor, earlier: Sequence[Tensor]) -> tuple[Tensor, ...]:
    """Vectors from the current frame to the 1st, 2nd, ... frame before it, each ``(B, V, h, w)`` in units of the image.

    ``V_1(x) = v(x)`` and ``V_k(x) = v(x) + E_{k-1}(x + m(x))``: what led from the previous frame on is read where the point was
    in that frame, not at ``x``.

    Args:
        vectors: ``v (B, V, h, w)`` to the previous frame; its first two channels are the motion ``m``.
        earlier: ``E_1, E_2, ...``, the previous frame's own results of this function, as many as are wanted.
    """
    motion = vectors[:, :2]
    return vectors, *(vectors + warp(to_there, motion) for to_there in earlier)
