"""Positions of samples, against scenes whose colour and motion are known in closed form at every point."""

import pytest
import torch

from supersampling.frames import Frame
from supersampling.ops.chain import chain
from supersampling.ops.warp import warp
from supersampling.stages.locate import LocatedByJitter, Unlocated
from supersampling.stages.motion_mask import DualMotionMask

H, W = 24, 30
JITTERS = torch.tensor([[0.3, -0.4], [-0.45, 0.1], [0.15, 0.45], [-0.2, -0.3]], dtype=torch.float64)
# A slide and a zoom: the position one frame ago of a point at (x, y), in pixels.
SLIDE = (lambda x, y: (x - 0.7, y + 1.2), "slide")
ZOOM = (lambda x, y: (15 + (x - 15) / 1.06 - 0.4, 12 + (y - 12) / 1.06), "zoom")
STILL = (lambda x, y: (x, y), "still")
MOTIONS = pytest.mark.parametrize("before", [m[0] for m in (SLIDE, ZOOM, STILL)], ids=["slide", "zoom", "still"])


def centres(h=H, w=W):
    y, x = torch.meshgrid(torch.arange(h).double() + 0.5, torch.arange(w).double() + 0.5, indexing="ij")
    return x, y


def light(x, y):
    return torch.stack((torch.sin(0.35 * x + 0.2 * y), torch.cos(0.15 * x - 0.3 * y)))[None]


def scene(before, t, x, y):
    """Return the light at ``(x, y)`` of frame ``t``: that of the point's position in frame 0."""
    for _ in range(t):
        x, y = before(x, y)
    return light(x, y)


def shot(before, t):
    """Return what a renderer does: light at the samples, and the frame with their motion."""
    x, y = centres()
    x, y = x + JITTERS[t, 0], y + JITTERS[t, 1]
    was_x, was_y = before(x, y)
    motion = torch.stack(((was_x - x) / W, (was_y - y) / H))[None]
    return scene(before, t, x, y), Frame(motion=motion, motion_dual=motion, jitter=JITTERS[t : t + 1])


def inner(image):
    return image[..., 5:-5, 5:-5]


def vectors_to_all(stage, before, last=3, mask=None):
    """Return the vectors of frame ``last`` to each frame before it, as NSRD adds them up."""
    mask = mask or DualMotionMask()
    earlier, memory = (), ()
    for t in range(last + 1):
        _, frame = shot(before, t)
        vectors = mask.vectors(frame) if t else torch.zeros(1, 4, H, W, dtype=torch.float64)
        earlier = chain(stage.between_samples(vectors, frame, memory), earlier)
        memory = stage.remember(frame)
    return earlier


def largest_error(stage, before):
    """Return the largest errors between the samples of the last frame and those of each previous one, warped to it."""
    now, _ = shot(before, 3)
    return [
        inner(warp(shot(before, 2 - k)[0], vectors[:, :2]) - now).abs().max().item()
        for k, vectors in enumerate(vectors_to_all(stage, before)[:3])
    ]


# Bilinear interpolation is off by at most an eighth of the second derivatives, at steps of one pixel.
BOUND = (0.35**2 + 0.2**2 + 2 * 0.35 * 0.2) / 8


@MOTIONS
def test_warped_samples_are_the_current_ones_to_interpolation_error(before):
    assert max(largest_error(LocatedByJitter(), before)) < BOUND


@MOTIONS
def test_unlocated_samples_are_displaced(before):
    assert min(largest_error(Unlocated(), before)) > 3 * BOUND


def test_whole_steps_of_samples_are_followed_exactly():
    """Motion and jitter that move a sample exactly onto another one: nothing is interpolated."""
    x, y = centres()
    now = Frame(motion=torch.full((1, 2, H, W), 0.0, dtype=torch.float64), jitter=torch.tensor([[0.25, -0.5]]).double())
    now.motion[:, 0], now.motion[:, 1] = -1.75 / W, 2.5 / H
    before = torch.tensor([[0.5, 0.0]]).double()
    vectors = LocatedByJitter().between_samples(now.motion, now, (before,))
    expected = light(x + 0.25 - 1.75, y - 0.5 + 2.5)  # the scene at the points' positions in the previous frame
    actual = warp(light(x + 0.5, y), vectors)
    torch.testing.assert_close(inner(actual), inner(expected), rtol=0, atol=1e-10)


@MOTIONS
def test_motion_at_target_is_that_of_target_pixel_centres(before):
    """All three motions are linear in the position, so bilinear interpolation is exact away from the border."""
    scale, (_, frame) = 3, shot(before, 1)
    x, y = (c / scale for c in centres(H * scale, W * scale))
    was_x, was_y = before(x, y)
    exact = torch.stack(((was_x - x) / W, (was_y - y) / H))[None]
    actual = LocatedByJitter().at_target(frame.motion, frame, scale)
    torch.testing.assert_close(inner(actual), inner(exact), rtol=0, atol=1e-12)
    ignored = Unlocated().at_target(frame.motion, frame, scale)
    off = inner(ignored - exact).abs().max().item()
    assert (off > 1e-4) == (before is ZOOM[0])


def test_previous_output_is_warped_without_jitter():
    """An output lies at the target's pixel centres in both frames: a slide by whole target pixels copies it."""
    scale, output = 2, torch.rand(1, 3, 2 * H, 2 * W)
    motion = torch.zeros(1, 2, H, W)
    motion[:, 0] = 3 / (2 * W)
    frame = Frame(motion=motion, jitter=JITTERS[:1].float())
    moved = warp(output, LocatedByJitter().at_target(motion, frame, scale))
    torch.testing.assert_close(moved[..., :-3], output[..., 3:], rtol=0, atol=1e-4)
    still = torch.zeros(1, 2, H, W)
    assert torch.equal(warp(output, LocatedByJitter().at_target(still, frame, scale)), output)


def test_the_mask_of_a_still_scene_is_zero_under_changing_jitter():
    for vectors in vectors_to_all(LocatedByJitter(), STILL[0]):
        mask = DualMotionMask(1e-9)(torch.empty(1, 0, H, W), vectors)
        assert torch.equal(mask, torch.zeros(1, 1, H, W))


def test_what_was_hidden_is_followed_at_the_samples_place():
    """A mask of frame 1, linear in the position, followed from frame 2, which slides by a fraction of a pixel."""
    stage, mask = LocatedByJitter(), DualMotionMask()

    def hidden(x, y):
        return (0.01 * x + 0.02 * y) / W

    x, y = centres()
    _, first = shot(SLIDE[0], 1)
    apart = torch.stack((hidden(x + JITTERS[1, 0], y + JITTERS[1, 1]), torch.zeros(H, W).double()))[None]
    first = Frame(motion=first.motion, motion_dual=first.motion + apart, jitter=first.jitter)
    _, second = shot(SLIDE[0], 2)
    earlier = chain(stage.between_samples(mask.vectors(first), first, (JITTERS[:1],)), ())
    _, two = chain(stage.between_samples(mask.vectors(second), second, stage.remember(first)), earlier)
    was_x, was_y = SLIDE[0](x + JITTERS[2, 0], y + JITTERS[2, 1])
    torch.testing.assert_close(inner(two[0, 2]), inner(hidden(was_x, was_y)), rtol=0, atol=1e-12)


def test_planes_hold_the_jitter_of_each_item_and_survive_a_warp():
    jitter = torch.tensor([[0.3, -0.2], [-0.5, 0.1]])
    inputs = torch.rand(2, 7, 4, 5)
    appended = LocatedByJitter().append(inputs, Frame(jitter=jitter))
    assert appended.shape == (2, 7 + LocatedByJitter.channels, 4, 5)
    assert torch.equal(appended[:, :7], inputs)
    for n in range(2):
        for c in range(2):
            assert appended[n, 7 + c].unique().tolist() == [jitter[n, c].item()]
    warped = warp(appended, torch.randn(2, 2, 4, 5))
    torch.testing.assert_close(warped[:, 7:], appended[:, 7:], rtol=0, atol=1e-6)


def test_first_frame_has_no_previous_jitter():
    vectors = torch.rand(1, 4, H, W)
    assert LocatedByJitter().between_samples(vectors, Frame(jitter=torch.rand(1, 2)), ()) is vectors


@pytest.mark.parametrize("channels", [2, 4])
def test_each_item_has_its_jitter_and_only_motion_contains_it(channels):
    vectors = torch.rand(2, channels, 3, 4)
    now, before = torch.rand(2, 2) - 0.5, torch.rand(2, 2) - 0.5
    actual = LocatedByJitter().between_samples(vectors, Frame(jitter=now), (before,))
    for n in range(2):
        for c, size in ((0, 4), (1, 3)):
            expected = vectors[n, c] + (now[n, c] - before[n, c]) / size
            torch.testing.assert_close(actual[n, c], expected)
    assert torch.equal(actual[:, 2:], vectors[:, 2:])


def test_gradients():
    stage, frame = LocatedByJitter(), Frame(jitter=JITTERS[:1])
    inputs = torch.rand(1, 2, 2, 3, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda x: stage.append(x, frame), inputs)
    assert torch.autograd.gradcheck(lambda x: stage.at_target(x, frame, 2), inputs)
    assert torch.autograd.gradcheck(lambda x: stage.between_samples(x, frame, (JITTERS[1:2],)), inputs)


def test_none_reads_nothing_and_changes_nothing():
    stage, inputs = Unlocated(), torch.rand(1, 7, 4, 5)
    assert (stage.channels, stage.requires, stage.remember(Frame())) == (0, frozenset(), ())
    assert stage.append(inputs, Frame()) is inputs
    assert stage.between_samples(inputs, Frame(), ()) is inputs
    motion = torch.rand(1, 2, 2, 2)
    enlarged = stage.at_target(motion, Frame(), 2)
    # Bilinear at pixel centres: a quarter of the way from one sample to the next.
    row = motion[0, 0, 0].tolist()
    assert enlarged[0, 0, 0].tolist() == pytest.approx(
        [row[0], 0.75 * row[0] + 0.25 * row[1], 0.25 * row[0] + 0.75 * row[1], row[1]], abs=1e-6
    )
    assert enlarged.shape == (1, 2, 4, 4)
