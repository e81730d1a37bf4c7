"""The numbers of the derived panels, against independent computations."""

import numpy as np
import pytest
from scipy.ndimage import map_coordinates
from show_files import write

from supersampling.data.dataset_file import DatasetFile
from supersampling.frames import BUFFERS
from supersampling.show.checks import check_warp, compare_warped, disoccluded, gradient_energy
from supersampling.show.clip import ClipView


def by_scipy(previous, target, velocity):
    """Mean errors with and without the warp over the pixels that come from within the image; ``velocity`` in its
    pixels."""
    _, height, width = target.shape
    y, x = np.mgrid[0:height, 0:width].astype(float)
    x, y = x - velocity[0], y - velocity[1]
    inside = (np.abs(2 * (x + 0.5) / width - 1) <= 1) & (np.abs(2 * (y + 0.5) / height - 1) <= 1)
    warped = np.stack([map_coordinates(c.astype(float), (y, x), order=1, mode="nearest") for c in previous])
    return tuple(np.abs(image - target)[:, inside].mean() for image in (warped, previous))


def test_warp_check_of_analytic_clip(make_file, tmp_path):
    file = DatasetFile(make_file(tmp_path, "test", frames=4))
    clip = ClipView(file, 1)
    velocity = -clip.read("motion", 3)[:, 0, 0] * 48
    check = check_warp(clip, 3)
    moved, still = by_scipy(clip.read("target", 2), clip.read("target", 3), velocity)
    assert check is not None
    assert check.mean == pytest.approx(moved, rel=1e-3)
    assert check.still_mean == pytest.approx(still, rel=1e-5)
    assert check.mean < 0.2 * check.still_mean
    file.close()


def test_previous_target_of_first_frame_is_missing(make_file, tmp_path):
    file = DatasetFile(make_file(tmp_path, "test", frames=4))
    assert check_warp(ClipView(file, 0), 0) is None
    assert check_warp(ClipView(file, 0, frozenset({"target"})), 2) is None
    file.close()


def test_clip_has_targets_for_its_last_frames_only(tmp_path):
    file = DatasetFile(write(tmp_path, ("motion", "target")))
    assert [t for t in range(5) if check_warp(ClipView(file, 0), t) is not None] == [3, 4]
    file.close()


def test_high_resolution_motion_is_preferred(tmp_path):
    """Zero there, far off at low resolution: the warp must change nothing."""
    motion = {"high_motion": np.zeros((48, 64, 2)), "motion": np.full((12, 16, 2), 0.5)}
    file = DatasetFile(write(tmp_path, ("motion", "high_motion", "target"), **motion))
    check = check_warp(ClipView(file, 0), 4)
    assert check is not None
    assert check.mean == check.still_mean
    assert check.inside.all()
    file.close()


def test_broken_vectors_are_left_out():
    image = np.random.default_rng(0).random((3, 8, 8), dtype=np.float32)
    motion = np.zeros((2, 8, 8), dtype=np.float32)
    motion[0, 2, 3], motion[1, 4, 5] = np.nan, np.inf
    check = compare_warped(image, image, motion)
    assert np.argwhere(~check.inside).tolist() == [[2, 3], [4, 5]]
    assert check.mean == 0.0


def test_no_pixel_inside_gives_nan():
    image = np.zeros((3, 4, 4), dtype=np.float32)
    assert np.isnan(compare_warped(image, image, np.full((2, 4, 4), 3.0, dtype=np.float32)).mean)


@pytest.mark.parametrize("axis", [0, 1])
def test_mask_threshold_is_in_low_resolution_pixels(axis):
    """0.1 pixels of an image 20 wide and 10 high, just below and just above, on either axis."""
    motion, dual = np.zeros((2, 10, 20), dtype=np.float32), np.zeros((2, 10, 20), dtype=np.float32)
    side = (20, 10)[axis]
    dual[axis, 3, 4], dual[axis, 5, 6] = 0.099 / side, -0.101 / side
    assert np.argwhere(disoccluded(motion, dual)).tolist() == [[5, 6]]


def test_gradient_energy_of_sine_and_of_its_multiples():
    """sin(a x) over whole periods: the mean squared step is 4 sin^2(a / 2) times the mean square, and nothing along
    y."""
    a = 2.0 * np.pi / 32
    image = np.broadcast_to(np.sin(a * (np.arange(3201) + 0.5)), (1, 5, 3201)).astype(np.float32)
    expected = 4.0 * np.sin(a / 2.0) ** 2
    assert gradient_energy(image) == pytest.approx(expected, rel=1e-3)
    assert gradient_energy(7.0 * image) == pytest.approx(gradient_energy(image), rel=1e-6)
    assert gradient_energy(np.zeros_like(image)) == 0.0


def test_clip_reports_its_buffers(tmp_path):
    file = DatasetFile(write(tmp_path, ("color", "target")))
    clip = ClipView(file, 0, frozenset(BUFFERS) - {"color"})
    frames = (("color", 4), ("depth", 4), ("target", 4), ("target", 1))
    assert [clip.has(*frame) for frame in frames] == [False, False, True, False]
    assert (clip.size, clip.low_size) == ((64, 48), (16, 12))
    file.close()
