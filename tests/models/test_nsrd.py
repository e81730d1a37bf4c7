"""NSRD against its paper's numbers and against a plain transcription."""

import math

import nsrd_transcription
import pytest
import torch
from torch.utils.flop_counter import FlopCounterMode

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.jau import JAU
from supersampling.models.nsrd import NSRD
from supersampling.ops.demodulate import demodulate
from supersampling.stages.base import JitterAlignedBase, NoBase
from supersampling.stages.demodulate import Demodulated, Radiance
from supersampling.stages.locate import LocatedByJitter, Unlocated
from supersampling.stages.motion_mask import DualMotionMask, NoMotionMask
from supersampling.stages.recur import NotRecurrent, Recurrent

INPUTS = {"radiance": 3, "material": 3, "emission": 3, "depth": 1, "normal": 3, "motion": 2, "motion_dual": 2}
SWITCHES = {
    "published": {},
    "radiance": {"demodulate": Radiance},
    "unmasked": {"motion_mask": NoMotionMask},
    "unrecurrent": {"recur": NotRecurrent},
    "none": {"demodulate": Radiance, "motion_mask": NoMotionMask, "recur": NotRecurrent},
    "one": {"previous": 1},
    "three": {"previous": 3},
    "located": {"locate": LocatedByJitter},
    "located and unmasked": {"locate": LocatedByJitter, "motion_mask": NoMotionMask, "previous": 3},
    "based": {"base": JitterAlignedBase},
    "both": {"locate": LocatedByJitter, "base": JitterAlignedBase, "recur": NotRecurrent},
}


def nsrd(
    scale=2,
    previous=2,
    demodulate=Demodulated,
    motion_mask=DualMotionMask,
    recur=Recurrent,
    locate=Unlocated,
    base=NoBase,
):
    torch.manual_seed(0)
    return NSRD(scale, previous, demodulate(), motion_mask(), recur, locate(), base())


def clip(frames=3, b=2, h=5, w=6, seed=0, motion=0.1, dtype=torch.float32):
    g = torch.Generator().manual_seed(seed)
    buffers = {k: torch.rand(b, frames, c, h, w, generator=g, dtype=dtype) for k, c in INPUTS.items()}
    buffers["material"] += 0.1
    buffers["radiance"] += buffers["emission"]
    buffers["motion"] = (2 * buffers["motion"] - 1) * motion
    hidden = torch.rand(b, frames, 1, h, w, generator=g, dtype=dtype) > 0.7
    buffers["motion_dual"] = torch.where(hidden, (2 * buffers["motion_dual"] - 1) * motion, buffers["motion"])
    buffers["jitter"] = torch.rand(b, frames, 2, generator=g, dtype=dtype) - 0.5
    return buffers


def run(model, buffers):
    inputs = {name: values for name, values in buffers.items() if name in model.requires}
    outputs, state = [], None
    for t in range(buffers["radiance"].shape[1]):
        output, state = model(Frame.from_clip(inputs, t), state)
        outputs.append(output)
    return torch.stack(outputs, dim=1)


def count(module):
    return sum(p.numel() for p in module.parameters())


def conv(inputs, outputs, side=3):
    return outputs * (inputs * side**2 + 1)


BLOCK = 2 * conv(64, 64) + conv(64, 4, 1) + conv(4, 64, 1)
U_SHAPED = 13 * BLOCK + 2 * conv(128, 64) + conv(64, 32)


def test_parameters_of_supplement_table_2():
    model = nsrd(scale=4)
    assert count(model.first) == conv(7, 32)
    assert round(count(model.first) / 1e3, 2) == 2.05
    # The gated convolution is shared by both previous frames, and printed twice; the printed total counts it once.
    assert count(model.gated) == 2 * conv(8, 32)
    assert round(2 * count(model.gated) / 1e3, 2) == 9.34
    assert round(count(model.recur.first) / 1e3, 2) == 13.86
    assert round(count(model.recur.lstm) / 1e3, 2) == 442.62
    assert count(model.reconstruct) == U_SHAPED + conv(32, 48)
    assert round(count(model) / 1e3, 2) == 1610.79
    assert count(model) == 1_610_788


@pytest.mark.parametrize("scale", [2, 4, 6])
def test_only_first_and_last_layers_depend_on_scale(scale):
    changed = conv(3 * scale**2, 32) + conv(32, 3 * scale**2)
    assert count(nsrd(scale=scale)) == 1_610_788 - conv(48, 32) - conv(32, 48) + changed


def test_disabled_stage_leaves_no_parameters_and_no_inputs():
    whole = count(nsrd())
    assert count(nsrd(motion_mask=NoMotionMask)) == whole - 64 * 9
    assert count(nsrd(demodulate=Radiance)) == whole
    lstm = conv(12, 32) + conv(128 + 64, 256)
    assert count(nsrd(recur=NotRecurrent)) == whole - lstm + conv(96, 64)
    assert nsrd(motion_mask=NoMotionMask).requires == nsrd().requires - {"motion_dual"}
    bare = nsrd(demodulate=Radiance, motion_mask=NoMotionMask, recur=NotRecurrent)
    assert bare.requires == {"radiance", "depth", "normal", "motion"}
    assert bare.compares == {"target_radiance"}
    _, state = bare(Frame.from_clip(clip(), 0), None)
    assert state.carried == state.located == ()


def test_additions_to_the_paper_add_only_their_channels_and_jitter():
    whole = nsrd()
    assert "jitter" not in whole.requires
    located, based = nsrd(locate=LocatedByJitter), nsrd(base=JitterAlignedBase)
    assert located.requires == based.requires == whole.requires | {"jitter"}
    assert count(located) == count(whole) + 2 * 9 * (32 + 64)
    assert count(based) == count(whole)


def test_multiply_accumulates_of_supplement_table_2():
    """At 480x270. The table truncates digits, after rounding the gated convolution of one frame."""
    h, w = 270, 480
    with torch.device("meta"):
        model = nsrd(scale=4)
        frame = Frame(**{name: torch.empty(1, channels, h, w) for name, channels in INPUTS.items()})
        _, state = model(frame, None)
        with FlopCounterMode(display=False, depth=4) as counted:
            model(frame, state)
    macs = {name: sum(ops.values()) // 2 for name, ops in counted.get_flop_counts().items()}
    full, half, quarter = h * w, (h // 2) * (w // 2), (h // 4) * (w // 4)
    square = 64 * 64 * 9  # a 3x3 convolution from 64 to 64 channels, at one pixel
    u_shaped = (6 * 2 + 2) * square * full + (4 * 2 + 2) * square * half + 3 * 2 * square * quarter
    u_shaped += 13 * 2 * 64 * 4 + (64 * 32 + 32 * 48) * 9 * full
    expected = {
        "NSRD.first": 7 * 32 * 9 * full,
        "NSRD.gated": 2 * 8 * 64 * 9 * full,
        "NSRD.recur.first": 48 * 32 * 9 * full,
        "NSRD.recur.lstm": (128 + 64) * 256 * 9 * full,
        "NSRD.reconstruct": u_shaped,
    }
    assert {name: macs[name] for name in expected} == expected
    assert macs["NSRD"] == sum(expected.values()) == 145_366_831_616
    printed = [0.26, None, 1.79, 57.33, 84.78]
    for value, figure in zip(expected.values(), printed, strict=True):
        assert figure is None or math.floor(value / 1e7) == round(100 * figure)
    assert 2 * round(expected["NSRD.gated"] / 2e9, 2) == 1.20
    assert math.floor(macs["NSRD"] / 1e7) == 14_536


@pytest.mark.parametrize(("scale", "h", "w"), [(2, 5, 6), (3, 7, 4)])
@pytest.mark.parametrize(("located", "based"), [(False, False), (True, False), (False, True), (True, True)])
def test_equals_a_plain_transcription_over_a_clip(scale, h, w, located, based):
    locate, base = LocatedByJitter if located else Unlocated, JitterAlignedBase if based else NoBase
    model = nsrd(scale=scale, locate=locate, base=base).double()
    buffers = clip(5, 1, h, w, dtype=torch.float64)
    frames = [{name: values[0, t] for name, values in buffers.items()} for t in range(5)]
    with torch.no_grad():
        expected = nsrd_transcription.outputs(model, frames, located, based)
        outputs = run(model, buffers)[0]
    assert outputs[2].diff(dim=-1).abs().max() > 1e-3
    torch.testing.assert_close(outputs, expected, rtol=0, atol=1e-11)


def reliable_inputs(model, buffers):
    """Return the input of the gated convolution at a clip's last frame, ``(B, previous, C, h, w)``."""
    seen = []
    model.gated.register_forward_hook(lambda module, args, out: seen.append(args[0]))
    with torch.no_grad():
        run(model, buffers)
    return torch.stack(seen[-1].chunk(model.previous), dim=1)


@pytest.mark.parametrize("previous", [1, 2, 3])
def test_without_motion_previous_frames_are_unchanged(previous):
    buffers = clip(frames=5, motion=0.0)
    read = reliable_inputs(nsrd(previous=previous), buffers)
    light = demodulate(buffers["radiance"], buffers["material"], buffers["emission"])
    for k in range(previous):
        inputs = torch.cat((light, buffers["depth"], buffers["normal"]), dim=2)[:, 3 - k]
        assert torch.equal(read[:, k, :7], inputs)
        assert torch.equal(read[:, k, 7], torch.zeros(2, 5, 6))


def test_warping_moves_with_the_image_by_whole_pixels():
    buffers = clip(frames=4, h=16, w=18, motion=0.02)
    moved = {name: values.roll((3, 2), dims=(-1, -2)) for name, values in buffers.items()}
    read, read_moved = (reliable_inputs(nsrd(), b) for b in (buffers, moved))
    inner = (..., slice(4, -2), slice(5, -2))
    torch.testing.assert_close(read_moved[inner], read.roll((3, 2), dims=(-1, -2))[inner], rtol=0, atol=1e-5)


@pytest.mark.parametrize("switches", SWITCHES.values(), ids=SWITCHES)
def test_items_do_not_mix_and_gradients_are_finite(switches):
    model, buffers = nsrd(**switches), clip()
    buffers["radiance"].requires_grad_()
    outputs = run(model, buffers)
    assert outputs.shape == (2, 3, 3, 10, 12)
    alone = run(model, {name: values[1:] for name, values in buffers.items()})
    torch.testing.assert_close(alone[0], outputs[1], rtol=0, atol=1e-5)
    outputs[:, -1].square().mean().backward()
    grad = buffers["radiance"].grad
    assert grad.isfinite().all()
    # Two previous frames are in the window; what lies before them arrives through the recurrence.
    assert (grad[:, 0].abs().max() > 0) == (model.previous > 1 or model.recur.__class__ is Recurrent)
    assert all(p.grad is not None and p.grad.isfinite().all() for p in model.parameters())


@pytest.mark.parametrize(("h", "w"), [(1, 1), (2, 7), (9, 3)])
@pytest.mark.parametrize("scale", [1, 2, 4, 6])
def test_every_size(scale, h, w):
    with torch.no_grad():
        outputs = run(nsrd(scale=scale), clip(h=h, w=w))
    assert outputs.shape == (2, 3, 3, h * scale, w * scale)
    assert outputs.isfinite().all()


@pytest.mark.parametrize("buffer", INPUTS)
def test_every_declared_buffer_changes_the_output(buffer):
    model, buffers = nsrd(), clip()
    with torch.no_grad():
        changed = run(model, {**buffers, buffer: clip(seed=1)[buffer]})
        assert not torch.equal(changed[:, -1], run(model, buffers)[:, -1])


@pytest.mark.parametrize("switch", [{"locate": LocatedByJitter}, {"base": JitterAlignedBase}])
def test_jitter_changes_the_output_if_declared(switch):
    model, buffers = nsrd(**switch), clip()
    with torch.no_grad():
        changed = run(model, {**buffers, "jitter": clip(seed=1)["jitter"]})
        assert not torch.equal(changed[:, -1], run(model, buffers)[:, -1])


def test_a_last_layer_of_zeros_leaves_the_jitter_aligned_lighting():
    model, buffers = nsrd(scale=4, base=JitterAlignedBase), clip()
    with torch.no_grad():
        for p in model.reconstruct.last.parameters():
            p.zero_()
        outputs = run(model, buffers)
    light = demodulate(buffers["radiance"], buffers["material"], buffers["emission"])
    for t in range(3):
        jau = JAU(4)(Frame(color=light[:, t] / 20.0, jitter=buffers["jitter"][:, t]), None)[0] * 20.0
        torch.testing.assert_close(outputs[:, t], jau, rtol=0, atol=1e-5)


def test_recurrence_outlasts_the_window():
    buffers, other = clip(frames=6, motion=0.0), clip(frames=6, motion=0.0, seed=1)
    mixed = {name: torch.cat((other[name][:, :2], values[:, 2:]), dim=1) for name, values in buffers.items()}
    with torch.no_grad():
        for recur, remembers in ((Recurrent, True), (NotRecurrent, False)):
            model = nsrd(recur=recur)
            assert torch.equal(run(model, mixed)[:, 5], run(model, buffers)[:, 5]) != remembers


def test_output_is_float32_under_autocast():
    with torch.no_grad(), torch.autocast("cpu", torch.bfloat16):
        outputs = run(nsrd(), clip())
    assert outputs.dtype == torch.float32
    torch.testing.assert_close(outputs, run(nsrd(), clip()).detach(), rtol=0, atol=0.02)


def test_zero_previous_frames_raise():
    with pytest.raises(UserError, match=r"Invalid model\.previous=0: use at least 1 previous frame"):
        nsrd(previous=0)


@pytest.mark.parametrize(
    "switches",
    [{}, {"recur": NotRecurrent}, {"locate": LocatedByJitter, "base": JitterAlignedBase}],
    ids=["published", "unrecurrent", "jitter"],
)
def test_exports_to_a_graph(switches):
    model, buffers = nsrd(scale=4, **switches).eval(), clip(b=1)
    frames = [{name: values[:, t] for name, values in buffers.items()} for t in range(3)]

    class Step(torch.nn.Module):
        def __init__(self):
            super().__init__()
            self.model = model

        def forward(self, buffers, state):
            return self.model(Frame(**buffers), state)

    with torch.no_grad():
        _, state = model(Frame(**frames[0]), None)
        exported = torch.export.export(Step(), (frames[1], state)).module()
        for frame in frames[1:]:
            expected, following = model(Frame(**frame), state)
            output, state = exported(frame, state)
            torch.testing.assert_close(output, expected)
            for actual, expected in zip(sum(state, ()), sum(following, ()), strict=True):
                torch.testing.assert_close(actual, expected)
