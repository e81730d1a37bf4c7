"""Frames and pixels that a protocol leaves out."""

import pytest
import torch

from supersampling.errors import UserError
from supersampling.evaluation.protocol import Protocol
from supersampling.metrics.base import Moment
from supersampling.metrics.prepare import Continuous


def moment(height=6, width=10, scale=2):
    generator = torch.Generator().manual_seed(0)

    def image(channels, by=1):
        return torch.rand((1, channels, height * by, width * by), generator=generator)

    high = [image(3, scale) for _ in range(6)]
    return Moment(
        output=high[0],
        target=high[1],
        previous=(high[2], high[3]),
        motion=image(2),
        motion_dual=image(2),
        radiance=(high[4], high[5]),
        size=(height, width),
    )


def test_border_is_removed_from_every_image():
    whole = moment()
    inner = Protocol(Continuous(), border=2).inner(whole)
    for cropped, image in (
        (inner.output, whole.output),
        (inner.target, whole.target),
        (inner.previous[0], whole.previous[0]),
        (inner.previous[1], whole.previous[1]),
        (inner.radiance[0], whole.radiance[0]),
        (inner.radiance[1], whole.radiance[1]),
    ):
        assert torch.equal(cropped, image[..., 4:8, 4:16])
    assert inner.size == (2, 6)


def test_motion_keeps_its_length_in_pixels():
    whole = moment()
    inner = Protocol(Continuous(), border=2).inner(whole)
    for cropped, motion in ((inner.motion, whole.motion), (inner.motion_dual, whole.motion_dual)):
        torch.testing.assert_close(cropped[:, 0] * 6, motion[:, 0, 2:4, 2:8] * 10)
        torch.testing.assert_close(cropped[:, 1] * 2, motion[:, 1, 2:4, 2:8] * 6)


def test_no_border_is_the_whole_frame():
    whole = moment()
    assert Protocol(Continuous()).inner(whole) is whole


def test_missing_buffers_stay_missing():
    output, target = moment().previous
    inner = Protocol(Continuous(), border=1).inner(Moment(output=output, target=target, size=(6, 10)))
    assert (inner.previous, inner.motion, inner.motion_dual, inner.radiance) == (None, None, None, None)


def test_mistakes():
    with pytest.raises(UserError, match="protocol.warm_up=-1: use at least 0"):
        Protocol(Continuous(), warm_up=-1)
    with pytest.raises(UserError, match="protocol.border=-2: use at least 0"):
        Protocol(Continuous(), border=-2)
    with pytest.raises(UserError, match="border=3: use less than half of the rendered 10x6 pixels"):
        Protocol(Continuous(), border=3).inner(moment())
