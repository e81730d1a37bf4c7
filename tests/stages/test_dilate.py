import pytest
import torch

from supersampling.stages.dilate import ClosestDepth, NoDilation


def dilate_by_loops(motion, depth):
    b, _, h, w = motion.shape
    result = torch.empty_like(motion)
    for n in range(b):
        for i in range(h):
            for j in range(w):
                best = (i, j)
                for y in range(max(i - 1, 0), min(i + 2, h)):
                    for x in range(max(j - 1, 0), min(j + 2, w)):
                        if depth[n, 0, y, x] < depth[n, 0, best[0], best[1]]:
                            best = (y, x)
                result[n, :, i, j] = motion[n, :, best[0], best[1]]
    return result


@pytest.mark.parametrize(("h", "w"), [(5, 7), (1, 1), (1, 4)])
def test_takes_the_motion_of_the_nearest_neighbour(h, w):
    motion, depth = torch.randn(2, 2, h, w), torch.rand(2, 1, h, w)
    assert torch.equal(ClosestDepth()(motion, depth), dilate_by_loops(motion, depth))


def test_equal_depths_keep_the_motion_of_each_pixel():
    motion = torch.randn(1, 2, 5, 6)
    assert torch.equal(ClosestDepth()(motion, torch.ones(1, 1, 5, 6)), motion)


def test_no_dilation_needs_no_depth():
    motion = torch.randn(1, 2, 3, 3)
    assert torch.equal(NoDilation()(motion, None), motion)
    assert "depth" not in NoDilation.requires
