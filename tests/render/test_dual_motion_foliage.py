"""Dual motion vectors behind alpha-tested leaves, against leaves that are known in closed form."""

import numpy as np
from analytic_scenes import camera, pixel_points, project, whole
from leaf_scenes import foliage, layer, seen

from supersampling.render.camera import Shot
from supersampling.render.renderer import Renderer

SCALE = 4
WINDOW = whole(96 * SCALE, 96 * SCALE)
BACK = 9.0


def test_dual_motion_is_that_of_the_leaf_that_the_previous_frame_showed_there():
    """Leaves are 0.8 low-resolution pixels wide: at mip bias 0 they dissolve, at the default -2 they do not."""
    leaves = layer(3.0, 3.0 * np.tan(0.5) * 128 * 0.8 / 96, 1)
    now, before = camera((0.08, 0.03, 0.0)), camera()
    pixels = pixel_points(WINDOW, SCALE, (0.0, 0.0))
    ids, place = seen([leaves], BACK, now, WINDOW, pixels)
    # The pixel of the previous frame that contains the point's previous position, and the surface at its centre.
    index = np.floor(project(before, WINDOW, place) / SCALE)
    occluder, hit = seen([leaves], BACK, before, WINDOW, (index + 0.5) * SCALE)
    hidden = (occluder == 2) & (ids == 1)
    mover = np.where(hidden[..., None], hit, place)
    expected = (project(before, WINDOW, mover) - project(now, WINDOW, mover)) / SCALE
    with Renderer(foliage([leaves], BACK), 64) as draw:
        names = frozenset({"motion_dual", "object_id"})
        out = draw.low(Shot(now, before, 1.0, 0.0, WINDOW), SCALE, (0.0, 0.0), -2.0, names)
    # The rest are corners of leaves, which filtering rounds.
    assert (out["object_id"][..., 0] == ids).mean() > 0.99
    right = np.abs(out["motion_dual"] * 96 - expected).max(axis=-1) < 0.01
    assert hidden.sum() > 1000
    assert right[hidden].mean() > 0.99
    assert right[~hidden].mean() > 0.99
