"""Motion vectors of the built-in scenes: albedo of the previous frame, warped, is the albedo of this one."""

from dataclasses import replace

import pytest
from built_scenes import built

from supersampling.render.measure.motion import places, reprojection
from supersampling.render.measure.probe import Probe, seeded_shots
from supersampling.scenes.built_in import BUILT_IN
from supersampling.scenes.scene import Scene

SIDE = 384  # samples, at 4 x 4 a pixel of a 1080p target


def without_lamps(scene: Scene) -> Scene:
    """Return the scene without lights: albedo needs none, and shadow maps cost time."""
    return replace(scene, points=(), sun=None)


@pytest.mark.parametrize("name", BUILT_IN)
def test_warped_albedo_equals_albedo(name):
    scene = without_lamps(built(name))
    sums = [[0.0, 0], [0.0, 0]]
    with Probe(scene) as probe:
        for shot in seeded_shots(probe.scene, 2):
            for window in places(probe, shot, SIDE):
                error = reprojection(probe, window)
                for total, part in zip(sums, (error.still, error.moving)):
                    total[0] += part[0]
                    total[1] += part[1]
    assert sum(count for _, count in sums) > 20_000
    for what, (total, count) in zip(("camera", "objects"), sums):
        if count > 500:
            assert total / count <= 1.0 / 255.0, what
