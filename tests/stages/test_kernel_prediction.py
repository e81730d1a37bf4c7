import pytest
import torch
import torch.nn.functional as F

from supersampling.errors import UserError
from supersampling.stages.kernel_prediction import FirstAndLast, FirstOnly, KernelMLP, LastOnly, NoPrediction, convolve

FIRST, LAST = torch.randn(4, 7, 3, 3), torch.randn(6, 4, 3, 3)
MLP = {"width": 16, "layers": 3}
OPTIONS = {
    "both": lambda: FirstAndLast(FIRST, LAST, **MLP),
    "first": lambda: FirstOnly(FIRST, LAST, **MLP),
    "last": lambda: LastOnly(FIRST, LAST, **MLP),
    "none": lambda: NoPrediction(FIRST, LAST),
}


def convolve_by_loops(x, kernel, bias):
    b, _, h, w = x.shape
    out = bias[None, :, None, None].repeat(b, 1, h, w)
    for n in range(b):
        for i in range(h):
            for j in range(w):
                for di in (-1, 0, 1):
                    for dj in (-1, 0, 1):
                        if 0 <= i + di < h and 0 <= j + dj < w:
                            out[n, :, i, j] += kernel[n, :, :, di + 1, dj + 1] @ x[n, :, i + di, j + dj]
    return out


@pytest.mark.parametrize(("h", "w"), [(1, 1), (3, 5)])
def test_each_item_is_convolved_with_its_kernel(h, w):
    x, kernel, bias = torch.randn(3, 2, h, w), torch.randn(3, 4, 2, 3, 3), torch.randn(4)
    torch.testing.assert_close(convolve(x, kernel, bias), convolve_by_loops(x, kernel, bias))
    shared = convolve(x, kernel[:1], bias)
    torch.testing.assert_close(shared, convolve_by_loops(x, kernel[:1].expand(3, -1, -1, -1, -1), bias))


def test_gradients_of_convolution():
    x = torch.randn(2, 2, 3, 3, dtype=torch.float64, requires_grad=True)
    kernel = torch.randn(2, 3, 2, 3, 3, dtype=torch.float64, requires_grad=True)
    bias = torch.randn(3, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(convolve, (x, kernel, bias))
    assert torch.autograd.gradcheck(convolve, (x, kernel[:1].detach().requires_grad_(), bias))


def test_the_mlp_is_linear_layers_with_relu_between_them():
    torch.manual_seed(0)
    mlp, jitter = KernelMLP((FIRST, LAST), **MLP).double(), torch.rand(3, 2, dtype=torch.float64) - 0.5
    bias = torch.cat([kernel.flatten() for kernel in mlp.bias])
    torch.nn.init.normal_(mlp.layers[-1].weight)
    weights = [p.detach() for p in (*mlp.layers.parameters(), bias)]
    assert len(weights) == 2 * MLP["layers"]
    for n, kernels in enumerate(zip(*mlp(jitter))):
        y = jitter[n]
        for k in range(0, len(weights), 2):
            y = weights[k] @ y + weights[k + 1]
            if k + 2 < len(weights):
                y = torch.maximum(y, torch.zeros_like(y))
        flat = torch.cat([kernel.detach().flatten() for kernel in kernels])
        torch.testing.assert_close(flat, y)


def test_gradient_of_mlp_by_jitter():
    mlp = KernelMLP((FIRST, LAST), **MLP).double()
    torch.nn.init.normal_(mlp.layers[-1].weight)
    jitter = torch.rand(2, 2, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda j: tuple(mlp(j)), (jitter,))


@pytest.mark.parametrize(
    ("name", "predicted"), [("both", 9 * (28 + 24)), ("first", 9 * 28), ("last", 9 * 24), ("none", 0)]
)
def test_unpredicted_kernels_leave_no_parameters_in_the_mlp(name, predicted):
    width, layers = MLP["width"], MLP["layers"]
    fixed = 9 * (28 + 24) - predicted
    mlp = 2 * width + width + (layers - 2) * (width**2 + width) + (width + 1) * predicted if predicted else 0
    assert sum(p.numel() for p in OPTIONS[name]().parameters()) == mlp + fixed


@pytest.mark.parametrize("name", OPTIONS)
def test_shapes_and_dependence_on_jitter(name):
    torch.manual_seed(0)
    first, last = trained(OPTIONS[name]())(torch.tensor([[-0.5, 0.2], [0.4, -0.1]]))
    assert first.shape == (2 if name in ("both", "first") else 1, 4, 7, 3, 3)
    assert last.shape == (2 if name in ("both", "last") else 1, 6, 4, 3, 3)
    for kernel in (first, last):
        assert len(kernel) == 1 or not torch.equal(kernel[0], kernel[1])


def trained(stage):
    """Return the stage with random weights that depend on the jitter, unlike those of a new one."""
    if hasattr(stage, "mlp"):
        torch.nn.init.normal_(stage.mlp.layers[-1].weight)
    return stage


@pytest.mark.parametrize("name", OPTIONS)
def test_kernels_start_at_initial_ones_for_any_jitter(name):
    for kernels, initial in zip(OPTIONS[name]()(torch.rand(2, 2) - 0.5), (FIRST, LAST)):
        assert torch.equal(kernels, initial.expand_as(kernels))


@pytest.mark.parametrize("name", OPTIONS)
def test_precomputed_kernels_are_those_of_the_jitter(name):
    torch.manual_seed(0)
    stage, sequence = trained(OPTIONS[name]()), torch.rand(16, 2) - 0.5
    table = stage.precompute(sequence)
    assert not list(table.parameters())
    for k in (3, 15, 0):
        with torch.no_grad():
            for kernel, expected in zip(table(sequence[k : k + 1]), stage(sequence[k : k + 1])):
                torch.testing.assert_close(
                    kernel, expected, rtol=1e-5, atol=1e-6
                )  # single precision, other batch sizes


def test_a_precomputed_kernel_is_that_of_the_nearest_jitter():
    sequence = torch.tensor([[-0.25, -0.25], [0.25, -0.25], [0.0, 0.25]])
    table = trained(OPTIONS["both"]()).precompute(sequence)
    first, last = table(torch.tensor([[0.26, -0.24], [-0.2, -0.3], [0.01, 0.2]]))
    assert torch.equal(first, table.first[[1, 0, 2]])
    assert torch.equal(last, table.last[[1, 0, 2]])


@pytest.mark.parametrize(("width", "layers"), [(0, 7), (16, 1)])
def test_invalid_mlp_raises(width, layers):
    with pytest.raises(UserError, match=f"width={width} and layers={layers}"):
        KernelMLP((FIRST,), width, layers)


def test_a_fixed_kernel_is_an_ordinary_convolution():
    stage, x = NoPrediction(FIRST, LAST), torch.randn(2, 7, 4, 5)
    first, _ = stage(torch.zeros(2, 2))
    bias = torch.randn(4)
    assert torch.equal(convolve(x, first, bias), F.conv2d(x, first[0], bias, padding=1))
