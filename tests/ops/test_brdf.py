"""Tests of the table and of the material component against integrals of the BRDF in float64."""

import numpy as np
import pytest
import torch

from supersampling.ops.brdf import MIN_ROUGHNESS, hammersley, integrate_table, material, specular_f0


def reflectance(light, v, n, roughness, albedo, metallic):
    """Return equations 1 to 10 for unit vectors ``(..., 3)`` and one colour channel; 0 for light below the horizon."""
    alpha = roughness**2
    k = (alpha + 1.0) ** 2 / 8.0
    half = light + v
    half = half / np.maximum(np.linalg.norm(half, axis=-1, keepdims=True), 1e-300)
    n_l, n_v, n_h, v_h = light @ n, v @ n, half @ n, half @ v
    lit = n_l > 0.0
    n_l = np.where(lit, n_l, 1.0)
    f0 = 0.04 * (1.0 - metallic) + albedo * metallic
    d = alpha**2 / (np.pi * (n_h**2 * (alpha**2 - 1.0) + 1.0) ** 2)
    f = f0 + (1.0 - f0) * (1.0 - v_h) ** 5
    g = n_l / (n_l * (1.0 - k) + k) * n_v / (n_v * (1.0 - k) + k)
    return np.where(lit, (1.0 - metallic) * albedo / np.pi + d * f * g / (4.0 * n_v * n_l), 0.0)


def directional_albedo(n_dot_v, roughness, albedo, metallic, order=24, azimuths=192):
    """Integrate BRDF times cosine over all light directions, by Gauss-Legendre rings around the mirror direction."""
    n = np.array((0.0, 0.0, 1.0))
    v = np.array((np.sqrt(1.0 - n_dot_v**2), 0.0, n_dot_v))
    mirror = np.array((-v[0], 0.0, n_dot_v))
    side = np.array((n_dot_v, 0.0, v[0]))
    edges = np.concatenate(([0.0], np.geomspace(max(0.1 * roughness**2, 1e-4), np.pi, 16)))
    x, w = np.polynomial.legendre.leggauss(order)
    middle, reach = 0.5 * (edges[1:] + edges[:-1]), 0.5 * (edges[1:] - edges[:-1])
    polar = (middle[:, None] + reach[:, None] * x).ravel()
    weight = (reach[:, None] * w).ravel() * np.sin(polar)
    # Only one half: the second is its mirror image.
    azimuth = (np.arange(azimuths) + 0.5) / azimuths * np.pi
    polar, azimuth = polar[:, None, None], azimuth[None, :, None]
    across = np.cos(azimuth) * side + np.sin(azimuth) * np.array((0.0, 1.0, 0.0))
    light = np.cos(polar) * mirror + np.sin(polar) * across
    value = reflectance(light, v, n, roughness, albedo, metallic) * (light @ n)
    return float((weight[:, None] * value).sum() * 2.0 * np.pi / azimuths)


def scale_and_bias(n_dot_v, roughness, **rule):
    """Return A and B by equation 15: the integral is linear in F0, and a pure metal has F0 = albedo."""
    black, white = (directional_albedo(n_dot_v, roughness, f0, 1.0, **rule) for f0 in (0.0, 1.0))
    return white - black, black


def test_reference_integral_is_correct():
    """A diffuse surface reflects its albedo for any centre of the rings; a uniform grid over the hemisphere agrees."""
    diffuse = [directional_albedo(c, 0.7, 0.5, 0.0) - directional_albedo(c, 0.7, 0.04, 1.0) for c in (0.05, 0.5, 1.0)]
    np.testing.assert_allclose(diffuse, 0.5, rtol=2e-4)

    n_z, azimuth = np.meshgrid((np.arange(1000) + 0.5) / 1000, (np.arange(1000) + 0.5) / 1000 * 2.0 * np.pi)
    sin = np.sqrt(1.0 - n_z**2)
    light = np.stack((sin * np.cos(azimuth), sin * np.sin(azimuth), n_z), axis=-1)
    value = reflectance(light, np.array((0.8, 0.0, 0.6)), np.array((0.0, 0.0, 1.0)), 0.5, 0.7, 0.3) * n_z
    assert directional_albedo(0.6, 0.5, 0.7, 0.3) == pytest.approx(value.mean() * 2.0 * np.pi, rel=1e-4)


def test_table_equals_the_integral():
    """Ten by ten texels with centres at 0.05, 0.15, ..."""
    table = integrate_table(10, 1024).double().numpy()
    centres = (np.arange(10) + 0.5) / 10
    truth = np.array([[scale_and_bias(c, r) for c in centres] for r in centres])
    np.testing.assert_allclose(table[0], truth[..., 0], rtol=0.01)
    np.testing.assert_allclose(table[1], truth[..., 1], rtol=0.01, atol=5e-5)
    np.testing.assert_allclose(table.sum(axis=0), truth.sum(axis=-1), rtol=0.005)


@pytest.mark.slow
def test_full_table_equals_the_integral():
    """The default table, on a finer grid, including grazing angles, with roughness from the renderer's minimum to 1."""
    table = integrate_table().double().numpy()
    rows = [int(MIN_ROUGHNESS * 512), *range(64, 512, 48), 511]
    columns = [1, 5, 25, 26, *range(50, 512, 50), 511]
    for j in rows:
        for i in columns:
            a, b = scale_and_bias((i + 0.5) / 512, (j + 0.5) / 512, order=48, azimuths=768)
            assert table[0, j, i] == pytest.approx(a, rel=0.01), (i, j)
            assert table[1, j, i] == pytest.approx(b, rel=0.01, abs=1.5e-4), (i, j)
            assert table[:, j, i].sum() == pytest.approx(a + b, rel=0.005), (i, j)


def test_no_surface_reflects_more_light_than_it_receives():
    table = integrate_table(64, 256)
    assert table.dtype == torch.float32
    assert table.min() >= 0.0
    assert table.sum(dim=0).max() <= 1.0 + 1e-6


def test_mirror_limit():
    """As roughness goes to 0, all light is mirrored: A + B = G1(n.v)^2 with k = 1/8, split by Fresnel."""
    table = integrate_table(64, 64)[:, 0].double()
    cosine = (torch.arange(64, dtype=torch.float64) + 0.5) / 64
    g = (cosine / (cosine * 7.0 / 8.0 + 1.0 / 8.0)) ** 2
    fresnel = (1.0 - cosine) ** 5
    torch.testing.assert_close(table[0], g * (1.0 - fresnel), rtol=2e-3, atol=2e-5)
    torch.testing.assert_close(table[1], g * fresnel, rtol=2e-3, atol=2e-5)
    assert table[0, -1] == pytest.approx(1.0, abs=2e-3)


def test_table_is_deterministic():
    assert torch.equal(integrate_table(6, 64), integrate_table(6, 64))


def test_hammersley_points():
    expected = torch.tensor([[0.125, 0.375, 0.625, 0.875], [0.125, 0.625, 0.375, 0.875]], dtype=torch.float64)
    torch.testing.assert_close(hammersley(4), expected)
    assert hammersley(1).tolist() == [[0.5], [0.5]]
    points = hammersley(1000)
    assert points.min() > 0.0
    assert points.max() < 1.0
    # One point in each of the 8 x 125 boxes of equal area would be perfect; none may hold more than 3.
    boxes = torch.bincount((points[0] * 125).long() * 8 + (points[1] * 8).long(), minlength=1000)
    assert boxes.max() <= 3


def surfaces(*rows):
    """Return `material`'s arguments, each ``(1, C, 1, N)``, of rows ``(albedo, metallic, roughness, n_dot_v)``."""
    columns = torch.tensor(rows, dtype=torch.float64).T[:, None, None, None, :]
    albedo = columns[0].expand(1, 3, 1, -1)
    return albedo, columns[1], columns[2], specular_f0(albedo, columns[1]), columns[3]


def test_material_is_the_integral_of_the_brdf():
    """F_beta (equation 11), also between texels, for dielectrics, metals and mixtures."""
    rows = [
        (albedo, metallic, roughness, n_dot_v)
        for albedo, metallic in ((0.6, 0.0), (0.9, 1.0), (0.3, 0.5), (0.0, 0.0), (0.02, 1.0))
        for roughness in (0.08, 0.21, 0.5, 1.0)
        for n_dot_v in (0.05, 0.3, 0.77, 1.0)
    ]
    truth = [directional_albedo(c, r, albedo, metallic) for albedo, metallic, r, c in rows]
    result = material(*surfaces(*rows), table=integrate_table(256, 1024).double())
    assert result.shape == (1, 3, 1, len(rows))
    for channel in result[0, :, 0]:
        np.testing.assert_allclose(channel.numpy(), truth, rtol=0.01)


def test_material_interpolates_texels():
    table = torch.rand(2, 16, 16, dtype=torch.float64)
    metal = {"albedo": torch.ones(1, 3, 1, 1).double(), "metallic": torch.ones(1, 1, 1, 1).double()}
    for j, i in ((2, 0), (3, 7), (15, 15)):
        texel = {
            "n_dot_v": torch.full((1, 1, 1, 1), (i + 0.5) / 16),
            "roughness": torch.full((1, 1, 1, 1), (j + 0.5) / 16),
        }
        value = material(**metal, **texel, specular=torch.full((1, 3, 1, 1), 0.25), table=table)
        torch.testing.assert_close(value, (0.25 * table[0, j, i] + table[1, j, i]).expand(1, 3, 1, 1))
    corner = {"n_dot_v": torch.full((1, 1, 1, 1), 5.0 / 16), "roughness": torch.full((1, 1, 1, 1), 6.0 / 16)}
    value = material(**metal, **corner, specular=torch.zeros(1, 3, 1, 1), table=table)
    torch.testing.assert_close(value, table[1, 5:7, 4:6].mean().expand(1, 3, 1, 1))


def test_material_clamps_n_dot_v_and_roughness():
    table = integrate_table(32, 64).double()
    outside = material(*surfaces((0.5, 0.2, 0.4, -0.3), (0.5, 0.2, 0.4, 1.7), (0.5, 0.2, 0.0, 0.6)), table=table)
    inside = material(
        *surfaces((0.5, 0.2, 0.4, 0.5 / 32), (0.5, 0.2, 0.4, 31.5 / 32), (0.5, 0.2, MIN_ROUGHNESS, 0.6)), table=table
    )
    torch.testing.assert_close(outside, inside)


def test_material_of_pixels_and_channels_is_independent():
    """Batch, rows, columns and colour channels do not affect each other."""
    generator = torch.Generator().manual_seed(3)
    albedo, specular = torch.rand(2, 2, 3, 4, 5, generator=generator)
    metallic, roughness, n_dot_v = torch.rand(3, 2, 1, 4, 5, generator=generator)
    table = integrate_table(16, 64)
    whole = material(albedo, metallic, roughness, specular, n_dot_v, table)
    for b, y, x in ((0, 0, 0), (1, 3, 1), (0, 2, 4), (1, 0, 3)):
        pixel = [t[b : b + 1, :, y : y + 1, x : x + 1] for t in (albedo, metallic, roughness, specular, n_dot_v)]
        for c in range(3):
            grey = [t if t.shape[1] == 1 else t[:, c : c + 1].expand(1, 3, 1, 1) for t in pixel]
            torch.testing.assert_close(material(*grey, table)[0, 0, 0, 0], whole[b, c, y, x])


def test_material_of_half_precision_is_computed_in_float32():
    table = integrate_table(64, 64)
    halves = [t.half() for t in surfaces((0.61, 0.3, 0.37, 0.123), (0.2, 1.0, 0.9, 0.877))]
    result = material(*halves, table=table)
    assert result.dtype == torch.float32
    torch.testing.assert_close(result, material(*(t.float() for t in halves), table=table), rtol=0, atol=0)


def test_material_gradients():
    """Away from texel centres, where a bilinear lookup is not differentiable."""
    table = integrate_table(8, 64).double()
    inputs = surfaces((0.6, 0.2, 0.37, 0.41), (0.3, 0.9, 0.7, 0.22))
    leaves = [t.clone().requires_grad_() for t in inputs]
    assert torch.autograd.gradcheck(lambda *x: material(*x, table=table), leaves)


def test_specular_f0():
    albedo = torch.tensor([0.9, 0.5, 0.0]).reshape(1, 3, 1, 1)
    for metallic, expected in ((0.0, (0.04, 0.04, 0.04)), (1.0, (0.9, 0.5, 0.0)), (0.5, (0.47, 0.27, 0.02))):
        result = specular_f0(albedo, torch.full((1, 1, 1, 1), metallic))
        torch.testing.assert_close(result.flatten(), torch.tensor(expected))
