import pytest
import torch
from torch import nn

from supersampling.training.optimizers import muon


def test_a_first_step_is_equally_long_in_every_direction_and_leads_downhill():
    torch.manual_seed(0)
    conv = nn.Conv2d(6, 8, 3)
    before = [p.detach().clone() for p in conv.parameters()]
    # A gradient whose singular values span three orders of magnitude.
    u, _, v = torch.linalg.svd(torch.randn(8, 54), full_matrices=False)
    gradient = (u * torch.logspace(0, -3, 8)) @ v
    conv.weight.grad, conv.bias.grad = gradient.view_as(conv.weight).clone(), torch.randn(8)
    muon(conv.parameters(), lr=0.01).step()

    weight_step, bias_step = (p.detach() - b for p, b in zip(conv.parameters(), before))
    length = torch.diag(u.T @ -weight_step.flatten(1) @ v.T) / (0.01 * 0.2 * 54**0.5)
    assert length[:6].min() > 0.5  # Newton-Schulz brings all but the smallest singular values near 1
    assert length.max() < 1.3
    torch.testing.assert_close(bias_step, -0.01 * conv.bias.grad.sign(), rtol=1e-4, atol=1e-7)


@pytest.mark.parametrize("shape", [(3,), (4, 5)])
def test_a_model_of_one_kind_of_parameter_trains(shape):
    parameter = nn.Parameter(torch.ones(shape))
    optimizer = muon([parameter], lr=0.1)
    parameter.square().sum().backward()
    optimizer.step()
    assert parameter.square().sum() < parameter.numel()
