from functools import partial
from pathlib import Path

import pytest
import torch
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.utils import instantiate

from supersampling.errors import UserError
from supersampling.losses import L1, MSE, SSIM, Loss, MaskedTemporal, SmoothL1, SpatioTemporal, Sum

ROOT = Path(__file__).resolve().parents[2]
NAMES = sorted(p.stem for p in (ROOT / "conf" / "loss").glob("*.yaml"))


def clip(b=2, frames=3, h=6, w=7, scale=2):
    torch.manual_seed(0)
    outputs, targets = torch.rand(2, b, frames, 3, h * scale, w * scale)
    buffers = {name: 0.1 * torch.randn(b, frames, 2, h, w) for name in ("motion", "motion_dual")}
    return outputs, targets, buffers


def failing():
    raise AssertionError("a term of weight 0 was constructed")


def compose_config(*overrides):
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):
        return compose("train", ["scene=atrium", *overrides])


def test_terms_receive_the_counted_frames_and_their_weights():
    outputs, targets, frames = clip()
    loss = Sum(
        {"l1": L1, "moving": partial(SpatioTemporal, 0.3), "mse": MSE, "disabled": failing},
        {"l1": 2, "moving": 0.5, "mse": 0.25, "disabled": 0},
    )
    assert (loss.requires, loss.previous) == ({"motion"}, 1)
    # One frame of look-back: 2 of 3 frames are counted, and terms without look-back receive only these.
    parts = {
        "l1": 2.0 * L1()(outputs[:, 1:], targets[:, 1:], {}),
        "moving": 0.5 * SpatioTemporal(0.3)(outputs, targets, frames),
        "mse": 0.25 * MSE()(outputs[:, 1:], targets[:, 1:], {}),
    }
    expected = {name: value.item() for name, value in parts.items()}
    values = {name: value.item() for name, value in loss.terms(outputs, targets, frames).items()}
    assert values == pytest.approx(expected)
    assert loss(outputs, targets, frames).item() == pytest.approx(sum(expected.values()))


class MeanMotion(Loss):
    """Loss that reads the motion of the counted frames, without look-back."""

    requires = frozenset({"motion"})
    previous = 0

    def forward(self, outputs, targets, frames):
        assert outputs.shape[1] == targets.shape[1] == frames["motion"].shape[1]
        return frames["motion"].mean()


def test_buffers_cover_the_frames_of_the_term():
    outputs, targets, frames = clip()
    loss = Sum({"moving": partial(SpatioTemporal, 0.3), "mean": MeanMotion}, {"moving": 1, "mean": 1})
    value = loss.terms(outputs, targets, frames)["mean"]
    assert value.item() == pytest.approx(frames["motion"][:, 1:].mean().item())


def test_nested_sum_keeps_its_look_back():
    outputs, targets, frames = clip()
    inner = Sum({"moving": partial(SpatioTemporal, 0.3)}, {"moving": 3.0})
    outer = Sum({"inner": lambda: inner, "l1": L1}, {"inner": 2.0, "l1": 0})
    assert (outer.requires, outer.previous) == ({"motion"}, 1)
    expected = 6.0 * SpatioTemporal(0.3)(outputs, targets, frames)
    assert outer(outputs, targets, frames).item() == pytest.approx(expected.item())


@pytest.mark.parametrize(
    ("weights", "part"),
    [
        ({"l1": -1.0}, "loss.weights.l1=-1"),
        ({"l1": float("nan")}, "loss.weights.l1=nan"),
        ({"l1": float("inf")}, "loss.weights.l1=inf"),
        ({"l2": 1.0}, "loss.weights.l2"),
        ({"l1": 0.0}, "All loss.weights are 0"),
        ({"l1": "much"}, "loss.weights.l1=much"),
        ({"l1": None}, "loss.weights.l1=None"),
    ],
)
def test_invalid_weights_are_rejected(weights, part):
    with pytest.raises(UserError, match=part):
        Sum({"l1": L1}, weights)


def test_configuration_nsrd_equals_the_papers_sum():
    """The configuration equals Li et al. 2024, equation 6."""
    outputs, targets, frames = clip()
    loss = instantiate(compose_config("loss=nsrd").loss)
    assert (loss.requires, loss.previous) == ({"motion", "motion_dual"}, 1)
    counted = outputs[:, 1:], targets[:, 1:], {}
    expected = SmoothL1(1.0)(*counted) + SSIM(1.0)(*counted) + MaskedTemporal(0.1, 1.0)(outputs, targets, frames)
    assert loss(outputs, targets, frames).item() == pytest.approx(expected.item())
    without = instantiate(compose_config("loss=nsrd", "loss.weights.masked_temporal=0").loss)
    assert (without.requires, without.previous) == (frozenset(), 0)


def test_weights_of_nsrr(vgg):
    loss = instantiate(compose_config("loss=nsrr").loss)
    assert loss.weights == {"ssim": 1.0, "perceptual": 0.1}
    assert loss.previous == 0
    assert instantiate(compose_config("loss=nsrr", "loss.weights.perceptual=0").loss).weights == {"ssim": 1.0}


def test_sum_from_the_command_line():
    weights = ("loss.weights.l1=0.5", "loss.weights.spatiotemporal=2")
    loss = instantiate(compose_config("loss=sum", *weights, "loss.terms.spatiotemporal.theta=0.7").loss)
    outputs, targets, frames = clip()
    expected = 0.5 * L1()(outputs[:, 1:], targets[:, 1:], {}) + 2.0 * SpatioTemporal(0.7)(outputs, targets, frames)
    assert loss(outputs, targets, frames).item() == pytest.approx(expected.item())


def test_custom_term_needs_no_file():
    term = "{_target_:supersampling.losses.SmoothL1,_partial_:true,beta:0.1}"
    loss = instantiate(compose_config("loss=sum", f"+loss.terms.custom={term}", "+loss.weights.custom=1").loss)
    outputs, targets, _ = clip()
    assert loss(outputs, targets, {}).item() == pytest.approx(SmoothL1(0.1)(outputs, targets, {}).item())


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("brightness", [1.0, 1e4], ids=["display", "light"])
def test_losses_have_finite_gradients_for_perfect_outputs(vgg, name, brightness):
    loss = instantiate(compose_config(f"loss={name}", *(["loss.weights.l1=1"] if name == "sum" else [])).loss)
    torch.manual_seed(0)
    targets = brightness * torch.rand(1, 2 + loss.previous, 3, 16, 24)
    frames = {buffer: 0.1 * torch.randn(1, 2 + loss.previous, 2, 4, 6) for buffer in loss.requires}
    for outputs in (targets.clone(), targets + 0.1 * brightness * torch.randn_like(targets)):
        outputs.requires_grad_()
        value = loss(outputs, targets, frames)
        value.backward()
        assert value.isfinite()
        assert outputs.grad.isfinite().all()
        terms = loss.terms(outputs, targets, frames)
        assert sum(terms.values()).item() == pytest.approx(value.item())


@pytest.mark.parametrize("name", NAMES)
def test_half_precision_outputs_give_a_loss_in_single_precision(vgg, name):
    """Outputs are in half precision with `trainer.precision=bf16-mixed`."""
    loss = instantiate(compose_config(f"loss={name}", *(["loss.weights.l1=1"] if name == "sum" else [])).loss)
    torch.manual_seed(0)
    targets = torch.rand(1, 2, 3, 16, 24)
    outputs = (targets + 0.2 * torch.randn_like(targets)).bfloat16().requires_grad_()
    frames = {buffer: 0.1 * torch.randn(1, 2, 2, 4, 6) for buffer in loss.requires}
    exact = loss(outputs.detach().float(), targets, frames)
    with torch.autocast("cpu", torch.bfloat16):
        value = loss(outputs, targets, frames)
    value.backward()
    assert value.dtype == torch.float32
    assert outputs.grad.isfinite().all()
    assert value.item() == pytest.approx(exact.item(), rel=0.02)
