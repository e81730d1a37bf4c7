"""Frames and clips of buffers that may begin at different times."""

import pytest
import torch

from supersampling.frames import BUFFERS, Frame, length_of


def test_a_frame_holds_its_own_moment_of_every_buffer():
    clip = {
        "color": torch.arange(5.0).view(1, 5, 1, 1, 1),
        "high_material": torch.tensor([3.0, 4.0]).view(1, 2, 1, 1, 1),
    }
    assert length_of(clip) == 5
    for t in range(5):
        frame = Frame.of(clip, t)
        assert frame.color is not None
        assert frame.color.item() == t
        if t < 3:  # high-resolution buffers are there for the last frames only
            assert frame.high_material is None
        else:
            assert frame.high_material is not None
            assert frame.high_material.item() == t
        assert frame.depth is None


def test_every_input_is_a_buffer_and_no_reference_is_an_input():
    names = set(Frame.__dataclass_fields__)
    assert names <= BUFFERS.keys()
    assert BUFFERS.keys() - names == {"target", "target_radiance"}


def test_a_repaired_frame_is_finite_and_keeps_what_was():
    bad = torch.tensor([0.25, torch.nan, torch.inf, -torch.inf]).view(1, 1, 1, 4)
    names = [b.name for b in BUFFERS.values() if b.resolution == "low" and b.name != "jitter"]
    frame = Frame(**{name: bad.clone() for name in names}, jitter=torch.tensor([[torch.nan, 0.1]]), high_depth=bad)
    mended = frame.repaired()
    for name in names:
        values = getattr(mended, name)
        assert values.isfinite().all()
        assert values[..., 0].item() == 0.25
        assert getattr(frame, name)[..., 1].isnan().all()  # a frame is not changed
    assert mended.depth[0, 0, 0].tolist() == [0.25, 1.0, 1.0, 0.0]
    assert mended.color[0, 0, 0].tolist() == [0.25, 0.0, 1.0, 0.0]
    assert mended.radiance[0, 0, 0].tolist() == [0.25, 0.0, 65504.0, -65504.0]
    assert mended.motion[0, 0, 0, 1:].abs().min() > 1000  # images away
    assert mended.jitter[0].tolist() == [0.0, pytest.approx(0.1)]
    assert mended.high_depth is bad
    assert mended.high_normal is None


def test_need_returns_tensors_in_order_and_names_missing_buffers():
    color, depth = torch.zeros(1, 3, 2, 2), torch.ones(1, 1, 2, 2)
    frame = Frame(color=color, depth=depth)
    assert frame.need("depth") is depth
    first, second = frame.need("depth", "color")
    assert first is depth
    assert second is color
    with pytest.raises(ValueError, match="no motion, jitter: add the missing buffers"):
        frame.need("color", "motion", "jitter")
    with pytest.raises(AttributeError):
        frame.need("colour")
