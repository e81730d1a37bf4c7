"""Tests of the C++ passes against loops over pixels in float64."""

import math
import shutil

import numpy as np
import pytest
import torch

from supersampling.errors import UserError
from supersampling.models.native import dlctus as native
from supersampling.models.native import library

pytestmark = pytest.mark.skipif(shutil.which("c++") is None, reason="no C++ compiler")
WIDTH = 32


@pytest.mark.parametrize(("height", "width"), [(1, 1), (4, 4), (5, 7), (2, 99), (11, 53)])
@pytest.mark.parametrize("with_residual", [False, True])
def test_convolution_pixel_by_pixel(height, width, with_residual):
    torch.manual_seed(0)
    x, weight = torch.randn(height, width, WIDTH), torch.randn(WIDTH, WIDTH, 3, 3) / 17
    bias, residual = torch.randn(WIDTH), torch.randn(height, width, WIDTH)
    expected = np.empty((height, width, WIDTH))
    kernel, image = weight.double().numpy(), x.double().numpy()
    for i in range(height):
        for j in range(width):
            rows = [min(max(i + k, 0), height - 1) for k in (-1, 0, 1)]
            columns = [min(max(j + k, 0), width - 1) for k in (-1, 0, 1)]
            expected[i, j] = np.einsum("oiyx,yxi->o", kernel, image[np.ix_(rows, columns)])
    expected += bias.double().numpy()
    expected = expected + residual.double().numpy() if with_residual else np.maximum(expected, 0.0)
    out = residual.clone() if with_residual else torch.empty_like(x)
    native.convolve(x, native.transform_kernel(weight), bias, out if with_residual else None, out)
    np.testing.assert_allclose(out.numpy(), expected, rtol=0, atol=2e-5)


@pytest.mark.parametrize("rows", [1, 12, 29])
def test_product(rows):
    torch.manual_seed(0)
    x, weight, bias = torch.randn(rows, 68), torch.randn(68, WIDTH), torch.randn(WIDTH)
    expected = np.array(
        [[math.fsum(a * b for a, b in zip(row, column)) for column in weight.T.tolist()] for row in x.tolist()]
    )
    result = native.linear(x, weight, bias)
    np.testing.assert_allclose(result.numpy(), expected + bias.numpy(), rtol=0, atol=2e-5)


def bilinear(plane, y, x):
    """Interpolate between pixel centres, borders repeated."""
    h, w = plane.shape
    y, x = min(max(y, 0.0), h - 1.0), min(max(x, 0.0), w - 1.0)
    i, j = int(y), int(x)
    m, n = min(i + 1, h - 1), min(j + 1, w - 1)
    top = plane[i, j] * (1 - x + j) + plane[i, n] * (x - j)
    return top * (1 - y + i) + (plane[m, j] * (1 - x + j) + plane[m, n] * (x - j)) * (y - i)


def keys(distance, a):
    d = abs(distance)
    if d <= 1:
        return (a + 2) * d**3 - (a + 3) * d**2 + 1
    return a * (d**3 - 5 * d**2 + 8 * d - 4) if d < 2 else 0.0


def cubic(plane, y, x, a):
    h, w = plane.shape
    i, j = math.floor(y), math.floor(x)
    return sum(
        plane[min(max(r, 0), h - 1), min(max(c, 0), w - 1)] * keys(y - r, a) * keys(x - c, a)
        for r in range(i - 1, i + 3)
        for c in range(j - 1, j + 3)
    )


def make_inputs(scale, a=-0.75, h=4, w=8):
    torch.manual_seed(1)
    motion = 0.2 * torch.randn(1, 2, h, w)
    motion[..., : w // 2] = 0.0
    jitter = (0.31, -0.42)
    return native.Inputs(torch.rand(1, 3, h, w), torch.rand(1, 1, h, w), motion, jitter, scale, a)


def aligned_pixel(inputs, i, j):
    y = (i + 0.5) / inputs.scale - inputs.jitter[1] - 0.5
    x = (j + 0.5) / inputs.scale - inputs.jitter[0] - 0.5
    return [*(bilinear(c, y, x) for c in inputs.color[0].double().numpy()), 1.0]


@pytest.mark.parametrize("scale", [1, 2, 4])
@pytest.mark.parametrize("a", [-0.75, -0.5])
def test_preparation_pixel_by_pixel(scale, a):
    inputs = make_inputs(scale, a)
    height, width = inputs.target
    state = torch.rand(1, 4, height, width).contiguous(memory_format=torch.channels_last)
    blocks, first = native.prepare(inputs, state).numpy(), native.prepare(inputs, None).numpy()
    history, motion = state[0].double().numpy(), inputs.motion[0].double().numpy()
    kinds = set()
    for i in range(height):
        for j in range(width):
            y, x = (i + 0.5) / scale - 0.5, (j + 0.5) / scale - 0.5
            dx, dy = bilinear(motion[0], y, x), bilinear(motion[1], y, x)
            px, py = j + dx * width, i + dy * height
            aligned = aligned_pixel(inputs, i, j)
            outside = not (-0.5 <= px <= width - 0.5 and -0.5 <= py <= height - 0.5)
            expected = aligned if outside else [cubic(c, py, px, a) for c in history]
            kinds.add("outside" if outside else "still" if dx == dy == 0 else "moved")
            channels = slice(((i % 4) * 4 + j % 4) * 4, ((i % 4) * 4 + j % 4) * 4 + 4)
            np.testing.assert_allclose(blocks[i // 4, j // 4, channels], expected, rtol=0, atol=2e-5)
            np.testing.assert_allclose(first[i // 4, j // 4, channels], aligned, rtol=0, atol=1e-6)
            if dx == dy == 0:
                assert (blocks[i // 4, j // 4, channels] == state[0, :, i, j].numpy()).all()
    assert kinds == {"outside", "still", "moved"}
    side = 4 // scale
    for i in range(4):
        for j in range(8):
            k = 64 + ((i % side) * side + j % side) * 4
            sample = [*inputs.color[0, :, i, j].tolist(), inputs.depth[0, 0, i, j].item()]
            assert blocks[i // side, j // side, k : k + 4].tolist() == sample


@pytest.mark.parametrize("scale", [1, 2, 4])
def test_construction_pixel_by_pixel(scale):
    inputs = make_inputs(scale)
    height, width = inputs.target
    blocks, x = torch.rand(inputs.blocks) * 1.4 - 0.2, torch.randn(height // 4, width // 4, WIDTH) + 0.5
    state = native.construct(inputs, blocks, x)
    assert state.shape == (1, 4, height, width)
    for i in range(height):
        for j in range(width):
            k = (i % 4) * 4 + j % 4
            o1, o2 = (min(max(x[i // 4, j // 4, n].item(), 0.0), 1.0) for n in (k, 16 + k))
            history = blocks[i // 4, j // 4, 4 * k : 4 * k + 4].double().tolist()
            value = [p + o1 * (q - p) for p, q in zip(history, aligned_pixel(inputs, i, j), strict=True)]
            value[3] *= o2
            expected = [min(max(v, 0.0), 1.0) for v in value]
            np.testing.assert_allclose(state[0, :, i, j].numpy(), expected, rtol=0, atol=1e-6)


@pytest.mark.parametrize("compiler", ["no-such-compiler", "false"])
def test_missing_or_failing_compiler_is_reported(monkeypatch, tmp_path, compiler):
    monkeypatch.setenv("CXX", compiler)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    library.load_library.cache_clear()
    with pytest.raises(UserError, match=compiler):
        library.load_library()
    library.load_library.cache_clear()
    assert not list(tmp_path.rglob("*.so"))
