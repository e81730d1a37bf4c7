"""The evidence for the direction of depth, on a world whose uncovered pixels are known."""

import pytest
from rendered import Rendered

from supersampling.data.readers.depth_check import check_depth, uncovered
from supersampling.data.readers.pairs import Pair
from supersampling.errors import UserError


def pairs(curve):
    def change(buffers, t):
        buffers["depth"] = curve(buffers["depth"])

    return [Pair(Rendered(change), t, 1.0) for t in range(1, 5)]


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
