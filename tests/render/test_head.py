import numpy as np
import pytest
from camera_measures import eyes, path, route, speeds, stands

from supersampling.render.head import from_neck, minimum_jerk


def test_heads_turn_far_and_fast_and_pause():
    """Turns of 20 to 90 degrees that peak at 85 to 290 degrees a second, with pauses of 0.2 to 1.2 seconds."""
    clips = [path("head", seed) for seed in range(100)]
    spin = np.stack([speeds(p) for p in clips])
    assert np.percentile(spin, 95) > 120
    assert np.percentile(spin, 40) < 15
    assert 200 < spin.max() < 320
    ahead = np.stack([[-c.view[2, :3] for c in p.cameras] for p in clips])
    farthest = np.degrees(np.arccos(np.clip(np.einsum("ntk,nk->nt", ahead, ahead[:, 0]), -1, 1))).max(axis=1)
    assert np.mean(farthest > 20) > 0.7
    assert farthest.max() > 60


def test_heads_bob_sway_lean_and_never_hold_quite_still():
    moved = []
    for seed in range(30):
        p = path("head", seed, 120, route("point", [(1, 2, 3)]))
        assert not any(stands(p))
        moved.append(np.ptp(eyes(p), axis=0))
    assert 0.02 < np.median(moved) < 0.5
    heights = [np.ptp(eyes(path("head", seed, 120))[:, 1]) for seed in range(30)]
    assert 0.02 < np.median(heights) < 0.2


def test_eyes_swing_about_the_neck():
    """Level, a quarter turn to the right, and straight up: the Oculus SDK's 80.5 mm to the front and 75 mm up."""
    quarter = np.pi / 2
    swung = from_neck(np.array((0, quarter, 0)), np.array((0, 0, quarter)))
    np.testing.assert_allclose(swung, [(0, 0.075, -0.0805), (0.0805, 0.075, 0), (0, 0.0805, 0.075)], atol=1e-12)


def test_minimum_jerk_is_flash_and_hogan_s():
    """No speed or acceleration at both ends, a top speed of 15/8 in the middle, and a sixth derivative of zero."""
    t = np.linspace(-0.5, 1.5, 4001)
    s = minimum_jerk(t)
    v, a = np.gradient(s, t), np.gradient(np.gradient(s, t), t)
    assert s[0] == 0
    assert s[-1] == 1
    assert v.max() == pytest.approx(15 / 8, rel=1e-4)
    assert abs(t[v.argmax()] - 0.5) < 1e-3
    np.testing.assert_allclose(a[np.abs(t) < 1e-3], 0, atol=0.1)
    np.testing.assert_allclose(a[np.abs(t - 1) < 1e-3], 0, atol=0.1)
    assert np.abs(np.diff(s[(t > 0.01) & (t < 0.99)][::50], 6)).max() < 1e-9
