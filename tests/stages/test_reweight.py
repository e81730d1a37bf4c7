import pytest
import torch
import torch.nn.functional as F

from supersampling.errors import UserError
from supersampling.stages.reweight import LearnedWeights, NoReweighting


@torch.no_grad()
def test_each_channel_is_multiplied_by_the_weight_of_its_frame():
    """Section 3.2.3, pixel by pixel, from colour and depth only."""
    torch.manual_seed(0)
    stage = LearnedWeights(2, width=5).double()
    current, past = torch.rand(1, 7, 4, 5).double(), torch.rand(1, 2, 7, 4, 5).double()
    rgbd = torch.cat((current[:, :4], past[:, 0, :4], past[:, 1, :4]), 1)
    first, second, third = stage.network[::2]
    x = F.conv2d(rgbd, first.weight, first.bias, padding=1).clamp_min(0)
    x = F.conv2d(x, second.weight, second.bias, padding=1).clamp_min(0)
    x = F.conv2d(x, third.weight, third.bias, padding=1)[0]
    out = stage(current, past)
    for k in range(2):
        for i in range(4):
            for j in range(5):
                e = torch.exp(-2.0 * x[k, i, j])
                weight = 10.0 / (1.0 + e)  # 5 (tanh x + 1)
                torch.testing.assert_close(out[0, k, :, i, j], past[0, k, :, i, j] * weight, rtol=1e-12, atol=0)
    assert torch.equal(stage(torch.cat((current[:, :4], torch.rand(1, 3, 4, 5)), 1), past), out)


@pytest.mark.parametrize(("bias", "weight"), [(50.0, 10.0), (-50.0, 0.0), (0.0, 5.0)])
@torch.no_grad()
def test_weights_reach_from_zero_to_ten(bias, weight):
    stage = LearnedWeights(3)
    stage.network[4].weight.zero_()
    stage.network[4].bias.fill_(bias)
    past = torch.rand(2, 3, 12, 4, 4)
    torch.testing.assert_close(stage(torch.rand(2, 12, 4, 4), past), past * weight)


@pytest.mark.parametrize(("previous", "parameters"), [(1, 11_873), (2, 13_314), (4, 16_196)])
def test_published_widths(previous, parameters):
    stage = LearnedWeights(previous)
    assert [(c.in_channels, c.out_channels) for c in stage.network[::2]] == [
        (4 * (previous + 1), 32),
        (32, 32),
        (32, previous),
    ]
    assert sum(p.numel() for p in stage.parameters()) == parameters


def test_gradients():
    torch.manual_seed(1)
    stage = LearnedWeights(2, width=3).double()
    inputs = (torch.rand(1, 5, 2, 3).double().requires_grad_(), torch.rand(1, 2, 5, 2, 3).double().requires_grad_())
    assert torch.autograd.gradcheck(stage, inputs)


def test_none_returns_the_frames_and_has_no_parameters():
    stage, past = NoReweighting(2), torch.rand(1, 2, 12, 3, 3)
    assert stage(torch.rand(1, 12, 3, 3), past) is past
    assert not list(stage.parameters())


def test_limit_of_zero_raises():
    with pytest.raises(UserError, match=r"Invalid model\.reweight\.limit=0: use a positive number"):
        LearnedWeights(2, limit=0)
