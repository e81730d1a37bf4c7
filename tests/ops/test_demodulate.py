import numpy as np
import pytest
import torch

from supersampling.ops.demodulate import MIN_MATERIAL, demodulate, remodulate

HALF_MIN_SUBNORMAL = 2.0**-24


def random_surfaces(dtype: torch.dtype) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Return radiance, F_beta and emission.

    Lighting and F_beta span many powers of ten, a third of the pixels emit; drawn in float64, then rounded.
    """
    rng = np.random.default_rng(5)
    lighting = 10.0 ** rng.uniform(-3, 2, (2, 3, 20, 30))
    material = 10.0 ** rng.uniform(-4, 0, (2, 3, 20, 30))
    emission = np.where(rng.random((2, 1, 20, 30)) < 0.3, 10.0 ** rng.uniform(-2, 2, (2, 3, 20, 30)), 0.0)
    radiance = lighting * material + emission
    return tuple(torch.from_numpy(x).to(dtype) for x in (radiance, material, emission))


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16, torch.float32, torch.float64])
def test_round_trip(dtype):
    """Exact up to rounding of the larger of radiance and emission, in the precision of the result."""
    radiance, material, emission = random_surfaces(dtype)
    radiance = torch.maximum(radiance, emission)
    lighting = demodulate(radiance, material, emission)
    restored = remodulate(lighting, material, emission)
    wide = torch.float64 if dtype == torch.float64 else torch.float32
    assert lighting.dtype == restored.dtype == wide
    error = (restored - radiance.to(wide)).abs()
    assert (error <= 4.0 * torch.finfo(wide).eps * radiance.to(wide)).all()


def test_demodulation_recovers_the_lighting():
    rng = np.random.default_rng(2)
    lighting, material, emission = rng.uniform(0.1, 5, (3, 1, 3, 8, 9))
    radiance = lighting * material + emission
    result = demodulate(*(torch.from_numpy(x).float() for x in (radiance, material, emission)))
    np.testing.assert_allclose(result.numpy(), lighting, rtol=1e-4)


def test_extreme_values_are_finite_and_restored():
    """All pairs of the largest, smallest and unusual half-precision values of stored buffers."""
    radiance = [0.0, HALF_MIN_SUBNORMAL, 6.1e-5, 0.18, 1.0, 4.0, 65504.0]
    materials = [0.0, 1e-45, 1e-8, HALF_MIN_SUBNORMAL, 6.0e-5, MIN_MATERIAL, 1e-3, 0.5, 1.0]
    r, m = (
        x.reshape(1, 1, len(radiance), -1)
        for x in torch.meshgrid(*map(torch.tensor, (radiance, materials)), indexing="ij")
    )
    lighting = demodulate(r, m, torch.zeros_like(r))
    assert lighting.isfinite().all()
    restored = remodulate(lighting, m, torch.zeros_like(r))
    torch.testing.assert_close(restored, torch.where(m >= MIN_MATERIAL, r, 0.0), rtol=4e-7, atol=0)
    assert (lighting[m < MIN_MATERIAL] == 0.0).all()


def test_threshold_is_the_smallest_normal_half():
    assert torch.finfo(torch.float16).smallest_normal == MIN_MATERIAL
    below = np.nextafter(np.float32(MIN_MATERIAL), np.float32(0.0))
    lighting = demodulate(torch.ones(2), torch.tensor([MIN_MATERIAL, float(below)]), torch.zeros(2))
    assert lighting.tolist() == [1.0 / MIN_MATERIAL, 0.0]


def test_half_precision_does_not_overflow():
    """A radiance of 100 on a nearly black surface: the lighting is 25 times float16's maximum."""
    lighting = demodulate(torch.tensor([100.0]).half(), torch.tensor([MIN_MATERIAL]).half(), torch.zeros(1).half())
    assert lighting.item() == 100.0 / MIN_MATERIAL
    assert remodulate(lighting, torch.tensor([MIN_MATERIAL]).half(), torch.zeros(1).half()).item() == 100.0
    radiance = remodulate(torch.tensor([60000.0]).half(), torch.tensor([2.0]).half(), torch.zeros(1).half())
    assert radiance.item() == 120000.0


@pytest.mark.parametrize("material", [0.0, 1e-4, 0.5])
def test_radiance_rounded_below_emission_is_unlit(material):
    """One half-precision step (0.0625) below an emission of 100 is rounding and must not give negative lighting."""
    emission, radiance = torch.tensor([100.0]).half(), torch.tensor([99.9375]).half()
    assert radiance.item() == 99.9375
    lighting = demodulate(radiance, torch.tensor([material]), emission)
    assert lighting.item() == 0.0
    assert abs(remodulate(lighting, torch.tensor([material]), emission).item() - radiance.item()) == 0.0625


def test_emission_and_sky_bypass_demodulation():
    """Where radiance is only emission, lighting is 0 and the emission is restored bit for bit, for any F_beta."""
    sky = torch.rand(1, 3, 6, 7) * 50.0
    for material in (torch.zeros(1, 3, 6, 7), torch.rand(1, 3, 6, 7)):
        lighting = demodulate(sky, material, sky)
        assert (lighting == 0.0).all()
        assert torch.equal(remodulate(lighting, material, sky), sky)
    lighting, material = torch.rand(2, 1, 3, 6, 7)
    torch.testing.assert_close(remodulate(lighting, material, sky) - remodulate(lighting, material, sky * 0), sky)


def test_gradients():
    """For lit surfaces of ordinary reflectance, gradients are those of a quotient and of a product."""
    rng = np.random.default_rng(8)
    material, emission = (torch.from_numpy(rng.uniform(0.2, 1.0, (1, 3, 2, 2))).requires_grad_() for _ in range(2))
    radiance = torch.from_numpy(rng.uniform(2.0, 3.0, (1, 3, 2, 2))).requires_grad_()
    assert torch.autograd.gradcheck(demodulate, (radiance, material, emission))
    assert torch.autograd.gradcheck(remodulate, (radiance, material, emission))


@pytest.mark.parametrize("radiance", [0.0, 1.0, 65504.0])
@pytest.mark.parametrize("material", [0.0, 1e-45, 1e-8, MIN_MATERIAL, 1.0])
def test_gradients_are_finite_for_extreme_values(radiance, material):
    leaves = [torch.tensor([value], requires_grad=True) for value in (radiance, material, 0.0)]
    lighting = demodulate(*leaves)
    (lighting + remodulate(lighting, *leaves[1:])).sum().backward()
    for leaf in leaves:
        assert leaf.grad is not None
        assert leaf.grad.isfinite().all()
    if material < MIN_MATERIAL:
        assert leaves[0].grad.item() == 0.0
        assert leaves[1].grad.item() == 0.0


def test_nan_is_propagated():
    """NaN is treated neither as black nor as unlit."""
    ones, nan = torch.ones(1), torch.tensor([float("nan")])
    assert demodulate(nan, ones, ones).isnan()
    assert demodulate(ones, nan, ones).isnan()
    assert demodulate(ones, ones, nan).isnan()
