"""Colours mean what the labels say."""

import colorsys

import numpy as np
import pytest

from supersampling.show import paint

DIRECTIONS = {"right": (1, 0), "left": (-1, 0), "down": (0, 1), "up": (0, -1)}


def vectors(*pairs):
    """``(2, 1, N)``."""
    return np.array(pairs, dtype=np.float32).T[:, None, :]


def hue(rgb):
    return 360.0 * colorsys.rgb_to_hsv(*(float(c) / 255.0 for c in rgb))[0]


def test_directions_have_the_hues_of_the_wheel():
    """Baker et al. 2007: right is red, down yellow, left cyan, up violet."""
    picture = paint.motion(vectors(*DIRECTIONS.values()), 1.0)[0]
    hues = dict(zip(DIRECTIONS, map(hue, picture)))
    assert min(hues["right"], 360.0 - hues["right"]) < 20.0
    assert hues["down"] == pytest.approx(60.0, abs=25.0)
    assert hues["left"] == pytest.approx(180.0, abs=25.0)
    assert hues["up"] == pytest.approx(265.0, abs=30.0)


def test_no_motion_is_white_and_length_is_saturation():
    picture = paint.motion(vectors((0, 0), (0.25, 0), (0.5, 0), (1, 0), (7, 0)), 1.0)[0].astype(int)
    saturation = picture.max(axis=1) - picture.min(axis=1)
    assert picture[0].tolist() == [255, 255, 255]
    assert np.allclose(saturation[:4] / 255.0, (0.0, 0.25, 0.5, 1.0), atol=0.01)
    assert (picture[4] == picture[3]).all()  # beyond the scale: as at its end


def test_scale_does_not_depend_on_the_rest_of_the_picture():
    alone, beside = paint.motion(vectors((1, 1)), 4.0), paint.motion(vectors((1, 1), (3, -2)), 4.0)
    assert (alone[0, 0] == beside[0, 0]).all()


def test_motion_that_fills_the_scale_never_wraps_around():
    """Every channel is continuous in direction; a value that rounds below 0 would turn up as 255."""
    angle = np.linspace(0.0, 2.0 * np.pi, 20001)
    for full in (0.19, 1.0, 33.3):
        picture = paint.motion(full * np.stack((np.cos(angle), np.sin(angle))).astype(np.float32)[:, None], full)
        assert np.abs(np.diff(picture[0].astype(int), axis=0)).max() <= 2


def test_depth_is_monotone_and_the_sky_apart():
    values = np.array([[[0.1, 0.2, 0.4, 0.8, 1.0]]], dtype=np.float32)
    picture = paint.depth(values, 0.1, 0.8)[0].astype(int)
    luma = picture @ (0.2126, 0.7152, 0.0722)
    assert (np.diff(luma) < 0).all()
    assert picture[4].max() < 24


def test_depth_of_one_plane_does_not_divide_by_zero():
    assert np.isfinite(paint.depth(np.full((1, 2, 2), 0.5, dtype=np.float32), 0.5, 0.5)).all()


def test_objects_differ_and_keep_their_colour():
    numbers = np.arange(0, 60, dtype=np.float32)[None, None]
    picture = paint.ids(numbers)[0]
    assert len({tuple(c) for c in picture.tolist()}) == 60
    assert (paint.ids(numbers[..., 7:8])[0, 0] == picture[7]).all()


def test_reflectance_goes_through_the_srgb_curve():
    values = np.array([0.0, 0.0031308, 0.215861, 1.0, 1.5], dtype=np.float32)
    picture = paint.reflectance(np.stack([values[None]] * 3))
    assert picture[0, :, 0].tolist() == [0, 10, 128, 255, 255]  # IEC 61966-2-1


def test_stop_doubles():
    dim, bright = np.full((3, 1, 1), 0.1, dtype=np.float32), np.full((3, 1, 1), 0.4, dtype=np.float32)
    assert (paint.light(dim, 2) == paint.light(bright, 0)).all()


def test_normal_towards_the_camera_is_the_usual_blue():
    assert paint.normal(np.array([0, 0, 1], dtype=np.float32)[:, None, None])[0, 0].tolist() == [128, 128, 255]


def test_mask_is_red_and_other_pixels_are_not():
    picture = np.full((2, 2, 3), (200, 40, 40), dtype=np.uint8)  # reddish itself
    mask = np.array([[True, False], [False, False]])
    excess = paint.masked(picture, mask).astype(int) @ (1.0, -0.5, -0.5)
    assert excess[0, 0] > 200
    assert (excess[~mask] < 100).all()
