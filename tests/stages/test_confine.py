import pytest
import torch

from supersampling.stages.confine import Clamp, Sigmoid, StraightThrough

X = torch.tensor([-0.5, -1e-3, 0.01, 0.3, 0.99, 1.2])


@pytest.mark.parametrize("option", [Clamp, StraightThrough])
def test_clamps_return_the_published_values_exactly(option):
    x = torch.randn(1000) * 2
    assert option()(x).tolist() == [min(max(v, 0.0), 1.0) for v in x.tolist()]


@pytest.mark.parametrize(
    ("option", "upstream", "expected"),
    [
        (Clamp, 1.0, [0.0, 0.0, 1.0, 1.0, 1.0, 0.0]),
        (Clamp, -1.0, [0.0, 0.0, -1.0, -1.0, -1.0, 0.0]),
        # A positive gradient lowers the value, which leads back inside only from above 1.
        (StraightThrough, 1.0, [0.0, 0.0, 1.0, 1.0, 1.0, 1.0]),
        (StraightThrough, -1.0, [-1.0, -1.0, -1.0, -1.0, -1.0, 0.0]),
    ],
)
def test_gradients_outside_the_interval(option, upstream, expected):
    x = X.clone().requires_grad_()
    option()(x).backward(torch.full_like(x, upstream))
    assert x.grad.tolist() == expected


def test_saturated_output_recovers_only_by_the_straight_through_gradient():
    finals = {}
    for option in (Clamp, StraightThrough):
        x = torch.tensor([-1.0], requires_grad=True)
        for _ in range(200):
            (gradient,) = torch.autograd.grad((option()(x) - 0.4).square().sum(), x)
            x = (x - 0.05 * gradient).detach().requires_grad_()
        finals[option] = option()(x).item()
    assert finals[Clamp] == 0.0
    assert finals[StraightThrough] == pytest.approx(0.4, abs=1e-3)


@pytest.mark.parametrize("option", [Clamp, StraightThrough, Sigmoid])
@pytest.mark.parametrize("value", [0.01, 0.15, 0.9])
def test_inverse_undoes_forward(option, value):
    assert option()(torch.tensor(option().inverse(value))).item() == pytest.approx(value, rel=1e-5)
