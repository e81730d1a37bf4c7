"""What makes a window interesting: detail, motion and disocclusion count, smooth ground and a blur of speed do not."""

import numpy as np

from supersampling.render.selection import interest

RNG = np.random.default_rng(0)
NOISE = RNG.random((32, 32, 3)).astype(np.float32)
FLAT = np.full((32, 32, 3), 0.5, dtype=np.float32)


def moving(pixels: float) -> np.ndarray:
    """The whole image moves by ``pixels`` target pixels at scale 4."""
    return np.full((32, 32, 2), pixels / (32 * 4) / np.sqrt(2), dtype=np.float32)


def test_detail_beats_smooth_ground():
    assert interest({"color": NOISE, "motion": moving(2)}, 4) > 5 * interest({"color": FLAT, "motion": moving(2)}, 4)


def test_motion_beats_standing_and_a_blur_of_speed():
    still, calm, fast = (interest({"color": NOISE, "motion": moving(p)}, 4) for p in (0, 2, 60))
    assert calm > still > fast


def test_motion_edges_count():
    parallax = moving(2)
    parallax[:, ::16] = 0
    shown = interest({"color": NOISE, "motion": parallax}, 4)
    assert shown > interest({"color": NOISE, "motion": moving(1)}, 4)
