import numpy as np
import pytest
from scipy.stats import qmc

from supersampling.errors import UserError
from supersampling.render.jitter import halton, jitter_sequence, mip_bias, target_mip_bias, thesis_2x2, thesis_4x4


def test_4x4_visits_every_target_pixel_centre_once():
    cells = (thesis_4x4() + 0.5) * 4
    np.testing.assert_array_equal(cells % 1, 0.5)
    assert len({tuple(c) for c in np.floor(cells).astype(int).tolist()}) == 16


def test_4x4_consecutive_positions_never_touch():
    """The thesis: "no two consecutive samples are neighbors"; here across the repetition and the tiling as well."""
    cells = np.floor((thesis_4x4() + 0.5) * 4)
    step = np.abs(cells - np.roll(cells, 1, axis=0))
    assert (np.minimum(step, 4 - step).max(axis=1) >= 2).all()


def test_2x2_has_four_positions_in_every_target_pixel():
    cells = np.floor((thesis_2x2() + 0.5) * 2).astype(int)
    _, counts = np.unique(cells, axis=0, return_counts=True)
    assert counts.tolist() == [4, 4, 4, 4]


def test_2x2_follows_an_hourglass():
    cells = np.floor((thesis_2x2()[:4] + 0.5) * 2).astype(int)
    assert cells.tolist() == [[0, 0], [1, 0], [0, 1], [1, 1]]


def test_halton_agrees_with_scipy():
    expected = qmc.Halton(d=2, scramble=False).random(33)[1:] - 0.5
    np.testing.assert_allclose(halton(32), expected, atol=1e-6)


@pytest.mark.parametrize("scale", range(2, 7))
@pytest.mark.parametrize("pattern", ["thesis", "halton16", "halton5", "none"])
def test_offsets_lie_in_the_pixel(pattern, scale):
    offsets = jitter_sequence(pattern, scale)
    assert offsets.dtype == np.float32
    assert offsets.min() >= -0.5
    assert offsets.max() < 0.5


def test_mip_biases_are_equation_47():
    assert mip_bias("matched", 4) == -2.0
    assert mip_bias("sharp", 2) == -2.0
    assert target_mip_bias("matched") == 0.0
    assert target_mip_bias("sharp") == -1.0


@pytest.mark.parametrize("name", ["hilbert", "halton", "haltonx", "halton0"])
def test_error_of_unknown_pattern(name):
    with pytest.raises(UserError, match=name):
        jitter_sequence(name, 4)
    with pytest.raises(UserError, match="soft"):
        mip_bias("soft", 4)
