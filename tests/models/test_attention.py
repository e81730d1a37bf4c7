import pytest
import torch
import torch.nn.functional as F

from supersampling.models.blocks.attention import ChannelAttention, ResidualAttention, UShaped, double, halve
from supersampling.models.blocks.gated import GatedConvolution


def numbers(*shape):
    return torch.randn(*shape, dtype=torch.float64)


def test_channel_attention_is_a_small_network_on_the_means():
    torch.manual_seed(0)
    attention, x = ChannelAttention(32).double(), numbers(2, 32, 3, 4)
    out = attention(x)
    for n in range(2):
        mean = torch.stack([x[n, c].sum() / 12 for c in range(32)])
        inner = (attention.squeeze.weight[:, :, 0, 0] @ mean + attention.squeeze.bias).clamp_min(0.0)
        factor = 1 / (1 + torch.exp(-(attention.excite.weight[:, :, 0, 0] @ inner + attention.excite.bias)))
        for c in range(32):
            torch.testing.assert_close(out[n, c], x[n, c] * factor[c])


def test_a_residual_block_adds_to_its_input():
    torch.manual_seed(0)
    block, x = ResidualAttention(16).double(), numbers(2, 16, 5, 4)
    inner = F.conv2d(x, block.first.weight, block.first.bias, padding=1).clamp_min(0.0)
    inner = F.conv2d(inner, block.second.weight, block.second.bias, padding=1)
    torch.testing.assert_close(block(x), x + block.attention(inner))
    assert sum(p.numel() for p in ResidualAttention(64).parameters()) == 2 * (64 * 64 * 9 + 64) + 2 * 64 * 4 + 4 + 64


def test_gated_convolution_is_equation_5():
    torch.manual_seed(0)
    gated, x = GatedConvolution(3, 4).double(), numbers(2, 3, 5, 6)
    both = F.conv2d(F.pad(x, (1, 1, 1, 1)), gated.both.weight, gated.both.bias)
    features, gate = both[:, :4], both[:, 4:]
    expected = torch.where(features > 0, features, 0.2 * features) / (1 + torch.exp(-gate))
    torch.testing.assert_close(gated(x), expected)


@pytest.mark.parametrize("block", [ChannelAttention(16), ResidualAttention(16), GatedConvolution(16, 2)])
def test_gradients(block):
    torch.manual_seed(0)
    assert torch.autograd.gradcheck(block.double(), numbers(1, 16, 2, 3).requires_grad_())


@pytest.mark.parametrize(("h", "w"), [(1, 1), (1, 7), (2, 3), (3, 2), (5, 6), (8, 8)])
def test_u_shape_accepts_any_size(h, w):
    torch.manual_seed(0)
    with torch.no_grad():
        out = UShaped(16)(torch.rand(2, 16, h, w))
    assert out.shape == (2, 16, h, w)
    assert out.isfinite().all()


def test_pooling_and_upsampling_share_pixel_edges():
    """A block of two pixels covers its half-resolution pixel: a ramp is restored as a ramp, half a step higher."""
    ramp = torch.arange(11.0).view(1, 1, 1, 11)
    small = halve(ramp)
    assert small.flatten().tolist() == [1.0, 3.0, 5.0, 7.0, 9.0]
    back = double(small, ramp).flatten()
    # Between the outermost half-resolution centres; the maximum of each pair is half a step above its mean.
    assert back[1:9].tolist() == (ramp.flatten()[1:9] + 0.5).tolist()
    assert back[[0, 9, 10]].tolist() == [1.0, 9.0, 9.0]
