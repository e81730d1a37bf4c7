import pytest
import torch

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.ops.chain import chain
from supersampling.stages.motion_mask import DualMotionMask, NoMotionMask


def frame(h=4, w=6, **vectors):
    zero = torch.zeros(1, 2, h, w)
    return Frame(motion=vectors.get("motion", zero), motion_dual=vectors.get("dual", zero))


def test_mask_is_appended_to_the_warped_channels():
    dual = torch.zeros(1, 2, 4, 6)
    dual[0, 1, 2, 3] = 0.2 / 4
    stage, warped = DualMotionMask(), torch.rand(1, 7, 4, 6)
    masked = stage(warped, stage.vectors(frame(dual=dual)))
    assert masked.shape == (1, 7 + stage.channels, 4, 6)
    assert torch.equal(masked[:, :7], warped)
    assert masked[0, 7].nonzero().tolist() == [[2, 3]]


def test_what_was_hidden_a_frame_ago_is_unreliable_two_frames_back():
    """First a still frame in which the pixel at column 2 was hidden before; then everything moves by one pixel."""
    stage, dual = DualMotionMask(), torch.zeros(1, 2, 1, 6)
    dual[0, 0, 0, 2] = 1 / 6
    earlier = chain(stage.vectors(frame(1, 6, dual=dual)), ())
    right = torch.zeros(1, 2, 1, 6)
    right[:, 0] = -1 / 6
    one, two = chain(stage.vectors(frame(1, 6, motion=right, dual=right)), earlier)
    masks = [stage(torch.empty(1, 0, 1, 6), v).flatten().tolist() for v in (one, two)]
    assert masks == [[0.0] * 6, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]]


def test_none_reads_no_dual_motion_and_adds_nothing():
    stage, warped = NoMotionMask(), torch.rand(1, 7, 4, 6)
    assert stage.requires == {"motion"}
    vectors = stage.vectors(Frame(motion=torch.rand(1, 2, 4, 6)))
    assert torch.equal(stage(warped, vectors), warped)
    assert stage.channels == 0


@pytest.mark.parametrize("threshold", [0.0, -1.0, float("nan")])
def test_threshold_must_be_positive(threshold):
    with pytest.raises(UserError, match=r"Invalid motion_mask\.threshold=.*: use a positive number"):
        DualMotionMask(threshold)
