import math

import pytest
import torch

from supersampling.metrics.base import Moment
from supersampling.metrics.image import PSNR_CAP
from supersampling.metrics.regions import Regions, disoccluded, region_psnr, static


def test_each_region_has_its_own_error():
    """One low-resolution pixel per target pixel, so that regions are exact: each region has a different error."""
    target = torch.full((1, 3, 8, 16), 0.5)
    motion, dual = torch.zeros(1, 2, 8, 16), torch.zeros(1, 2, 8, 16)
    motion[:, 0, :, 8:] = -2 / 16
    dual[:] = motion
    dual[:, 0, :4, 4:8] = -2 / 16  # hidden: 16 of 128 pixels, at rest themselves
    output = target.clone()
    output[..., 8:] += 0.1
    output[:, :, :4, 4:8] += 0.2
    values = Regions()(Moment(output=output, target=target, previous=(target, target), motion=motion, motion_dual=dual))
    assert values == pytest.approx(
        {
            "psnr_disoccluded": -20 * math.log10(0.2),
            "psnr_elsewhere": -10 * math.log10(64 * 0.01 / 112),
            "fraction_disoccluded": 16 / 128,
            "psnr_static": -10 * math.log10(16 * 0.04 / 64),
            "psnr_moving": 20.0,
            "fraction_static": 0.5,
        },
        abs=1e-4,
    )


def test_what_enters_the_image_has_no_history():
    motion = torch.zeros(1, 2, 4, 10)
    motion[:, 0] = 2.4 / 10  # the last two columns come from beyond the right border
    assert disoccluded(motion, motion, (4, 10))[0, 0, 0].tolist() == [False] * 8 + [True] * 2


@pytest.mark.parametrize(("pixels", "still"), [(0.0, True), (0.009, True), (0.011, False)])
@pytest.mark.parametrize("axis", [0, 1])
def test_static_counts_target_pixels_on_both_axes(pixels, still, axis):
    motion = torch.zeros(1, 2, 3, 5)
    motion[:, axis] = -pixels / (12, 6)[axis]
    assert (static(motion, (6, 12)) == still).all()


def test_edges():
    image, none = torch.full((1, 3, 4, 4), 0.3), torch.zeros(1, 1, 4, 4, dtype=torch.bool)
    assert math.isnan(region_psnr(image, image, none))
    assert region_psnr(image, image, ~none) == PSNR_CAP
    first = Regions()(
        Moment(output=image, target=image, motion=torch.zeros(1, 2, 2, 2), motion_dual=torch.zeros(1, 2, 2, 2))
    )
    assert tuple(first) == Regions.names
    assert all(math.isnan(value) for value in first.values())
