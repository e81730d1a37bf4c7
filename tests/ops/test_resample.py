import math
from fractions import Fraction

import pytest
import torch

from supersampling.errors import UserError
from supersampling.ops.resample import (
    check_scale,
    gaussian_upsample,
    jitter_aligned_upsample,
    upsample_motion,
    zero_upsample,
)
from supersampling.render.jitter import jitter_sequence

JITTERS = torch.tensor([[0.0, 0.0], [-0.5, -0.5], [0.375, -0.125], [-0.2, 0.49]], dtype=torch.float64)


def sampled_ramp(jitter, h, w):
    """Sample a linear signal, different in x and y, once per pixel at centre + jitter."""
    x = torch.arange(w, dtype=torch.float64) + 0.5 + jitter[:, 0, None, None]
    y = torch.arange(h, dtype=torch.float64)[:, None] + 0.5 + jitter[:, 1, None, None]
    return torch.stack(((0.1 + 0.02 * x).expand(-1, h, -1), 0.3 + 0.01 * x + 0.03 * y), dim=1)


def target_ramp(h, w, scale):
    x = (torch.arange(w * scale, dtype=torch.float64) + 0.5) / scale
    y = (torch.arange(h * scale, dtype=torch.float64)[:, None] + 0.5) / scale
    return torch.stack(((0.1 + 0.02 * x).expand(h * scale, -1), 0.3 + 0.01 * x + 0.03 * y))


@pytest.mark.parametrize("scale", [1, 2, 3, 4, 5, 6])
@pytest.mark.parametrize(("mode", "border"), [("bilinear", 1), ("bicubic", 3)])
def test_jitter_alignment_restores_a_ramp(scale, mode, border):
    h, w, edge = 8, 9, border * scale
    aligned = jitter_aligned_upsample(sampled_ramp(JITTERS, h, w), JITTERS, scale, mode)
    inside = (..., slice(edge, -edge), slice(edge, -edge))
    expected = target_ramp(h, w, scale).expand_as(aligned)
    # The cubic kernel with a = -0.75 does not reproduce ramps between centres: its error is up to 0.05 steps.
    tolerance = 1e-12 if mode == "bilinear" else 0.05 * 0.04
    torch.testing.assert_close(aligned[inside], expected[inside], rtol=0, atol=tolerance)


def test_wrong_sign_of_jitter_misses_the_ramp():
    h, w, scale = 8, 9, 4
    wrong = jitter_aligned_upsample(sampled_ramp(JITTERS, h, w), -JITTERS, scale)
    error = (wrong - target_ramp(h, w, scale))[:, 0, 4:-4, 4:-4].abs().amax((1, 2))
    expected = 0.02 * 2.0 * JITTERS[:, 0].abs()
    torch.testing.assert_close(error, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("scale", [1, 2, 3, 4, 5, 6])
def test_zero_upsampling_keeps_the_position_of_samples(scale):
    h, w = 3, 2
    just_below = torch.nextafter(torch.tensor(0.5), torch.tensor(0.0)).item()
    jitter = torch.tensor([[0.0, 0.0], [-0.5, just_below], [0.3, -0.4]])
    image = torch.rand(3, 2, h, w) + 0.5
    expected = torch.zeros(3, 2, h * scale, w * scale)
    for b in range(3):
        for i in range(h):
            for j in range(w):
                row = math.floor((i + 0.5 + jitter[b, 1].item()) * scale)
                column = math.floor((j + 0.5 + jitter[b, 0].item()) * scale)
                expected[b, :, row, column] = image[b, :, i, j]
    assert torch.equal(zero_upsample(image, jitter, scale), expected)


@pytest.mark.parametrize("scale", [2, 3, 4, 5, 6])
def test_samples_on_a_boundary_follow_exact_arithmetic(scale):
    """Halton's thirds in float32, stored in half precision, and a rounding step to either side."""
    jitter = torch.from_numpy(jitter_sequence("halton16", scale))
    inside = [[Fraction(v + 0.5).limit_denominator(81) for v in row] for row in jitter.double().tolist()]
    exact = [[math.floor(v * scale) for v in row] for row in inside]
    ones = torch.ones(len(jitter), 1, 1, 1)
    infinity = torch.full_like(jitter, torch.inf)
    for rounded in (jitter, jitter.half().float(), jitter.nextafter(infinity), jitter.nextafter(-infinity)):
        positions = zero_upsample(ones, rounded, scale)[:, 0].nonzero()
        assert positions[:, [2, 1]].tolist() == exact


def test_upsampled_motion_keeps_image_units():
    x = (torch.arange(8, dtype=torch.float64) + 0.5) / 8
    motion = torch.stack((0.3 * x, -0.2 * x)).view(1, 2, 1, 8).expand(1, 2, 6, 8)
    fine = (torch.arange(24, dtype=torch.float64) + 0.5) / 24
    expected = torch.stack((0.3 * fine, -0.2 * fine)).view(1, 2, 1, 24).expand(1, 2, 18, 24)
    torch.testing.assert_close(upsample_motion(motion, (18, 24))[..., 3:-3], expected[..., 3:-3])


def gaussian_by_loops(image, jitter, scale, sigma):
    b, c, h, w = image.shape
    result, beta = torch.zeros(b, c, h * scale, w * scale), torch.zeros(b, 1, h * scale, w * scale)
    for n in range(b):
        for y in range(h * scale):
            for x in range(w * scale):
                total, weighted, best = 0.0, torch.zeros(c), 0.0
                for i in range(max(y // scale - 1, 0), min(y // scale + 2, h)):
                    for j in range(max(x // scale - 1, 0), min(x // scale + 2, w)):
                        dx = (j + 0.5 + jitter[n, 0].item()) * scale - (x + 0.5)
                        dy = (i + 0.5 + jitter[n, 1].item()) * scale - (y + 0.5)
                        weight = math.exp(-(dx * dx + dy * dy) / (2 * sigma**2))
                        total, best = total + weight, max(best, weight)
                        weighted = weighted + weight * image[n, :, i, j]
                result[n, :, y, x], beta[n, 0, y, x] = weighted / total, best
    return result, beta


@pytest.mark.parametrize(("h", "w", "scale", "sigma"), [(3, 4, 2, 0.8), (4, 3, 3, 0.5), (1, 1, 4, 1.5)])
def test_gaussian_reconstruction_equals_the_loops(h, w, scale, sigma):
    image = torch.rand(4, 3, h, w)
    expected, expected_beta = gaussian_by_loops(image, JITTERS, scale, sigma)
    result, beta = gaussian_upsample(image, JITTERS.float(), scale, sigma)
    torch.testing.assert_close(result, expected, rtol=1e-4, atol=1e-5)
    torch.testing.assert_close(beta, expected_beta, rtol=1e-4, atol=1e-6)


def test_gaussian_reconstruction_survives_underflow():
    image = torch.rand(1, 3, 2, 2)
    result, beta = gaussian_upsample(image, torch.tensor([[-0.5, -0.5]]), 6, sigma=0.01)
    assert result.isfinite().all()
    assert beta.min() == 0.0
    assert image.min() <= result.min()
    assert result.max() <= image.max()


@pytest.mark.parametrize("scale", [0, -2, 1.5])
def test_invalid_scale_is_rejected(scale):
    with pytest.raises(UserError, match=str(scale)):
        check_scale(scale)
