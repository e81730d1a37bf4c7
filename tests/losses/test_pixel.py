import numpy as np
import pytest
import torch

from supersampling.errors import UserError
from supersampling.losses import L1, MSE, SmoothL1


def pair():
    rng = np.random.default_rng(0)
    return rng.normal(size=(2, 2, 3, 4, 5)) * 2.0, rng.normal(size=(2, 2, 3, 4, 5))


def smooth(d, beta):
    return d * d / (2.0 * beta) if abs(d) < beta else abs(d) - beta / 2.0


@pytest.mark.parametrize(
    ("loss", "expected_loss"),
    [
        (L1(), abs),
        (MSE(), lambda d: d * d),
        (SmoothL1(1.0), lambda d: smooth(d, 1.0)),
        (SmoothL1(0.2), lambda d: smooth(d, 0.2)),
    ],
    ids=["l1", "mse", "smooth_l1", "smooth_l1 0.2"],
)
def test_loss_is_the_mean_over_values(loss, expected_loss):
    x, y = pair()
    expected = np.mean([expected_loss(a - b) for a, b in zip(x.ravel(), y.ravel())])
    assert loss(torch.from_numpy(x), torch.from_numpy(y), {}).item() == pytest.approx(expected, rel=1e-12)
    assert (loss.requires, loss.previous) == (frozenset(), 0)


@pytest.mark.parametrize("beta", [0.0, -1.0, float("nan"), float("inf")])
def test_beta_out_of_range_is_rejected(beta):
    with pytest.raises(UserError, match=f"Invalid beta={beta}"):
        SmoothL1(beta)
