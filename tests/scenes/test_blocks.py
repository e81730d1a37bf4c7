"""The fast boxes, beams, quads and panels equal those of `shapes`."""

import numpy as np
import pytest

from supersampling.scenes.kit import blocks, shapes

CASES = [
    ("box", ((1, 2, 3), (4, 5, 6)), {}),
    ("box", ((1, 2, 3), (4, 5, 6), ("top", "left", "back")), {"fit": True}),
    ("beam", ((1, 2, 3), (4, 5, 7), 0.2, 0.3), {}),
    ("beam", ((0, 0, 1), (0, 0, 4), 0.2), {}),
    ("quad", ((1, 2, 3), (0, 0, 5), (1, -2, 0)), {}),
    ("panel", ((1, 2, 3), (0, 5, 0), (2, 0, 0)), {}),
]


@pytest.mark.parametrize(("name", "arguments", "options"), CASES)
def test_equal_to_shapes(name, arguments, options):
    quick = getattr(blocks, name)(*arguments, **options)
    slow = getattr(shapes, name)(*arguments, **options)
    for part in ("positions", "normals", "uv", "triangles"):
        np.testing.assert_allclose(getattr(quick, part), getattr(slow, part), atol=1e-12)
