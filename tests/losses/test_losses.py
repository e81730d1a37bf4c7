import pytest
import torch

from supersampling.errors import UserError
from supersampling.losses import L1, SpatioTemporal


def clip(b=2, frames=3, h=3, w=4, scale=2):
    torch.manual_seed(0)
    outputs, targets = torch.rand(2, b, frames, 3, h * scale, w * scale, dtype=torch.float64)
    motion = torch.randn(b, frames, 2, h, w, dtype=torch.float64) * 0.2
    return outputs, targets, motion


def test_l1_is_the_mean_absolute_error():
    outputs, targets, _ = clip()
    expected = sum(abs(a - b) for a, b in zip(outputs.flatten().tolist(), targets.flatten().tolist()))
    assert L1()(outputs, targets, {}).item() == pytest.approx(expected / outputs.numel())
    assert (L1.requires, L1.previous) == (set(), 0)


@pytest.mark.parametrize("theta", [0.0, 0.1, 0.5, 1.0])
def test_spatiotemporal_is_equation_54_on_separately_warped_images(theta):
    outputs, targets, motion = clip()
    b, frames, _, height, width = outputs.shape
    total = 0.0
    identity = torch.tensor([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], dtype=torch.float64).expand(b, 2, 3)
    grid = torch.nn.functional.affine_grid(identity, [b, 3, height, width], align_corners=False)
    for t in range(1, frames):
        fine = torch.nn.functional.interpolate(motion[:, t], scale_factor=2, mode="bilinear")
        positions = grid + 2.0 * fine.permute(0, 2, 3, 1)
        previous = [
            torch.nn.functional.grid_sample(x[:, t - 1], positions, padding_mode="border", align_corners=False)
            for x in (outputs, targets)
        ]
        x, y = outputs[:, t] - targets[:, t], previous[0] - previous[1]
        total += (x.abs() + y.abs() + theta * ((x - y).abs() - x.abs() - y.abs())).mean().item()
    loss = SpatioTemporal(theta)
    assert loss(outputs, targets, {"motion": motion}).item() == pytest.approx(total / (frames - 1), rel=1e-9)
    assert (loss.requires, loss.previous) == ({"motion"}, 1)


def test_constant_error_is_spatial_but_not_temporal():
    _, targets, motion = clip()
    still = torch.zeros_like(motion)
    assert SpatioTemporal(1.0)(targets + 0.1, targets, {"motion": still}).item() == pytest.approx(0.0, abs=1e-12)
    assert SpatioTemporal(0.0)(targets + 0.1, targets, {"motion": still}).item() == pytest.approx(0.2)


def test_gradient_reaches_the_previous_frame():
    outputs, targets, motion = clip()
    outputs.requires_grad_()
    SpatioTemporal(0.5)(outputs, targets, {"motion": motion}).backward()
    assert outputs.grad.isfinite().all()
    assert outputs.grad[:, 0].abs().max() > 0


@pytest.mark.parametrize("theta", [-0.1, 1.01, float("nan")])
def test_theta_out_of_range_is_rejected(theta):
    with pytest.raises(UserError, match=f"Invalid loss.theta={theta}"):
        SpatioTemporal(theta)
