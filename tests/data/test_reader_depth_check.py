"""The evidence for the direction of depth, on a world whose uncovered pixels are known."""

from dataclasses import dataclass

import numpy as np
import pytest
from capture_files import JITTER, SIZE, frame

from supersampling.data.readers.depth_check import check_depth, uncovered
from supersampling.data.readers.pairs import Pair
from supersampling.errors import UserError


@dataclass
class Rendered:
    """A clip of the closed-form world, with any curve over its depth."""

    curve: object
    size: tuple[int, int] = SIZE

    def read(self, t, names):
        buffers = frame(t, 0, 2, JITTER[t % len(JITTER)], 1.0)
        buffers["depth"] = self.curve(buffers["depth"])
        return {name: buffers[name].astype(np.float32) for name in names}


def pairs(curve):
    return [Pair(Rendered(curve), t, 1.0) for t in range(1, 5)]


def hyperbolic(depth):
    return 1.0 - 0.01 / (0.01 + depth)


@pytest.mark.parametrize("curve", [lambda d: d, hyperbolic])
def test_disoccluded_pixels_were_behind_nearer_surfaces(curve):
    nearer, farther = uncovered(pairs(curve))
    assert nearer > 50
    assert farther < nearer / 10
    assert "came into view from behind something nearer" in check_depth("here", pairs(curve), False)


@pytest.mark.parametrize("curve", [lambda d: 1.0 - d, lambda d: 1.0 - hyperbolic(d)])
def test_reversed_depth_of_any_curve(curve):
    with pytest.raises(UserError, match="seems to be reversed"):
        check_depth("here", pairs(curve), False)


def test_user_setting_overrides_the_check():
    assert "0 pixels came into view" in check_depth("here", pairs(lambda d: 1.0 - d), True)


def test_still_frames_prove_nothing():
    assert "too few" in check_depth("here", [Pair(p.clip, p.t, 0.0) for p in pairs(lambda d: d)], False)
