import numpy as np
import pytest
import torch
from skimage.transform import resize

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.bicubic import Bicubic
from supersampling.models.bilinear import Bilinear
from supersampling.models.jau import JAU, BicubicJAU


@pytest.mark.parametrize("scale", [2, 3, 4])
def test_without_jitter_jau_is_bilinear_resizing(scale):
    color = np.random.default_rng(0).random((5, 7, 3))
    expected = resize(color, (5 * scale, 7 * scale), order=1, mode="edge", anti_aliasing=False)
    frame = Frame(torch.from_numpy(color).permute(2, 0, 1)[None], jitter=torch.zeros(1, 2, dtype=torch.float64))
    output, state = JAU(scale)(frame, None)
    assert state is None
    torch.testing.assert_close(output[0].permute(1, 2, 0), torch.from_numpy(expected))


def test_each_item_of_a_batch_has_its_own_jitter():
    ramp = (torch.arange(8.0) + 0.5) / 10
    jitter = torch.tensor([[0.25, 0.0], [-0.4, 0.3]])
    color = (ramp + jitter[:, :1] / 10)[:, None, None, :].expand(2, 3, 8, 8)
    output, _ = JAU(2)(Frame(color=color, jitter=jitter), None)
    expected = ((torch.arange(16.0) + 0.5) / 20).expand(2, 3, 16, 16)
    torch.testing.assert_close(output[..., 2:-2], expected[..., 2:-2])


def test_bicubic_ignores_jitter_and_stays_in_range():
    step = torch.zeros(1, 3, 4, 8)
    step[..., 4:] = 1.0
    output, state = Bicubic(4)(Frame(color=step), None)
    assert state is None
    assert output.min() == 0.0
    assert output.max() == 1.0
    # Pixel 15 lies 3/8 past the last black centre: it takes the cubic kernel's weights at distances 5/8 and 13/8.
    a, near, far = -0.75, 0.625, 1.625
    expected = (a + 2) * near**3 - (a + 3) * near**2 + 1 + a * (far**3 - 5 * far**2 + 8 * far - 4)
    torch.testing.assert_close(output[0, 0, 8, 15], torch.tensor(expected))


@pytest.mark.parametrize("jitter", [(0.0, 0.0), (0.25, -0.375)])
def test_bicubic_jau_is_the_cubic_kernel_around_each_sample(jitter):
    """Pixel by pixel: 16 samples around the target pixel's place, less the jitter; borders are repeated."""
    a, scale = -0.75, 2

    def weight(t):
        t = abs(t)
        return (a + 2) * t**3 - (a + 3) * t**2 + 1 if t <= 1 else a * (t**3 - 5 * t**2 + 8 * t - 4) if t < 2 else 0.0

    color = np.random.default_rng(1).random((5, 6))
    frame = Frame(torch.from_numpy(color).expand(1, 3, 5, 6), jitter=torch.tensor([jitter], dtype=torch.float64))
    output, state = BicubicJAU(scale)(frame, None)
    assert state is None
    for y, x in ((0, 0), (4, 5), (9, 11), (7, 2)):
        v, u = ((n + 0.5) / scale - o - 0.5 for n, o in ((y, jitter[1]), (x, jitter[0])))
        value = 0.0
        for i in range(int(np.floor(v)) - 1, int(np.floor(v)) + 3):
            for j in range(int(np.floor(u)) - 1, int(np.floor(u)) + 3):
                value += weight(v - i) * weight(u - j) * color[min(max(i, 0), 4), min(max(j, 0), 5)]
        assert output[0, 0, y, x] == pytest.approx(min(max(value, 0.0), 1.0), abs=1e-6)


def test_normal_bilinear_ignores_jitter():
    color = np.random.default_rng(0).random((5, 7, 3))
    expected = resize(color, (15, 21), order=1, mode="edge", anti_aliasing=False)
    frame = Frame(torch.from_numpy(color).permute(2, 0, 1)[None], jitter=torch.full((1, 2), 0.4, dtype=torch.float64))
    output, state = Bilinear(3)(frame, None)
    assert state is None
    torch.testing.assert_close(output[0].permute(1, 2, 0), torch.from_numpy(expected))


@pytest.mark.parametrize("model", [JAU, BicubicJAU, Bicubic, Bilinear])
def test_scale_of_zero_raises(model):
    with pytest.raises(UserError, match="scale"):
        model(0)
