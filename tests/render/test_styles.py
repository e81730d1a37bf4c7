from itertools import pairwise

import numpy as np
import pytest
from camera_measures import ROUTE, ROUTES, STYLES, eyes, path, speeds, spins, stands, stop_lengths

from supersampling.errors import UserError


@pytest.mark.parametrize("style", STYLES)
def test_equal_seeds_give_equal_paths_and_others_differ(style):
    a, b, c = (path(style, seed, 12) for seed in (4, 4, 5))
    assert a.seconds == b.seconds
    assert all((x.view == y.view).all() for x, y in zip(a.cameras, b.cameras))
    assert not (a.cameras[3].view == c.cameras[3].view).all()


@pytest.mark.parametrize("on", ROUTES, ids=lambda r: r.name)
@pytest.mark.parametrize("style", STYLES)
def test_every_style_works_on_every_route(style, on):
    for frames in (1, 2, 40):
        for seed in range(4):
            p = path(style, seed, frames, on)
            assert len(p.cameras) == len(p.seconds) == frames
            for camera in p.cameras:
                axes = camera.view[:3, :3]
                np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-9)
                assert np.linalg.det(axes) == pytest.approx(1.0)
                assert abs(axes[2, 1]) < 0.95  # the viewing direction's height: never near vertical
                assert camera.fov == on.fov


# Degrees a second, degrees a second squared, metres a second, metres a second squared. For head by hand: a 90 degree
# turn peaks at 250 * 1.15; a minimum-jerk move accelerates by at most 5.774 A / T^2 = 1.642 peak^2 / A; 1.2 m/s
# strolling, 1.875 * 0.32 / 0.6 leaning, 0.025 * 2 pi * 2.1 bobbing and 0.11 m of neck at 5 radians a second.
BOUNDS = {
    "walk": (70, 400, 2.2, 20),
    "head": (320, 1700, 3.1, 25),
    "stops": (90, 1000, 3.0, 35),
    "fast": (250, 1000, 10.5, 70),
    "still": (1e-9, 1e-9, 1e-9, 1e-9),
}


@pytest.mark.parametrize("style", BOUNDS)
def test_no_camera_jumps_or_jerks(style):
    turn, turning, speed, pull = BOUNDS[style]
    for seed in range(40):
        p = path(style, seed, 100)
        spin, velocity = spins(p), np.diff(eyes(p), axis=0) * 60
        assert np.linalg.norm(spin, axis=1).max() <= turn
        assert np.linalg.norm(np.diff(spin, axis=0), axis=1).max() * 60 <= turning
        assert np.linalg.norm(velocity, axis=1).max() <= speed
        assert np.linalg.norm(np.diff(velocity, axis=0), axis=1).max() * 60 <= pull


@pytest.mark.parametrize(
    ("style", "reach"), [("walk", 0.4), ("stops", 0.5), ("fast", 0.5), ("still", 0.5), ("head", 0.9)]
)
def test_eyes_stay_near_the_route(style, reach):
    """Corners are rounded; a head moves about its route besides."""
    line = np.concatenate([np.linspace(a, b, 200) for a, b in pairwise(ROUTE.points)])
    for seed in range(20):
        eye = eyes(path(style, seed, 24))
        assert np.linalg.norm(eye[:, None] - line, axis=2).min(axis=1).max() < reach
        assert style == "head" or eye[:, 1] == pytest.approx(1.6)


def test_walking_paths_stay_what_they_were():
    """One view of the first published data sets: their seeds give them again."""
    before = (
        (0.952140822, 0.0, -0.305659704, -0.690123763),
        (0.012080039, 0.999218732, 0.03762975, -1.513788895),
        (0.305420902, -0.039521202, 0.951396945, 2.211314387),
    )
    p = path("walk", 7, 24)
    np.testing.assert_allclose(p.cameras[20].view[:3], before, atol=1e-8)
    assert p.seconds[0] == pytest.approx(37.33075376646976)


def test_some_walkers_stand_exactly_still_for_a_while_and_all_move():
    standing = 0
    for seed in range(40):
        same = stands(path("walk", seed, 24))
        assert not all(same)
        standing += sum(same) >= 6
    assert 10 <= standing <= 30


def test_still_cameras_stand_exactly_still_in_different_places():
    views = []
    for seed in range(20):
        p = path("still", seed)
        assert all(stands(p))
        views.append(p.cameras[0].view)
    assert len({v.tobytes() for v in views}) == 20
    assert len({p.seconds for p in (path("still", 1), path("still", 2))}) == 2


@pytest.mark.parametrize("seed", range(25))
def test_stops_last_ten_frames_and_the_travel_goes_on(seed):
    """QRISP, annex A.3: "the camera usually stayed stationary for 10 frames"; its training segments have 30."""
    assert stop_lengths(path("stops", seed, 30)) == [10]
    many = path("stops", seed, 300)
    assert set(stop_lengths(many)) == {10}
    assert 4 <= len(stop_lengths(many)) <= 11
    steps = np.linalg.norm(np.diff(eyes(many), axis=0), axis=1)
    assert np.count_nonzero(steps > 1e-4) > 150  # it travels at least half of the time


def test_fast_cameras_travel_and_turn_faster_than_walkers():
    def means(style: str) -> tuple[float, float]:
        clips = [path(style, seed, 100) for seed in range(40)]
        travel = [np.linalg.norm(np.diff(eyes(p), axis=0), axis=1).mean() * 60 for p in clips]
        return float(np.mean(travel)), float(np.mean([speeds(p).mean() for p in clips]))

    (walk, glance), (fast, turn) = means("walk"), means("fast")
    assert fast > 3 * walk
    assert turn > max(2 * glance, 30)


def test_mixed_clips_are_each_one_of_the_others():
    kinds = {"still": 0, "stops": 0, "head": 0, "fast": 0, "walk": 0}
    for seed in range(100):
        p = path("mixed", seed, 60)
        travel = np.linalg.norm(np.diff(eyes(p), axis=0), axis=1).mean() * 60
        if all(stands(p)):
            kinds["still"] += 1
        elif stop_lengths(p)[:1] == [10]:
            kinds["stops"] += 1
        elif np.ptp(eyes(p)[:, 1]) > 1e-3:
            kinds["head"] += 1
        else:
            kinds["fast" if travel > 2.5 else "walk"] += 1
    assert min(kinds.values()) >= 8


def test_error_of_unknown_style():
    with pytest.raises(UserError, match="camera=run: use walk, head, stops, fast, still, mixed"):
        path("run")
