import numpy as np
import pytest
import torch
from PIL import Image

from supersampling.stages.colour_space import RGB, YCbCr, YCoCg


def test_ycbcr_equals_jpeg():
    pixels = np.random.default_rng(0).integers(0, 256, (16, 16, 3), dtype=np.uint8)
    expected = np.asarray(Image.fromarray(pixels).convert("YCbCr"), dtype=np.float32)
    ycbcr = YCbCr().of_rgb(torch.from_numpy(pixels).permute(2, 0, 1) / 255.0)
    # PIL centres chroma at 128 and rounds; here the centre is 0.5 of 255.
    offset = torch.tensor([0.0, 0.5, 0.5])[:, None, None]
    assert (ycbcr * 255.0 + offset - torch.from_numpy(expected).permute(2, 0, 1)).abs().max() < 1.01


@pytest.mark.parametrize(
    ("rgb", "ycbcr"),
    [
        ((0.0, 0.0, 0.0), (0.0, 0.5, 0.5)),
        ((1.0, 1.0, 1.0), (1.0, 0.5, 0.5)),
        ((1.0, 0.0, 0.0), (0.299, 0.5 - 0.299 / 1.772, 1.0)),
        ((0.0, 0.0, 1.0), (0.114, 1.0, 0.5 - 0.114 / 1.402)),
    ],
)
def test_corners_of_the_cube(rgb, ycbcr):
    out = YCbCr().of_rgb(torch.tensor(rgb).view(1, 3, 1, 1))
    torch.testing.assert_close(out.flatten(), torch.tensor(ycbcr), rtol=0, atol=1e-6)


@pytest.mark.parametrize("space", [RGB(), YCbCr()])
def test_round_trip_of_frames_and_clips(space):
    for shape in ((2, 3, 4, 5), (2, 6, 3, 4, 5)):
        rgb = torch.rand(shape)
        color = space.of_rgb(rgb)
        assert color.min() >= 0.0
        assert color.max() <= 1.0
        torch.testing.assert_close(space.to_rgb(color), rgb, rtol=0, atol=1e-6)


@pytest.mark.parametrize("space", [RGB(), YCoCg(), YCbCr()])
def test_unbounded_light_is_mapped_affinely_and_back(space):
    """An affine map: nothing is clipped outside [0, 1], and only the offset, the value of black, is not linear."""
    a, b = (100.0 * torch.rand(2, 3, 4, 5, dtype=torch.float64) for _ in range(2))
    black = space.of_rgb(torch.zeros_like(a))
    torch.testing.assert_close(space.of_rgb(a + b) - black, space.of_rgb(a) + space.of_rgb(b) - 2.0 * black)
    torch.testing.assert_close(space.to_rgb(space.of_rgb(a)), a)


@pytest.mark.parametrize("space", [YCoCg(), YCbCr()])
def test_grey_has_its_value_as_luma_and_no_chroma(space):
    color = space.of_rgb(torch.full((1, 3, 1, 1), 7.0)).flatten()
    chroma = space.of_rgb(torch.zeros(1, 3, 1, 1)).flatten()[1:]
    torch.testing.assert_close(color, torch.cat((torch.tensor([7.0]), chroma)))


@pytest.mark.parametrize("space", [YCoCg(), YCbCr()])
def test_gradients(space):
    x = torch.rand(1, 3, 2, 2, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(space.of_rgb, (x,))
    assert torch.autograd.gradcheck(space.to_rgb, (x,))
