"""Every option of every stage against finite differences in float64: inputs that carry a gradient, and parameters.

How a slot is called stands in `CALLS`; its options are found in conf/model. A slot that is not there is checked inside
its model alone, as all models are.
"""

import pytest
import torch
from hydra.utils import instantiate
from model_cases import FAMILIES, SLOTS, clip, config_of, model_of, stems
from torch import nn
from torch.autograd import gradcheck
from torch.func import functional_call

from supersampling.frames import Frame
from supersampling.stages.upsample import ZeroUpsampling

H, W, SCALE = 3, 4, 2
OPTIONS = sorted({(slot, option) for slots in SLOTS.values() for slot in slots for option in stems(f"model/{slot}")})
ONCE, CONSTANT = ("it acts once, before training", "estimated flow is a constant to training, which is tested below")
NOT_DIFFERENTIABLE = {
    **{("initialise", option): ONCE for option in stems("model/initialise")},
    ("flow", "tvl1"): CONSTANT,
    ("flow", "raft"): CONSTANT,
    ("flow", "none"): "it gives no flow",
}
# What a model chooses that makes its stage.
MADE = {
    "extract": {"inputs": 4},
    "reweight": {"previous": 2},
    "recur": {"channels": 2, "width": 3, "scale": SCALE},
    "kernel_prediction": {"first": torch.ones(4, 5, 3, 3), "last": torch.ones(6, 4, 3, 3)},
}


def stage_of(slot, option):
    family = next(name for name, slots in SLOTS.items() if slot in slots)
    stage = instantiate(config_of(family, f"model/{slot}={option}").model[slot])
    if slot in MADE:
        stage = stage(**MADE[slot])
    if isinstance(stage, nn.Module):
        stage.double()
        for p in stage.parameters():  # some begin at 0, where a gradient can hide
            p.data.add_(0.1 * torch.randn_like(p))
    return stage


def numbers(channels, scale=1, low=-1.0, high=1.0):
    x = torch.rand(1, channels, scale * H, scale * W, dtype=torch.float64)
    return (low + (high - low) * x).requires_grad_()


def color(channels=3, scale=1):
    """Inside (0, 1), where clamps have a derivative; beyond, the straight-through one has a gradient of its own, tested
    there."""
    return numbers(channels, scale, 0.05, 0.95)


def vectors(channels=2, scale=1):
    """Motion of up to a pixel."""
    return numbers(channels, scale, -0.25, 0.25)


JITTER = torch.tensor([[0.2, -0.3]], dtype=torch.float64)
torch.manual_seed(0)
DEPTH, MOTION, VECTORS = color(1).detach(), vectors(2, SCALE).detach(), vectors(4).detach()


def frame(stage, **given):
    others = clip(stage.requires | {"jitter"}, frames=1, b=1, h=H, w=W)
    return Frame(**({name: values[:, 0] for name, values in others.items()} | given))


def through_the_window(stage, features, motion):
    """A frame that enters, is warped to the next one, and leaves to the target resolution."""
    upsample = ZeroUpsampling()
    window = stage.enter(features, JITTER, SCALE, upsample)
    return stage.leave(stage(stage.keep(window, JITTER), motion, -JITTER), -JITTER, SCALE, upsample)


def step(stage, shallow, motion, *carried):
    features, memory = stage(shallow, motion, carried)
    return features, *memory


def light(stage):
    """What a frame's colour becomes, brighter than its emission, and what is displayed of an output."""
    name = "color" if "color" in stage.requires else "radiance"
    return [
        (lambda x: stage(frame(stage, **{name: x})), [numbers(3, 1, 0.6, 1.0)]),
        (lambda x: stage.present(x, frame(stage)), [color(3, SCALE)]),
    ]


def kept(stage):
    """The history, which a stage that carries none is not given."""
    if stage.carried:
        return [(stage, [color(), numbers(len(stage.extra)), color(stage.carried)])]
    return [(lambda candidate: stage(candidate, numbers(0), None), [color()])]


def located(stage):
    return [
        (lambda x: stage.append(x, frame(stage)), [numbers(7)]),
        (lambda v: stage.between_samples(v, frame(stage), stage.remember(frame(stage))), [vectors(4)]),
        (lambda m: stage.at_target(m, frame(stage), SCALE), [vectors()]),
    ]


# slot: stage -> [(function, its differentiable arguments)]
CALLS = {
    "accumulate": lambda s: [(s, [color(s.channels), color(1)]), (s.append, [color()])],
    "base": lambda s: [(lambda y, x: s(y, x, frame(s)), [color(3, SCALE), color()])],
    "colour_space": lambda s: [(s.of_rgb, [color()]), (s.to_rgb, [color()])],
    "confine": lambda s: [(s, [color()])],
    "demodulate": light,
    "dilate": lambda s: [(lambda m: s(m, DEPTH), [vectors()])],
    "extract": lambda s: [(s, [color(4)])],
    "flow": lambda s: [(lambda m: s(frame(s, motion=m), (JITTER,)), [vectors()])],
    "guides": lambda s: [(lambda x: s(x, frame(s)), [color(4)])],
    "history": kept,
    "kernel_prediction": lambda s: [(s, [JITTER.clone().requires_grad_()])],
    "locate": located,
    "motion_grid": lambda s: [(lambda m: s(m, DEPTH, SCALE), [vectors()])],
    "motion_mask": lambda s: [(lambda x: s(x, VECTORS), [numbers(7)])],
    "pad": lambda s: [(lambda x, aligned: s(x, aligned, MOTION), [color(3, SCALE), color(3, SCALE)])],
    "rectify": lambda s: [(s, [color(3, SCALE), color()])],
    "recur": lambda s: [
        (lambda *x: step(s, *x), [numbers(2), vectors(2, SCALE), numbers(3, SCALE), numbers(3), numbers(3)])
    ],
    "reproject": lambda s: [(s, [color(4), vectors()])],
    "reweight": lambda s: [(lambda c, p: s(c, p.unflatten(1, (2, 5))), [color(5), color(10)])],
    "upsample": lambda s: [(lambda x: s(x, JITTER, SCALE), [numbers(4)])],
    "warp_at": lambda s: [(lambda x, m: through_the_window(s, x, m), [numbers(4), vectors()])],
}


@pytest.mark.parametrize(("slot", "option"), OPTIONS, ids=lambda x: x)
def test_a_stage_s_gradient(slot, option):
    """Motion too is differentiated where it is interpolated at; which pixel is nearest, or hidden, has no
    derivative."""
    if (slot, option) in NOT_DIFFERENTIABLE or slot not in CALLS:
        pytest.skip(NOT_DIFFERENTIABLE.get((slot, option), "checked inside its model"))
    torch.manual_seed(0)
    stage = stage_of(slot, option)
    weights = tuple(stage.parameters()) if isinstance(stage, nn.Module) else ()
    for function, leaves in CALLS[slot](stage):
        assert gradcheck(first(len(leaves), function), (*leaves, *weights), fast_mode=bool(weights))


def first(count, function):
    """Of ``count`` arguments and a stage's parameters, which are perturbed in place, where the stage has them."""
    return lambda *given: function(*given[:count])


def test_estimated_flow_gives_no_gradient():
    stage = stage_of("flow", "tvl1")
    flow = stage(frame(stage, color=color()), (color(), JITTER))
    assert not flow.requires_grad


@pytest.mark.parametrize("name", FAMILIES)
def test_a_model_s_gradient_through_time(name):
    """Two frames, by the first's colour and by all parameters along one direction.

    With a smooth map into [0, 1] where the published one has a gradient of its own.
    """
    model = model_of(name, *(["model/confine=sigmoid"] if "confine" in SLOTS[name] else []))
    torch.manual_seed(0)
    # Away from the initial biases of 0, at which ReLU has no derivative where nothing was sampled.
    weights = {key: p.detach() + 0.05 * torch.randn_like(p) for key, p in model.named_parameters()}
    way = {key: 0.1 * torch.randn_like(p) for key, p in weights.items()}
    buffers = clip(model.requires, frames=2, b=1, h=H, w=W, motion=0.2)
    key = "color" if "color" in model.requires else "radiance"

    def outputs(color, along):
        moved, made, state = {k: p + along * way[k] for k, p in weights.items()}, [], None
        for t in range(2):
            output, state = functional_call(model, moved, (Frame.from_clip(buffers | {key: color}, t), state))
            made.append(output)
        return torch.stack(made)

    along = torch.zeros((), dtype=torch.float64, requires_grad=bool(weights))
    assert gradcheck(outputs, (buffers[key].requires_grad_(), along), fast_mode=True)
