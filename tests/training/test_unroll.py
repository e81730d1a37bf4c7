"""Unrolling equals the loop that runs the whole model on every frame, without that loop's wasted networks."""

import pytest
import torch
from torch.utils._pytree import tree_leaves

from supersampling.frames import Frame
from supersampling.models.dlctus import DLCTUS
from supersampling.models.nsrr import NSRR
from supersampling.stages.accumulate import AccumulationBuffer
from supersampling.stages.base import NoBase
from supersampling.stages.colour_space import YCbCr
from supersampling.stages.confine import StraightThrough
from supersampling.stages.demodulate import DisplayColour
from supersampling.stages.dilate import NoDilation
from supersampling.stages.extract import LearnedFeatures
from supersampling.stages.guides import NoGuides
from supersampling.stages.initialise import Published
from supersampling.stages.pad import JitterAligned
from supersampling.stages.reproject import Bicubic9
from supersampling.stages.reweight import LearnedWeights
from supersampling.stages.upsample import ZeroUpsampling
from supersampling.stages.warp_at import LowResolution, TargetResolution
from supersampling.training.module import unroll

FRAMES = 6


def nsrr(previous, warp_at):
    stages = ZeroUpsampling(), warp_at(), LearnedWeights, YCbCr(), DisplayColour(), NoGuides(), NoBase()
    return NSRR(2, previous, 8, LearnedFeatures, *stages)


def dlctus():
    stages = Bicubic9(), NoDilation(), JitterAligned(), AccumulationBuffer(), StraightThrough(), Published()
    return DLCTUS(2, *stages)


MODELS = {
    "nsrr": lambda: nsrr(2, TargetResolution),
    "nsrr at low resolution": lambda: nsrr(2, LowResolution),
    "nsrr of long memory": lambda: nsrr(4, TargetResolution),
    "nsrr of one frame": lambda: nsrr(0, TargetResolution),
    "dlctus": dlctus,
}


@pytest.fixture(params=MODELS)
def model(request):
    torch.manual_seed(0)
    return MODELS[request.param]()


@pytest.fixture
def clip():
    g = torch.Generator().manual_seed(1)
    return {
        "color": torch.rand(2, FRAMES, 3, 4, 6, generator=g),
        "depth": torch.rand(2, FRAMES, 1, 4, 6, generator=g),
        "motion": torch.randn(2, FRAMES, 2, 4, 6, generator=g) * 0.05,
        "jitter": torch.rand(2, FRAMES, 2, generator=g) - 0.5,
        "target": torch.rand(2, 2, 3, 8, 12, generator=g),  # of the last frames alone, as a training has it
    }


def plain_loop(model, clip, keep):
    outputs, state = [], None
    for t in range(FRAMES):
        output, state = model(Frame(**{n: clip[n][:, t] for n in ("color", "depth", "motion", "jitter")}), state)
        outputs.append(output)
    return torch.stack(outputs[FRAMES - keep :], dim=1)


def gradients(model, clip, loop, keep):
    """Outputs, the gradient of each weight, and that of the colours."""
    color = clip["color"].clone().requires_grad_()
    model.zero_grad()
    outputs = loop(model, {**clip, "color": color}, keep)
    outputs.square().mean().backward()
    return outputs.detach(), {n: p.grad for n, p in model.named_parameters()}, color.grad


@pytest.mark.parametrize("keep", [1, 2, FRAMES])
def test_outputs_and_gradients_are_those_of_the_plain_loop(model, clip, keep):
    outputs, weights, color = gradients(model, clip, unroll, keep)
    expected, expected_weights, expected_color = gradients(model, clip, plain_loop, keep)
    assert outputs.shape == (2, keep, 3, 8, 12)
    assert torch.equal(outputs, expected)
    for name, gradient in expected_weights.items():
        assert gradient is not None
        torch.testing.assert_close(weights[name], gradient, rtol=1e-5, atol=1e-7)
    torch.testing.assert_close(color, expected_color, rtol=1e-5, atol=1e-8)


@pytest.mark.parametrize("name", [name for name in MODELS if name.startswith("nsrr")])
@torch.no_grad()
def test_outputs_are_those_of_the_plain_loop_in_half_precision(name, clip):
    model = MODELS[name]()
    with torch.autocast("cpu", torch.bfloat16):
        assert torch.equal(unroll(model, clip, 2), plain_loop(model, clip, 2))


@torch.no_grad()
def test_the_state_of_a_step_is_the_same_without_its_output(model, clip):
    state = None
    for t in range(FRAMES):
        frame = Frame.from_clip(clip, t)
        alone, (_, state) = model.advance(frame, state), model(frame, state)
        a, b = tree_leaves(alone), tree_leaves(state)
        assert len(a) == len(b)
        assert all(torch.equal(x, y) for x, y in zip(a, b))


def calls_of(module):
    calls = []
    module.register_forward_hook(lambda *_: calls.append(1))
    return calls


@pytest.mark.parametrize("keep", [1, 2, FRAMES])
def test_the_networks_of_outputs_run_for_kept_frames_alone(clip, keep):
    model = nsrr(2, TargetResolution)
    to_outputs = [model.reconstruct, model.extract, model.previous_frames.reweight]
    calls = [calls_of(module) for module in to_outputs]
    into_the_state = calls_of(model.previous_frames.extract)
    unroll(model, clip, keep)
    assert [len(c) for c in calls] == [keep] * 3
    assert len(into_the_state) == FRAMES


def test_a_method_whose_state_is_its_output_runs_whole_on_every_frame_hooks_and_all(clip):
    model = dlctus()
    calls = calls_of(model)
    unroll(model, clip, 2)
    assert len(calls) == FRAMES
