"""DLCTUS in C++ against the plain form, which `test_dlctus` compares with the thesis's listing."""

import shutil

import pytest
import torch

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.dlctus import DLCTUS
from supersampling.models.dlctus_native import DLCTUSNative
from supersampling.stages.accumulate import AccumulationBuffer, NoAccumulation
from supersampling.stages.confine import Clamp, Sigmoid, StraightThrough
from supersampling.stages.dilate import ClosestDepth, NoDilation
from supersampling.stages.initialise import Balanced
from supersampling.stages.pad import JitterAligned, Zeros
from supersampling.stages.reproject import Bicubic9, Bilinear

pytestmark = pytest.mark.skipif(shutil.which("c++") is None, reason="no C++ compiler")


def dlctus(scale=4, **stages):
    slots = {
        "reproject": Bicubic9(),
        "dilate": NoDilation(),
        "pad": JitterAligned(),
        "accumulate": AccumulationBuffer(),
        "confine": Clamp(),
        "initialise": Balanced(),
    }
    torch.manual_seed(0)
    return DLCTUS(scale, **(slots | stages))


def clip(h, w, frames=6):
    """Yield frames of smooth motion, so that no position is within rounding of the image's border."""
    g = torch.Generator().manual_seed(1)
    y, x = torch.meshgrid(torch.arange(h), torch.arange(w), indexing="ij")
    for t in range(frames):
        motion = torch.stack((0.07 * torch.sin(x + t), 0.09 * torch.cos(0.7 * y - t)))[None]
        motion[..., : w // 3] = 0.0
        yield Frame(
            color=torch.rand(1, 3, h, w, generator=g),
            depth=torch.rand(1, 1, h, w, generator=g),
            motion=motion,
            jitter=torch.rand(1, 2, generator=g) - 0.5,
        )


@torch.no_grad()
def roll(model, frames):
    state, outputs = None, []
    for frame in frames:
        output, state = model(frame, state)
        outputs += [output, state]
    return outputs


@pytest.mark.parametrize(("scale", "h", "w"), [(4, 5, 7), (4, 1, 1), (4, 3, 60), (2, 6, 10), (1, 8, 12)])
@pytest.mark.parametrize(
    "stages", [{}, {"dilate": ClosestDepth()}, {"reproject": Bicubic9(-0.5), "confine": StraightThrough()}]
)
def test_equals_plain_form_over_a_clip(scale, h, w, stages):
    plain = dlctus(scale, **stages)
    expected, actual = roll(plain, clip(h, w)), roll(DLCTUSNative(plain), clip(h, w))
    for a, b in zip(actual, expected, strict=True):
        torch.testing.assert_close(a, b, rtol=0, atol=5e-5)
    assert expected[-1].std() > 0.05


@pytest.mark.parametrize("buffer", ["color", "depth", "motion"])
def test_values_that_are_not_finite_are_repaired_as_in_the_plain_form(buffer):
    plain = dlctus()
    frames = list(clip(24, 24, 2))
    getattr(frames[1], buffer)[0, 0, 2, 20] = torch.nan
    torch.testing.assert_close(roll(DLCTUSNative(plain), frames)[-1], roll(plain, frames)[-1], rtol=0, atol=5e-5)


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_history_that_is_not_finite_is_dropped(value):
    """A bad state does not spoil the clip, as in the plain form: after one frame the state is finite."""
    plain = dlctus()
    frames = list(clip(24, 24, 3))
    model = DLCTUSNative(plain)
    _, state = model(frames[0], None)
    state = state.clone()
    state[0, :, 20:30, 20:30] = value
    for frame in frames[1:]:
        image, state = model(frame, state)
    assert state.isfinite().all()
    assert image.isfinite().all()


@pytest.mark.parametrize("value", [float("inf"), -float("inf"), -1e30])
def test_huge_motion_is_outside_the_image(value):
    plain, states = dlctus(), {}
    for motion in (1e30, value):
        frames = list(clip(4, 4, 2))
        frames[1].motion[...] = motion
        states[motion] = roll(DLCTUSNative(plain), frames)[-1]
        if motion == 1e30:
            torch.testing.assert_close(states[motion], roll(plain, frames)[-1], rtol=0, atol=5e-5)
    assert torch.equal(*states.values())


@pytest.mark.parametrize("value", [float("nan"), 0.5, -3.0, 1e30])
def test_a_jitter_out_of_range_reads_inside_the_image(value):
    frames = list(clip(4, 4, 2))
    frames[1].jitter[...] = value
    assert roll(DLCTUSNative(dlctus()), frames)[-1].shape == (1, 4, 16, 16)


@pytest.mark.parametrize(
    ("stages", "name"),
    [
        ({"reproject": Bilinear()}, "Bilinear"),
        ({"pad": Zeros()}, "Zeros"),
        ({"accumulate": NoAccumulation()}, "NoAccumulation"),
        ({"confine": Sigmoid()}, "Sigmoid"),
        ({"scale": 3}, "scale 3"),
    ],
)
def test_unsupported_compositions_raise(stages, name):
    with pytest.raises(UserError, match=name):
        DLCTUSNative(dlctus(**stages))


def test_unsupported_inputs_raise():
    model, (frame,) = DLCTUSNative(dlctus(2)), clip(3, 4, 1)
    with pytest.raises(UserError, match="multiples of 4, not 8x6"):
        model(frame, None)
    (frame,) = clip(4, 4, 1)
    with pytest.raises(UserError, match="The history is 4x8"):
        model(frame, torch.rand(1, 4, 8, 4))
    double = Frame(color=frame.color.double(), depth=frame.depth, motion=frame.motion, jitter=frame.jitter)
    with pytest.raises(UserError, match="float64"):
        model(double, None)


def test_output_does_not_depend_on_the_number_of_threads():
    model, before = DLCTUSNative(dlctus()), torch.get_num_threads()
    results = []
    for threads in (1, 2):
        torch.set_num_threads(threads)
        results.append(roll(model, clip(24, 70, 3)))
    torch.set_num_threads(before)
    for a, b in zip(*results, strict=True):
        assert torch.equal(a, b)
