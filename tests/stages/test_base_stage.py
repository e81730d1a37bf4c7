import torch

from supersampling.frames import Frame
from supersampling.stages.base import JitterAlignedBase, NoBase


def test_none_returns_the_prediction_and_reads_nothing():
    predicted = torch.rand(1, 3, 4, 6)
    assert NoBase().requires == frozenset()
    assert NoBase()(predicted, torch.rand(1, 3, 2, 3), Frame()) is predicted


def test_linear_light_is_added_at_target_pixel_centres():
    h, w, scale, offset = 6, 7, 4, (0.3, -0.45)

    def light(x, y):
        return torch.stack((0.2 * x + 5.0 * y, y - x, torch.full_like(x, 3.0)))[None]

    def at(h, w, step, shift=(0.0, 0.0)):
        y, x = torch.meshgrid(torch.arange(h).double() + 0.5, torch.arange(w).double() + 0.5, indexing="ij")
        return light(x * step + shift[0], y * step + shift[1])

    predicted = torch.randn(1, 3, h * scale, w * scale, dtype=torch.float64)
    jitter = torch.tensor([offset], dtype=torch.float64)
    output = JitterAlignedBase()(predicted, at(h, w, 1.0, offset), Frame(jitter=jitter))
    inner = (..., slice(scale, -scale), slice(scale, -scale))
    expected = predicted + at(h * scale, w * scale, 1 / scale)
    torch.testing.assert_close(output[inner], expected[inner], rtol=0, atol=1e-11)


def test_gradients_and_items():
    stage, jitter = JitterAlignedBase(), torch.tensor([[0.2, -0.3], [-0.4, 0.1]], dtype=torch.float64)
    predicted = torch.randn(2, 3, 4, 6, dtype=torch.float64, requires_grad=True)
    light = torch.rand(2, 3, 2, 3, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda p, x: stage(p, x, Frame(jitter=jitter)), (predicted, light))
    both = stage(predicted, light, Frame(jitter=jitter))
    alone = stage(predicted[1:], light[1:], Frame(jitter=jitter[1:]))
    assert torch.equal(both[1:], alone)
