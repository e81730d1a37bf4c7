"""Tests of frames and of clips whose buffers begin at different times."""

import hashlib

import pytest
import torch

from supersampling.data.dataset_file import describe
from supersampling.frames import BUFFERS, Frame, clip_length


def test_frame_contains_its_time_step_of_every_buffer():
    clip = {
        "color": torch.arange(5.0).view(1, 5, 1, 1, 1),
        "high_material": torch.tensor([3.0, 4.0]).view(1, 2, 1, 1, 1),
    }
    assert clip_length(clip) == 5
    for t in range(5):
        frame = Frame.from_clip(clip, t)
        assert frame.color is not None
        assert frame.color.item() == t
        # High-resolution buffers cover the last frames only.
        if t < 3:
            assert frame.high_material is None
        else:
            assert frame.high_material is not None
            assert frame.high_material.item() == t
        assert frame.depth is None


def test_inputs_are_all_buffers_except_references():
    names = set(Frame.__dataclass_fields__)
    assert names <= BUFFERS.keys()
    assert BUFFERS.keys() - names == {"target", "target_radiance"}


def test_repair_makes_a_frame_finite_and_keeps_finite_values():
    invalid = torch.tensor([0.25, torch.nan, torch.inf, -torch.inf]).view(1, 1, 1, 4)
    names = [b.name for b in BUFFERS.values() if b.resolution == "low" and b.name != "jitter"]
    frame = Frame(
        **{name: invalid.clone() for name in names}, jitter=torch.tensor([[torch.nan, 0.1]]), high_depth=invalid
    )
    repaired = frame.repair()
    for name in names:
        values = getattr(repaired, name)
        assert values.isfinite().all()
        assert values[..., 0].item() == 0.25
        # The original frame is unchanged.
        assert getattr(frame, name)[..., 1].isnan().all()
    assert repaired.depth[0, 0, 0].tolist() == [0.25, 1.0, 1.0, 0.0]
    assert repaired.color[0, 0, 0].tolist() == [0.25, 0.0, 1.0, 0.0]
    assert repaired.radiance[0, 0, 0].tolist() == [0.25, 0.0, 65504.0, -65504.0]
    # More than 1000 image sizes away.
    assert repaired.motion[0, 0, 0, 1:].abs().min() > 1000
    assert repaired.jitter[0].tolist() == [0.0, pytest.approx(0.1)]
    assert repaired.high_depth is invalid
    assert repaired.high_normal is None


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


def test_descriptions_stored_in_files_stay():
    """Every data set file stores these texts, so a changed word changes its bytes."""
    text = describe(sorted(BUFFERS))
    assert hashlib.sha256(text.encode()).hexdigest()[:16] == "bad3b3b96500a073"
