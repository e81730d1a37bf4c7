"""Tests of dual motion vectors on squares that slide over a plane, where the disoccluded pixels are known exactly."""

import pytest
import torch

from supersampling.ops.dual_motion import dual_motion

SIZE, MARGIN = 48, 12


def sliding_square(
    step: tuple[int, int], start: tuple[int, int], side: int, background: tuple[int, int]
) -> tuple[torch.Tensor, ...]:
    """Render a square at depth 2 that moves by ``step`` pixels in front of a plane at depth 5 moving by ``background``.

    Returns the first five arguments of `dual_motion`, and the disoccluded band: the pixels of the plane whose points
    were behind the square in the previous frame.
    """

    def inside(offset: tuple[int, int], margin: int) -> torch.Tensor:
        rows, columns = torch.meshgrid(*[torch.arange(-margin, SIZE + margin)] * 2, indexing="ij")
        x, y = start[0] + offset[0], start[1] + offset[1]
        return (columns >= x) & (columns < x + side) & (rows >= y) & (rows < y + side)

    def field(mask: torch.Tensor, sign: float) -> torch.Tensor:
        front, back = (torch.tensor(v, dtype=torch.float32)[:, None, None] for v in (step, background))
        return sign * torch.where(mask, front, back)[None]

    now, before = inside(step, 0), inside((0, 0), MARGIN)
    depth = [torch.where(mask, 2.0, 5.0)[None, None] for mask in (now, before)]
    band = torch.zeros_like(now)
    for i in range(SIZE):
        for j in range(SIZE):
            if not now[i, j]:
                y, x = i - background[1] + MARGIN, j - background[0] + MARGIN
                band[i, j] = bool(before[y, x])
    return field(now, -1.0), depth[0], torch.zeros(1, 2), field(before, 1.0), depth[1], band


CASES = [((5, 0), (0, 0)), ((-3, 2), (0, 0)), ((4, -6), (1, 2)), ((0, 0), (3, 0)), ((2, 2), (2, 2))]


@pytest.mark.parametrize(("step", "background"), CASES)
def test_vectors_differ_only_on_the_disoccluded_band(step, background):
    *inputs, band = sliding_square(step, (16, 18), 12, background)
    dual = dual_motion(*inputs, MARGIN)
    marked = ((dual - inputs[0]).abs() >= 0.1).any(dim=1)[0]
    relative_motion = step != background
    assert bool(band.any()) == relative_motion
    torch.testing.assert_close(marked, band)
    if relative_motion:
        # In the band, the vector is the occluder's motion.
        expected = -torch.tensor(step, dtype=torch.float32)
        torch.testing.assert_close(dual[0][:, band], expected[:, None].expand(2, int(band.sum())))


def test_jitter_within_the_pixel_does_not_change_the_band():
    *inputs, band = sliding_square((5, 3), (16, 18), 12, (0, 0))
    for jitter in ((0.49, -0.49), (-0.5, 0.3)):
        inputs[2] = torch.tensor([jitter])
        marked = ((dual_motion(*inputs, MARGIN) - inputs[0]).abs() >= 0.1).any(dim=1)[0]
        torch.testing.assert_close(marked, band)


def test_slanted_plane_does_not_occlude_itself():
    """A plane at a steep angle, with a motion that changes from pixel to pixel: nothing is occluded."""
    column = torch.arange(SIZE + 2 * MARGIN, dtype=torch.float32)
    inverse = (0.02 + 0.01 * column).expand(SIZE + 2 * MARGIN, -1)
    visible_depth = (1.0 / inverse)[None, None]
    motion = torch.zeros(1, 2, SIZE, SIZE)
    motion[:, 0] = torch.linspace(-4.4, 4.4, SIZE)
    rows = torch.arange(SIZE) + 0.5
    position = MARGIN - 0.5 + rows + motion[0, 0, 0]
    previous_depth = (1.0 / (0.02 + 0.01 * position)).expand(SIZE, -1)[None, None]
    forward = torch.zeros(1, 2, *visible_depth.shape[2:])
    dual = dual_motion(motion, previous_depth, torch.zeros(1, 2), forward, visible_depth, MARGIN)
    torch.testing.assert_close(dual, motion, rtol=0, atol=0)


def test_vectors_are_equal_outside_the_image_behind_the_camera_and_in_the_sky():
    *inputs, _ = sliding_square((5, 0), (16, 18), 12, (0, 0))
    far = inputs[0].clone()
    far[:, :, 0] = 1000.0
    # Behind the previous camera.
    inputs[1][:, :, 1] = -3.0
    inputs[0] = far
    dual = dual_motion(*inputs, MARGIN)
    assert torch.isfinite(dual).all()
    torch.testing.assert_close(dual[:, :, :2], far[:, :, :2], rtol=0, atol=0)
    sky = torch.full((1, 1, SIZE, SIZE), torch.inf)
    all_sky = torch.full((1, 1, SIZE + 2 * MARGIN, SIZE + 2 * MARGIN), torch.inf)
    still = torch.zeros(1, 2, SIZE, SIZE)
    moved = torch.ones(1, 2, SIZE + 2 * MARGIN, SIZE + 2 * MARGIN)
    assert (dual_motion(still, sky, torch.zeros(1, 2), moved, all_sky, MARGIN) == 0).all()
