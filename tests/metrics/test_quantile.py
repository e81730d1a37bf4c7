import numpy as np
import pytest
import torch

from supersampling.metrics.base import Moment
from supersampling.metrics.quantile import ErrorQuantile


def test_equals_numpy():
    torch.manual_seed(0)
    output, target = torch.rand(2, 1, 3, 20, 30)
    expected = np.quantile((output - target).abs().numpy(), 0.95, method="inverted_cdf")
    assert ErrorQuantile()(Moment(output=output, target=target)) == {"error_q95": pytest.approx(expected)}


def test_equal_images_have_none():
    image = torch.rand(1, 3, 4, 4)
    assert ErrorQuantile()(Moment(output=image, target=image)) == {"error_q95": 0.0}
