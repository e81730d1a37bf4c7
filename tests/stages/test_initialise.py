import copy

import pytest
import torch
from torch import nn

from supersampling.errors import UserError
from supersampling.stages.confine import Clamp, Sigmoid
from supersampling.stages.initialise import Balanced, Published


def layers():
    torch.manual_seed(0)
    return nn.Conv2d(8, 32, 4, stride=4), [nn.Conv2d(32, 32, 3, padding=1) for _ in range(4)]


def test_published_touches_nothing():
    first, lasts = layers()
    before = copy.deepcopy([first, *lasts])
    Published()(first, lasts, Clamp())
    for old, new in zip(before, [first, *lasts]):
        assert torch.equal(old.weight, new.weight)
        assert torch.equal(old.bias, new.bias)


@pytest.mark.parametrize("confine", [Clamp(), Sigmoid()])
def test_balanced_starts_at_its_values_for_zero_input(confine):
    first, lasts = layers()
    Balanced(blend=0.2, keep=0.8)(first, lasts, confine)
    dark = first(torch.zeros(1, 8, 8, 8))
    output = confine(dark + sum(last(torch.zeros(1, 32, 2, 2)) for last in lasts))
    torch.testing.assert_close(output[:, :16], torch.full((1, 16, 2, 2), 0.2))
    torch.testing.assert_close(output[:, 16:], torch.full((1, 16, 2, 2), 0.8))


@pytest.mark.parametrize("values", [{"blend": 0.0}, {"keep": 1.0}])
def test_saturated_start_raises(values):
    with pytest.raises(UserError, match="inside"):
        Balanced(**values)
