import pytest
import torch

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.blend_net import BlendNet
from supersampling.ops.resample import jitter_aligned_upsample


def test_a_constant_share_averages_still_frames():
    torch.manual_seed(0)
    model = BlendNet(scale=2, width=4).double()
    model.share[2].weight.data.zero_()
    model.share[2].bias.data.zero_()  # a share of one half
    first, second = torch.rand(2, 1, 3, 5, 6, dtype=torch.float64)
    jitter = torch.full((1, 2), 0.2, dtype=torch.float64)
    motion = torch.zeros(1, 2, 5, 6, dtype=torch.float64)
    _, state = model(Frame(color=first, jitter=jitter, motion=motion), None)
    output, _ = model(Frame(color=second, jitter=jitter, motion=motion), state)
    torch.testing.assert_close(output, jitter_aligned_upsample((first + second) / 2, jitter, 2))


def test_number_of_parameters():
    assert sum(p.numel() for p in BlendNet(scale=4, width=8).parameters()) == (6 * 9 + 1) * 8 + 8 * 9 + 1


def test_no_channels_raise():
    with pytest.raises(UserError, match="width"):
        BlendNet(scale=2, width=0)
