import pytest
import torch

from supersampling.errors import UserError
from supersampling.stages.motion_grid import BilinearMotion, FrontmostOfBlock


def frontmost_by_loops(motion, depth, scale, block):
    """Return the motion of section 4.1, pixel by pixel at target resolution."""
    b, _, h, w = motion.shape
    height, width = h * scale, w * scale
    result = torch.empty(b, 2, height, width, dtype=motion.dtype)
    for n in range(b):
        for top in range(0, height, block):
            for left in range(0, width, block):
                rows, columns = range(top, min(top + block, height)), range(left, min(left + block, width))
                pixels = [(i // scale, j // scale) for i in rows for j in columns]
                front = min(pixels, key=lambda p: (depth[n, 0, p[0], p[1]].item(), p))
                for i in rows:
                    for j in columns:
                        result[n, :, i, j] = motion[n, :, front[0], front[1]]
    return result


@pytest.mark.parametrize("scale", [1, 2, 3, 4, 5, 6])
@pytest.mark.parametrize(("h", "w"), [(1, 1), (5, 7), (8, 4)])
def test_blocks_take_the_motion_of_their_frontmost_pixel(scale, h, w):
    motion, depth = torch.randn(2, 2, h, w), torch.rand(2, 1, h, w)
    expected = frontmost_by_loops(motion, depth, scale, 8)
    assert torch.equal(FrontmostOfBlock(8)(motion, depth, scale), expected)


@pytest.mark.parametrize("block", [1, 3, 4, 16])
def test_other_block_sizes(block):
    motion, depth = torch.randn(1, 2, 4, 5), torch.rand(1, 1, 4, 5)
    expected = frontmost_by_loops(motion, depth, 4, block)
    assert torch.equal(FrontmostOfBlock(block)(motion, depth, 4), expected)


def test_of_equal_depths_the_first_wins():
    motion, depth = torch.randn(1, 2, 5, 6), torch.ones(1, 1, 5, 6)
    assert torch.equal(FrontmostOfBlock(8)(motion, depth, 2), frontmost_by_loops(motion, depth, 2, 8))


@pytest.mark.parametrize("stage", [FrontmostOfBlock(8), BilinearMotion()])
def test_uniform_motion_stays_uniform(stage):
    motion = torch.tensor([0.25, -0.5]).view(1, 2, 1, 1).expand(2, 2, 5, 3)
    grid = stage(motion, torch.rand(2, 1, 5, 3), 3)
    torch.testing.assert_close(grid, motion[..., :1, :1].expand(2, 2, 15, 9))


@pytest.mark.parametrize("stage", [FrontmostOfBlock(8), BilinearMotion()])
def test_gradient_by_motion(stage):
    depth = torch.rand(1, 1, 3, 4, dtype=torch.float64)
    motion = torch.randn(1, 2, 3, 4, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda m: stage(m, depth, 3), (motion,))


def test_without_dilation_motion_is_interpolated_between_pixel_centres():
    motion, scale = torch.randn(1, 2, 4, 3), 2
    grid = BilinearMotion()(motion, torch.rand(1, 1, 4, 3), scale)
    for i in range(8):
        for j in range(6):
            y = min(max((i + 0.5) / scale - 0.5, 0.0), 3.0)
            x = min(max((j + 0.5) / scale - 0.5, 0.0), 2.0)
            top, left = int(y), int(x)
            below, right = min(top + 1, 3), min(left + 1, 2)
            fy, fx = y - top, x - left
            expected = (1 - fy) * ((1 - fx) * motion[0, :, top, left] + fx * motion[0, :, top, right]) + fy * (
                (1 - fx) * motion[0, :, below, left] + fx * motion[0, :, below, right]
            )
            torch.testing.assert_close(grid[0, :, i, j], expected)


def test_invalid_block_raises():
    with pytest.raises(UserError, match=r"Invalid motion_grid\.block=0: use at least 1"):
        FrontmostOfBlock(0)
