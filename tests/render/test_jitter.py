import numpy as np
import pytest
from scipy.stats import qmc

from supersampling.errors import UserError
from supersampling.render.jitter import halton, jitter_sequence, mip_bias, target_mip_bias, thesis_2x2, thesis_4x4


def test_4x4_visits_every_target_pixel_centre_once():
    cells = (thesis_4x4() + 0.5) * 4
    np.testing.assert_array_equal(cells % 1, 0.5)
    assert len({tuple(c) for c in np.floor(cells).astype(int).tolist()}) == 16


def test_4x4_follows_the_order_of_the_thesis_program():
    """`Jitter::Custom(4)` of the program, typed a second time: sixteen (x, y), the first and the last."""
    cells = np.floor((thesis_4x4() + 0.5) * 4).astype(int)
    rows = [[2, 1], [0, 2], [2, 3], [0, 0], [1, 2], [3, 3], [1, 0], [3, 1]]
    rows += [[0, 3], [2, 0], [0, 1], [2, 2], [3, 0], [1, 1], [3, 2], [1, 3]]
    assert cells.tolist() == rows


def test_4x4_consecutive_positions_never_touch():
    """The thesis: "no two consecutive samples are neighbors"; here across the repetition and the tiling as well."""
    cells = np.floor((thesis_4x4() + 0.5) * 4)
    step = np.abs(cells - np.roll(cells, 1, axis=0))
    assert (np.minimum(step, 4 - step).max(axis=1) >= 2).all()


def test_2x2_has_each_of_the_four_elements_in_every_target_pixel():
    """`Jitter::Custom(2)`: Halton(2,3)'s elements 2 to 5 are (1/4, 2/3), (3/4, 1/9), (1/8, 4/9), (5/8, 7/9)."""
    positions = (thesis_2x2() + 0.5) * 2
    elements = {(1 / 4, 2 / 3), (3 / 4, 1 / 9), (1 / 8, 4 / 9), (5 / 8, 7 / 9)}
    for pixel in np.ndindex(2, 2):
        inside = positions[(np.floor(positions) == pixel).all(axis=1)] - pixel
        np.testing.assert_allclose(sorted(inside.tolist()), sorted(elements), atol=1e-6)


def test_2x2_follows_an_hourglass_and_starts_each_turn_with_another_element():
    positions = ((thesis_2x2() + 0.5) * 2).reshape(4, 4, 2)
    for turn in positions:
        assert np.floor(turn).astype(int).tolist() == [[0, 0], [1, 1], [0, 1], [1, 0]]
    first = [round(float(x), 3) for x in positions[:, 0, 0]]
    assert first == [0.25, 0.75, 0.125, 0.625]  # the x of elements 2, 3, 4, 5 in pixel (0, 0)
    second = [round(float(x) - 1, 3) for x in positions[:, 1, 0]]
    assert second == [0.75, 0.125, 0.625, 0.25]


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


def test_supersampled_targets_have_the_levels_of_the_finer_image():
    """NSRR renders references at 4800x2700 for 1600x900, NSRD and QRISP at 2160p for 1080p; inputs stay as matched."""
    assert target_mip_bias("supersampled3") == pytest.approx(-1.585, abs=1e-3)
    assert target_mip_bias("supersampled2") == -1.0
    assert target_mip_bias("supersampled1") == target_mip_bias("matched")
    for scale in (2, 3, 4):
        assert mip_bias("supersampled3", scale) == mip_bias("matched", scale)


@pytest.mark.parametrize("name", ["hilbert", "halton", "haltonx", "halton0"])
def test_error_of_unknown_pattern(name):
    with pytest.raises(UserError, match=name):
        jitter_sequence(name, 4)
    for setting in ("soft", "supersampled", "supersampled0", "supersampledx"):
        with pytest.raises(UserError, match=f"task.mip_bias={setting}:"):
            mip_bias(setting, 4)
