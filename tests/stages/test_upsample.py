import math

import pytest
import torch

from supersampling.stages.upsample import BilinearUpsampling, ZeroUpsampling


@pytest.mark.parametrize("scale", [2, 3, 4, 5, 6])
def test_zero_upsampling_puts_samples_where_they_were_taken(scale):
    image = torch.rand(2, 3, 3, 4) + 0.1
    jitter = torch.tensor([[0.0, 0.0], [-0.49, 0.3]])
    expected = torch.zeros(2, 3, 3 * scale, 4 * scale)
    for n in range(2):
        for i in range(3):
            for j in range(4):
                x = math.floor((j + 0.5 + float(jitter[n, 0])) * scale)
                y = math.floor((i + 0.5 + float(jitter[n, 1])) * scale)
                expected[n, :, y, x] = image[n, :, i, j]
    assert torch.equal(ZeroUpsampling()(image, jitter, scale), expected)


@pytest.mark.parametrize("scale", [2, 3, 4])
def test_bilinear_upsampling_reproduces_a_plane(scale):
    h, w, jitter = 5, 6, torch.tensor([[0.25, -0.4]], dtype=torch.float64)
    y = torch.arange(h, dtype=torch.float64)[:, None] + 0.5 + jitter[0, 1]
    x = torch.arange(w, dtype=torch.float64) + 0.5 + jitter[0, 0]
    big_y = (torch.arange(h * scale, dtype=torch.float64)[:, None] + 0.5) / scale
    big_x = (torch.arange(w * scale, dtype=torch.float64) + 0.5) / scale
    out = BilinearUpsampling()((2.0 * x - 3.0 * y)[None, None], jitter, scale)
    inner = slice(scale, -scale)
    torch.testing.assert_close(out[0, 0, inner, inner], (2.0 * big_x - 3.0 * big_y)[inner, inner], rtol=0, atol=1e-12)


@pytest.mark.parametrize("stage", [ZeroUpsampling(), BilinearUpsampling()])
def test_gradients(stage):
    image = torch.rand(1, 2, 2, 3, dtype=torch.float64, requires_grad=True)
    jitter = torch.tensor([[0.1, -0.2]], dtype=torch.float64)
    assert torch.autograd.gradcheck(lambda x: stage(x, jitter, 2), (image,))
