import pytest
import torch

from supersampling.ops.chain import chain


def field(matrix, shift, h, w):
    """Return ``A p + t`` and pixel centres ``p`` of the unit square: bilinear interpolation is exact between them."""
    x, y = (torch.arange(w) + 0.5).double() / w, (torch.arange(h) + 0.5).double() / h
    p = torch.stack((x.expand(h, w), y[:, None].expand(h, w)))
    return torch.einsum("ij,jhw->ihw", matrix, p) + shift.view(2, 1, 1), p


def test_affine_motions_compose():
    torch.manual_seed(0)
    h, w = 12, 16
    steps = [(torch.randn(2, 2).double() * 0.02, torch.randn(2).double() * 0.02) for _ in range(3)]
    chained = ()
    for matrix, shift in steps:
        chained = chain(field(matrix, shift, h, w)[0][None], chained)
    _, start = field(*steps[0], h, w)
    position = start
    for k, (matrix, shift) in enumerate(reversed(steps)):
        position = position + torch.einsum("ij,jhw->ihw", matrix, position) + shift.view(2, 1, 1)
        # Points that stay inside the image.
        inner = (..., slice(2, -2), slice(2, -2))
        torch.testing.assert_close((start + chained[k][0])[inner], position[inner], rtol=0, atol=1e-12)


def test_vector_is_read_at_the_previous_position():
    """Pixel 2 came from pixel 4, which came from pixel 3; at pixel 2 itself the earlier motion differs."""
    motion, earlier = torch.zeros(1, 4, 1, 8), torch.zeros(1, 4, 1, 8)
    motion[0, 0, 0, 2] = 2 / 8
    earlier[0, :, 0, 4] = torch.tensor([-1 / 8, 0.0, 0.5, 0.25])
    earlier[0, :, 0, 2] = 7.0
    first, second = chain(motion, [earlier])
    assert torch.equal(first, motion)
    torch.testing.assert_close(second[0, :, 0, 2], torch.tensor([1 / 8, 0.0, 0.5, 0.25]))


@pytest.mark.parametrize("count", [0, 1, 3])
def test_earlier_vectors_are_unchanged_without_motion(count):
    still, earlier = torch.zeros(2, 2, 4, 5), tuple(torch.rand(count, 2, 2, 4, 5))
    assert all(torch.equal(a, b) for a, b in zip(chain(still, earlier), (still, *earlier), strict=True))
