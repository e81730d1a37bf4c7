import math

import pytest
import torch

from supersampling.metrics.base import Moment
from supersampling.metrics.motion import PixelDistance, pixel_distance


def test_distance_is_to_the_closest_of_all_pixel_centres():
    """Constant motion, which upsampling keeps, against the distances to every centre around the image."""
    for dx, dy in ((3.0, -2.0), (0.25, 0.0), (1.7, -0.4), (-2.5, 0.5)):
        motion = torch.tensor([dx / 10, dy / 6], dtype=torch.float64)[None, :, None, None].expand(1, 2, 3, 5)
        distances = []
        for y in range(6):
            for x in range(10):
                px, py = x + 0.5 + dx, y + 0.5 + dy
                centres = [(j + 0.5, i + 0.5) for i in range(-4, 11) for j in range(-5, 16)]
                distances.append(min(math.hypot(px - cx, py - cy) for cx, cy in centres))
        expected = sum(distances) / len(distances)
        assert pixel_distance(motion, (6, 10)).tolist() == pytest.approx([expected], abs=1e-9)


def test_motion_without_a_preferred_distance_is_the_mean_over_a_square():
    torch.manual_seed(0)
    motion = torch.rand(2, 2, 200, 200, dtype=torch.float64)
    # The mean distance of a unit square's points to its centre: (sqrt 2 + ln(1 + sqrt 2)) / 6.
    expected = (math.sqrt(2) + math.log(1 + math.sqrt(2))) / 6
    assert pixel_distance(motion, (200, 200)).tolist() == pytest.approx([expected] * 2, abs=3e-3)


def test_first_frame_has_no_value_and_a_vertical_motion_reads_the_height():
    image = torch.zeros(1, 3, 8, 4)
    motion = torch.zeros(1, 2, 4, 2)
    motion[:, 1] = 0.25 / 8
    first = Moment(output=image, target=image, motion=motion)
    assert math.isnan(PixelDistance().measure(first)[0])
    second = Moment(output=image, target=image, motion=motion, previous=(image, image))
    assert PixelDistance()(second) == {"pixel_distance": pytest.approx(0.25)}
