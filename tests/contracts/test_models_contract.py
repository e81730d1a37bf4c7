"""What every model keeps with every option of every stage: shapes, independence of items, what it reads, what it hands
on.

Everything is in float64, so that what has to be equal is so to 1e-9 whatever order a convolution adds in.
"""

import sys

import pytest
import torch
from model_cases import (
    FAMILIES,
    MODELS,
    SLOTS,
    VARIANTS,
    clip,
    config_of,
    every_variant,
    model_of,
    run,
    shown,
    stems,
    trained_copy,
)
from torch.utils import _pytree

from supersampling.frames import BUFFERS, Frame
from supersampling.losses import L1
from supersampling.ops.warp import outside, warp
from supersampling.training.module import Training

SCALES = [2, 3, 4, 5, 6]


def tensors(state):
    """Those of a state, or of several; a method of single frames hands on None."""
    return [leaf for leaf in _pytree.tree_leaves(state) if leaf is not None]


def test_every_option_is_found():
    """A slot's default is an option of its own folder, and what was read of the yaml files is what Hydra makes of
    them."""
    assert {"nsrr", "nsrd", "enss_m", "dlctus", "tus", "jau", "bicubic"} <= set(FAMILIES)
    assert {"nsrr_fast", "enss_s", "enss_l"} <= set(MODELS)
    for family, slots in SLOTS.items():
        stages = {key for key, value in config_of(family).model.items() if hasattr(value, "keys")}
        assert stages == set(slots)
        for slot, published in slots.items():
            assert published in stems(f"model/{slot}")
    assert len(set(VARIANTS)) == len(VARIANTS)


@every_variant
@torch.no_grad()
def test_shapes_and_range_at_odd_sizes(variant):
    """From one pixel up. An output may leave [0, 1] in a method's own domain, what is displayed of it may not."""
    model = model_of(*variant, dtype=torch.float32)
    for h, w in ((1, 1), (5, 3)):
        buffers = clip(model.requires, h=h, w=w, dtype=torch.float32)
        outputs, _ = run(model, buffers)
        assert outputs.shape == (2, 3, 3, 2 * h, 2 * w)
        assert outputs.dtype == torch.float32
        assert outputs.isfinite().all()
        images = shown(model, buffers, outputs)
        assert images.shape == outputs.shape
        assert images.min() >= 0.0
        assert images.max() <= 1.0
        targets = model.reference(clip(model.compares, h=h, w=w, dtype=torch.float32))
        assert targets.shape == outputs.shape


@every_variant
@torch.no_grad()
def test_pictures_are_images_and_change_nothing(variant):
    """What `pictured` and `state_images` return, and that outputs and states are the same with and without them."""
    model = model_of(*variant, dtype=torch.float32)
    buffers = clip(model.requires, frames=3, h=5, w=3, dtype=torch.float32)
    expected, expected_states = run(model, buffers)
    state, pictures = None, {}
    for t in range(3):
        frame = Frame.from_clip(buffers, t)
        pictures = dict(model.pictured(frame, state))
        output, state = model(frame, state)
        assert torch.equal(output, expected[:, t])
        pictures |= model.state_images(state)
        for image in pictures.values():
            assert image.shape[0] == 2
            assert image.shape[1] in (1, 3)
            assert image.shape[2:] == output.shape[2:]
            assert image.min() >= 0.0
            assert image.max() <= 1.0
    for item, other in zip(tensors([state]), tensors(expected_states[-1:]), strict=True):
        assert torch.equal(item, other)


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("name", MODELS)
@torch.no_grad()
def test_every_scale(name, scale):
    model = model_of(name, f"task.scale={scale}", dtype=torch.float32)
    for h, w in ((1, 1), (3, 4)):
        outputs, _ = run(model, clip(model.requires, scale, frames=2, b=1, h=h, w=w, dtype=torch.float32))
        assert outputs.shape == (1, 2, 3, h * scale, w * scale)
        assert outputs.isfinite().all()


@every_variant
@torch.no_grad()
def test_a_clip_s_result_does_not_depend_on_its_neighbours(variant):
    """Alone, and beside another clip: outputs and every tensor of the state."""
    model = model_of(*variant)
    ours, others = clip(model.requires, b=1), clip(model.requires, b=2, seed=1)
    beside = {name: torch.cat((others[name], ours[name])) for name in ours}
    outputs, states = run(model, beside)
    alone, alone_states = run(model, ours)
    torch.testing.assert_close(outputs[2:], alone, rtol=0, atol=1e-9)
    for got, expected in zip(tensors(states), tensors(alone_states), strict=True):
        assert len(got) == 3
        torch.testing.assert_close(got[2:], expected, rtol=0, atol=1e-9)


@every_variant
@torch.no_grad()
def test_zero_motion_is_the_identity_for_the_warped_part(variant, monkeypatch):
    """A clip whose frames are all the first, still, gives the same to the bit as a model that cannot warp.

    Still means one jitter as well: where a low-resolution image is warped, a change of jitter moves its samples.
        Estimated flow has to find none between equal frames. In a moving clip the two models differ, but for those that
        warp nothing: methods of one frame, and the options that leave motion out.
    """
    model = model_of(*variant)
    moving = clip(model.requires)
    still = {name: values[:, :1].expand_as(values) for name, values in moving.items()}
    for name in ("motion", "motion_dual"):
        if name in still:
            still[name] = torch.zeros_like(still[name])
    expected, expected_moving = run(model, still)[0], run(model, moving)[0]
    for module in [m for name, m in sys.modules.items() if name.startswith("supersampling.")]:
        if getattr(module, "warp", None) is warp:
            monkeypatch.setattr(module, "warp", lambda image, motion, sample=None: image)
        if getattr(module, "outside", None) is outside:
            monkeypatch.setattr(module, "outside", lambda motion: torch.zeros_like(motion[:, :1]).bool())
    assert torch.equal(run(model, still)[0], expected)
    estimated = "model/flow=tvl1" in variant
    assert torch.equal(run(model, moving)[0], expected_moving) != ("motion" in model.requires or estimated)


@every_variant
def test_a_detached_state_goes_on_as_the_state_does(variant):
    """What goes in is what came out: same outputs and states from a detached copy, which the model leaves as it was.

    A state is tensors alone, batch first, of one shape and type at every frame. `Upsampler.advance`, with which a
    training skips the outputs that its loss does not count, gives the same state.
    """
    model = model_of(*variant)
    buffers = clip(model.requires)
    outputs, (first, second, third) = run(model, buffers)
    shapes = [[(s.shape, s.dtype) for s in tensors(state)] for state in (first, second, third)]
    assert shapes[0] == shapes[1] == shapes[2]
    assert all(shape[0] == 2 for shape, _ in shapes[0])
    copied = _pytree.tree_map_only(torch.Tensor, lambda s: s.detach().clone(), first)
    kept = _pytree.tree_map_only(torch.Tensor, torch.clone, copied)
    rest = {name: values[:, 1:] for name, values in buffers.items()}
    again, states = run(model, rest, copied)
    assert torch.equal(again, outputs[:, 1:])
    for got, expected in zip(tensors(states), tensors((second, third)), strict=True):
        assert torch.equal(got, expected)
    with torch.no_grad():
        advanced = model.advance(Frame.from_clip(buffers, 1), copied)
    for got, expected in zip(tensors((copied, advanced)), tensors((kept, second)), strict=True):
        assert torch.equal(got, expected)


@every_variant
@torch.no_grad()
def test_what_is_declared_is_read_and_nothing_else(variant):
    """Every buffer in ``requires`` changes what is displayed, so an option that is off left none behind; all others do
    not.

    Buffers of high resolution are read where an output is displayed.
    """
    model = model_of(*variant, dtype=torch.float32)
    names, size = [*Frame.__dataclass_fields__], {"frames": 2, "b": 1, "h": 4, "w": 5, "dtype": torch.float32}
    everything, other = (clip(names, seed=seed, **size) for seed in (0, 1))
    given = {name: values for name, values in everything.items() if name in model.requires}
    images = shown(model, given)
    assert torch.equal(shown(model, everything), images)
    for name in given:
        assert not torch.equal(shown(model, given | {name: other[name]}), images), f"{name} is not read"
    assert model.requires <= set(BUFFERS)
    assert "target" not in model.requires


@every_variant
def test_a_training_step_reaches_every_parameter(variant):
    """So a stage that is off left none behind. One step of Adam makes every tensor that had a gradient another one."""
    model = trained_copy(*variant)
    buffers = clip(model.requires | model.compares, dtype=torch.float32)
    if not list(model.parameters()):
        assert variant[0] in ("bicubic", "bilinear", "jau", "jau_bicubic", "nearest", "tus", "tus_thesis")
        return
    training = Training(model, L1(), torch.optim.Adam, lambda optimizer: None, counted=2)
    training.log = lambda *args, **kwargs: None
    optimizer = training.configure_optimizers()["optimizer"]
    value = training.training_step(buffers, 0)
    value.backward()
    assert value.isfinite()
    before = {name: p.detach().clone() for name, p in model.named_parameters()}
    optimizer.step()
    for name, p in model.named_parameters():
        assert p.grad is not None, f"{name} takes no part"
        assert p.grad.isfinite().all()
        assert torch.equal(p, before[name]) != bool(p.grad.any())


OFF = [
    (family, slot, option)
    for family, slots in SLOTS.items()
    for slot in slots
    for option in stems(f"model/{slot}")
    if "none" in stems(f"model/{slot}") and option != "none"
]


@pytest.mark.parametrize(("family", "slot", "option"), OFF, ids=lambda x: x)
def test_off_has_no_more_parameters_and_inputs_than_any_option(family, slot, option):
    """Beside the two tests above; ``compares`` are a training's inputs. Displayed colour is another input than
    light, no more."""
    off, other = model_of(family, f"model/{slot}=none"), model_of(family, f"model/{slot}={option}")
    assert sum(p.numel() for p in off.parameters()) <= sum(p.numel() for p in other.parameters())
    assert len(off.state_dict()) <= len(other.state_dict())
    if option != "display":
        assert off.requires <= other.requires
        assert off.compares <= other.compares
