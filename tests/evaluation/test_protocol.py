"""What a protocol leaves out."""

import pytest
import torch

from supersampling.errors import UserError
from supersampling.evaluation.protocol import Protocol
from supersampling.metrics.prepare import Continuous
from supersampling.metrics.suite import Moment


def moment(height=6, width=10, scale=2):
    generator = torch.Generator().manual_seed(0)

    def image(channels, by=1):
        return torch.rand((1, channels, height * by, width * by), generator=generator)

    high = [image(3, scale) for _ in range(6)]
    return Moment(*high[:2], (high[2], high[3]), image(2), image(2), (high[4], high[5]), (height, width))


def test_a_border_is_cut_off_every_image():
    whole = moment()
    inner = Protocol(Continuous(), border=2).inner(whole)
    for ours, theirs in (
        (inner.output, whole.output),
        (inner.target, whole.target),
        (inner.previous[0], whole.previous[0]),
        (inner.previous[1], whole.previous[1]),
        (inner.radiance[0], whole.radiance[0]),
        (inner.radiance[1], whole.radiance[1]),
    ):
        assert torch.equal(ours, theirs[..., 4:8, 4:16])
    assert inner.size == (2, 6)


def test_motion_keeps_its_length_in_pixels():
    whole = moment()
    inner = Protocol(Continuous(), border=2).inner(whole)
    for ours, theirs in ((inner.motion, whole.motion), (inner.motion_dual, whole.motion_dual)):
        torch.testing.assert_close(ours[:, 0] * 6, theirs[:, 0, 2:4, 2:8] * 10)
        torch.testing.assert_close(ours[:, 1] * 2, theirs[:, 1, 2:4, 2:8] * 6)


def test_no_border_is_the_whole_frame():
    whole = moment()
    assert Protocol(Continuous()).inner(whole) is whole


def test_what_is_not_there_stays_away():
    inner = Protocol(Continuous(), border=1).inner(Moment(*moment().previous, size=(6, 10)))
    assert (inner.previous, inner.motion, inner.motion_dual, inner.radiance) == (None, None, None, None)


def test_mistakes():
    with pytest.raises(UserError, match="warm_up must be 0 or more, got -1"):
        Protocol(Continuous(), warm_up=-1)
    with pytest.raises(UserError, match="border must be 0 or more, got -2"):
        Protocol(Continuous(), border=-2)
    with pytest.raises(UserError, match="border=3 leaves nothing of frames that were rendered at 10x6"):
        Protocol(Continuous(), border=3).inner(moment())
