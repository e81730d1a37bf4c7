"""Frames and clips of buffers that may begin at different times."""

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
