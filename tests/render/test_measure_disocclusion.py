"""Measures of disocclusion, and of what its mask misses, against scenes that are known in closed form."""

import numpy as np
import pytest
from analytic_scenes import camera, pixel_points, project, scene, shift, turn, wall
from leaf_scenes import foliage, layer, seen
from measured_scenes import FOCAL, MATTE, moment, sliding

from supersampling.render.measure import probe as probe_module
from supersampling.render.measure.disocclusion import (
    CAUSES,
    SCALE,
    Disocclusion,
    agreement,
    disocclusion,
    near_agreement,
)
from supersampling.render.measure.probe import Probe, whole
from supersampling.render.measure.scene import agreements

SMALL = (640, 384)  # of a frame
BACK = 9.0
PIXEL = 2.0 * np.tan(0.5) * SCALE / SMALL[1]  # side of a low-resolution pixel at a depth of 1 m, metres


@pytest.fixture
def small(monkeypatch) -> None:
    monkeypatch.setattr(probe_module, "FRAME", SMALL)


def test_disocclusion_is_the_band_behind_a_sliding_square():
    # In 1/60 s it moves by 0.4 m, and leaves a band as wide.
    world = sliding(-4.0, 24.0)
    step = 0.4 * FOCAL / 4.0 / 4.0  # low-resolution pixels
    height = 2.0 * FOCAL / 4.0 / 4.0
    with Probe(world) as probe:
        measured = disocclusion(probe, moment(camera(), seconds=1 / 60))
    for band in (measured.hidden, measured.by_object):
        assert band.sum() == pytest.approx(step * height, rel=0.03)
        columns = np.nonzero(band.any(axis=0))[0]
        left = 240.0 - 1.0 * FOCAL / 16.0
        assert columns.min() == pytest.approx(left, abs=1.0)
        assert columns.max() == pytest.approx(left + step, abs=1.0)
    for name, (right, marked, hit_, true) in agreements(measured).items():
        share = 0.999 if name.endswith("near") else 0.95
        assert right / marked >= share, name
        assert hit_ / true >= share, name


def leaves(size: float) -> list:
    """Return three layers of leaves of ``size`` low-resolution pixels."""
    return [layer(depth, depth * PIXEL * size * 64, seed) for seed, depth in enumerate((3.0, 4.0, 6.0))]


def counts(measured: Disocclusion) -> dict[str, int]:
    return dict(zip(CAUSES, np.bincount(measured.cause.ravel(), minlength=len(CAUSES) + 1)[1:].tolist()))


def test_leaves_before_a_camera_that_only_turns_uncover_nothing(small):
    """Without parallax nothing is uncovered, though one sample per pixel shows other leaves in each frame."""
    shot = moment(camera(rotation=turn(0.0123, 0.0077)), camera(), window=whole(1))
    with Probe(foliage(leaves(0.8), BACK)) as probe:
        level = disocclusion(probe, shot)
        finer = disocclusion(probe, shot, 0.0, 3.0)
    assert not level.mask.any()
    assert level.certain.mean() < 0.001
    assert counts(level)["together"] == level.certain.sum()
    # At the level of the low resolution leaves dissolve: its pixels show what finer levels cover in both frames.
    assert finer.veiled.mean() > 0.05


def test_hidden_pixels_and_the_mask_are_those_of_leaves_in_closed_form(small):
    layers = leaves(2.2)
    before = camera()
    shot = moment(camera((0.041, 0.017, 0.0)), before, window=whole(1))
    _, place = seen(layers, BACK, shot.camera, shot.window, pixel_points(shot.window, SCALE, (0.0, 0.0)))
    position = project(before, shot.window, place)
    # The surface at the exact position in the previous frame, and at the centre of the low-resolution pixel there.
    front, sampled = (
        seen(layers, BACK, before, shot.window, points)[1][..., 2] > place[..., 2] + 0.1
        for points in (position, (np.floor(position / SCALE) + 0.5) * SCALE)
    )
    with Probe(foliage(layers, BACK)) as probe:
        measured = disocclusion(probe, shot)
    # The truth knows edges to a sample, and filtering rounds their corners.
    right, marked, correct, true = agreement(measured.hidden, front, measured.inside)
    assert true > 1000
    assert right / marked > 0.97
    assert correct / true > 0.98
    # Pixels within a sample of a leaf's edge are not certain: a sixteenth of a leaf on each side.
    right, marked, correct, true = agreement(measured.certain, front, measured.inside)
    assert right / marked > 0.98
    assert correct / true > 0.9
    causes = counts(measured)
    assert causes["marked"] == pytest.approx((measured.certain & sampled).sum(), rel=0.02)
    assert causes["together"] + causes["parallel"] == 0


@pytest.mark.parametrize(
    ("cause", "left", "right", "bar_step", "wall_step"),
    [
        # The left edge of a bar passes the centres of a column of pixels, by less than the threshold.
        ("parallel", -0.08, 9.0, 0.085, 0.0),
        # It passes them by more.
        ("marked", -0.48, 9.0, 0.5, 0.0),
        # A thin bar between two columns hid points of the wall, which have moved to the centres of one.
        ("sample", 0.26, 0.6, -1.0, -0.4),
    ],
)
def test_causes_are_known_in_closed_form(small, cause, left, right, bar_step, wall_step):
    """Positions and steps are in low-resolution pixels, from the centre of a column."""
    column = 20  # right of the middle
    near, far = 4.0 * PIXEL, 10.0 * PIXEL
    bar = wall((column + 0.5 + left) * near, (column + 0.5 + right) * near, -1.0, 1.0, -4.0)
    world = scene(
        [MATTE],
        [wall(-20, 20, -12, 12, -10.0), bar],
        [lambda t: shift(wall_step * far * t, 0, 0), lambda t: shift(bar_step * near * t, 0, 0)],
    )
    with Probe(world) as probe:
        measured = disocclusion(probe, moment(camera(), seconds=1.0, window=whole(1)))
    height = int(measured.certain.any(axis=1).sum())
    assert height == pytest.approx(2.0 / near, abs=1.0)
    assert counts(measured)[cause] == measured.certain.sum() == height
    assert measured.certain[:, SMALL[0] // SCALE // 2 + column].sum() == height


def test_agreement_counts_by_hand():
    mask, truth = np.zeros((5, 7), bool), np.zeros((5, 7), bool)
    mask[1, 1] = mask[1, 2] = mask[4, 6] = True
    truth[1, 2] = truth[2, 3] = truth[4, 0] = True
    judged = np.ones_like(mask)
    assert agreement(mask, truth, judged).tolist() == [1, 3, 1, 3]
    assert near_agreement(mask, truth, truth, truth, judged).tolist() == [2, 3, 2, 3]
    nearly = truth.copy()
    nearly[4, 6] = True
    surely = truth.copy()
    surely[4, 0] = False
    assert near_agreement(mask, truth, nearly, surely, judged).tolist() == [3, 3, 2, 2]
    judged[4] = False
    assert agreement(mask, truth, judged).tolist() == [1, 2, 1, 2]
