"""What the methods keep that blend colours by weights in [0, 1]: bicubic, JAU, TUS and DLCTUS, with every option.

NSRR, NSRD and ENSS predict colours, which no weights of a network bind to those that they read.
"""

import pytest
import torch
from model_cases import VARIANTS, clip, model_of, run

RECURRENT = ("tus", "dlctus")
BLENDING = [v for v in VARIANTS if v[0] in ("bicubic", "bilinear", "jau", "jau_bicubic", *RECURRENT)]
every_blend = pytest.mark.parametrize("variant", BLENDING, ids=" ".join)


@every_blend
@torch.no_grad()
def test_a_flat_still_scene_stays_what_it_is(variant):
    """Whatever the weights: a blend of one colour with itself is that colour."""
    model = model_of(*variant, dtype=torch.float32)
    buffers = clip(model.requires, frames=8, motion=0.0, dtype=torch.float32)
    buffers["color"] = torch.tensor([0.2, 0.5, 0.8]).view(3, 1, 1).expand_as(buffers["color"])
    outputs, _ = run(model, buffers)
    torch.testing.assert_close(outputs, buffers["color"][:, :, :, :1, :1].expand_as(outputs))


@every_blend
def test_gradients_reach_the_first_frame_of_recurrent_methods(variant):
    model = model_of(*variant)
    buffers = clip(model.requires)
    buffers["color"].requires_grad_()
    run(model, buffers)[0][:, -1].mean().backward()
    assert buffers["color"].grad.isfinite().all()
    assert buffers["color"].grad[:, 0].any() == (variant[0] in RECURRENT)


@pytest.mark.parametrize("name", RECURRENT)
@torch.no_grad()
def test_a_still_scene_under_one_jitter_converges(name):
    model = model_of(name, dtype=torch.float32)
    one = clip(model.requires, frames=1, motion=0.0, dtype=torch.float32)
    buffers = {k: v.expand(-1, 60, *v.shape[2:]) for k, v in one.items()}
    change = run(model, buffers)[0].diff(dim=1).abs().amax((0, 2, 3, 4))
    assert change[-1] < 1e-4
    assert change[-1] <= change[0]


@pytest.mark.parametrize("variant", [("tus", "model.alpha=0.5"), ("dlctus",)], ids=" ".join)
@torch.no_grad()
def test_the_state_carries_what_earlier_frames_saw(variant):
    model = model_of(*variant)
    buffers = clip(model.requires)
    with_history = run(model, buffers)[0][:, 1]
    without = run(model, {k: v[:, 1:2] for k, v in buffers.items()})[0][:, 0]
    assert (with_history - without).abs().max() > 0.01


def test_the_command_line_reaches_into_a_stage():
    overrides = ("task.scale=3", "model/reproject=bicubic5", "model.reproject.a=-0.5", "model/accumulate=none")
    model = model_of("dlctus", *overrides)
    assert model.scale == 3
    assert model.reproject.a == -0.5
    assert model.accumulate.channels == 3
