import numpy as np
import pytest
import torch
from skimage.transform import resize

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.bicubic import Bicubic
from supersampling.models.jau import JAU


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


@pytest.mark.parametrize("model", [JAU, Bicubic])
def test_scale_of_zero_raises(model):
    with pytest.raises(UserError, match="scale"):
        model(0)
