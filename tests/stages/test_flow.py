import numpy as np
import pytest
import torch

from supersampling.frames import Frame
from supersampling.stages.flow import TVL1, JitteredMotionVectors, MotionVectors, NoFlow, compensate_jitter


def scene(x, y):
    """A smooth brightness for every point of the plane, pixels."""
    return 0.5 + 0.2 * torch.sin(0.45 * x + 0.2 * y) + 0.2 * torch.cos(0.15 * x - 0.5 * y)


def shot(shift, jitter, h=40, w=48):
    """The plane moved by ``shift`` pixels, sampled at pixel centres + jitter: ``(1, 3, h, w)``."""
    x = torch.arange(w)[None, :] + 0.5 + jitter[0] - shift[0]
    y = torch.arange(h)[:, None] + 0.5 + jitter[1] - shift[1]
    return scene(x, y).expand(1, 3, h, w)


def test_compensation_finds_the_unjittered_motion_of_a_moved_plane():
    """Where a sample's point lies in the previous image's pixels, worked out from positions on the plane."""
    h, w = 3, 5
    jitter, previous, velocity = (
        torch.tensor([[0.3, -0.2]]),
        torch.tensor([[-0.4, 0.1]]),
        torch.tensor([1.5, -0.75]),
    )
    seen = torch.empty(1, 2, h, w)
    for i in range(h):
        for j in range(w):
            sample = torch.tensor([j + 0.5, i + 0.5]) + jitter[0]
            index_before = (
                sample - velocity - previous[0]
            )  # of the pixel (centre) that took this point before
            seen[0, :, i, j] = (index_before - torch.tensor([j + 0.5, i + 0.5])) / torch.tensor([w, h])
    expected = (-velocity / torch.tensor([w, h])).view(1, 2, 1, 1).expand(1, 2, h, w)
    torch.testing.assert_close(compensate_jitter(seen, jitter, previous), expected)


def test_gradient_of_compensation():
    motion = torch.randn(2, 2, 3, 4, dtype=torch.float64, requires_grad=True)
    jitters = [torch.rand(2, 2, dtype=torch.float64, requires_grad=True) for _ in range(2)]
    assert torch.autograd.gradcheck(compensate_jitter, (motion, *jitters))


def test_motion_vectors_are_taken_as_they_are():
    motion = torch.randn(2, 2, 3, 4)
    stage = MotionVectors()
    assert stage.remember(Frame(motion=motion)) == ()
    assert stage(Frame(motion=motion), ()) is motion


def test_jittered_motion_vectors_lose_the_jitter():
    motion, jitters = torch.randn(2, 2, 3, 4), torch.rand(2, 2, 2) - 0.5
    stage = JitteredMotionVectors()
    memory = stage.remember(Frame(motion=motion, jitter=jitters[0]))
    result = stage(Frame(motion=motion, jitter=jitters[1]), memory)
    for n in range(2):
        x = motion[n, 0] + (jitters[0, n, 0] - jitters[1, n, 0]) / 4
        y = motion[n, 1] + (jitters[0, n, 1] - jitters[1, n, 1]) / 3
        torch.testing.assert_close(result[n], torch.stack((x, y)))


@pytest.mark.parametrize("velocity", [(1.0, 0.0), (0.0, -1.0), (0.6, 0.8), (0.0, 0.0)])
def test_tvl1_finds_the_motion_of_a_jittered_plane(velocity):
    now, before = torch.tensor([[0.3, -0.4]]), torch.tensor([[-0.35, 0.2]])
    stage = TVL1()
    memory = stage.remember(Frame(color=shot((0.0, 0.0), before[0]), jitter=before))
    found = stage(Frame(color=shot(velocity, now[0]), jitter=now), memory)
    pixels = found * torch.tensor([48.0, 40.0]).view(1, 2, 1, 1)
    inner = pixels[0, :, 8:-8, 8:-8].flatten(1).median(dim=1).values.numpy()
    np.testing.assert_allclose(inner, [-v for v in velocity], atol=0.1)


def test_tvl1_treats_items_apart_and_gives_no_gradient():
    a, b = shot((0, 0), (0, 0)), shot((1.0, 0.5), (0, 0))
    zeros = torch.zeros(2, 2)
    both = TVL1()(Frame(color=torch.cat((b, a)).requires_grad_(), jitter=zeros), (torch.cat((a, a)), zeros))
    alone = TVL1()(Frame(color=b, jitter=zeros[:1]), (a, zeros[:1]))
    assert torch.equal(both[:1], alone)
    assert not both.requires_grad


def test_tvl1_of_images_too_small_for_it_is_no_motion():
    jitter = torch.zeros(1, 2)
    flow = TVL1()(Frame(color=torch.rand(1, 3, 1, 3), jitter=jitter), (torch.rand(1, 3, 1, 3), jitter))
    assert torch.equal(flow, torch.zeros(1, 2, 1, 3))


def test_no_flow_reads_nothing_and_stays():
    assert NoFlow.requires == frozenset()
    assert NoFlow()(Frame(), ()) is None
