"""Total reflectance of a surface: the pre-integrated BRDF table and the material component computed from it.

Li et al. 2024 (NSRD), supplement, section 1; equation numbers are the supplement's. Symbols: ``n`` normal, ``l`` and
``v`` the directions to the light and to the eye (the paper's omega_i, omega_o), ``h`` half vector,
``alpha = roughness**2``.

Two interpretations of the paper:
- It calls alpha "the roughness". Here ``roughness`` is the perceptual roughness of a material and alpha its square, as
  in Burley's Disney model, which the paper builds on; equations 5 and 10 both use that alpha.
- Equation 4 prints the denominator ``4 (v.h) (l.h)``. Cook and Torrance, whom it cites, have ``4 (n.v) (n.l)``, which
  is used here: as printed, a rough surface would reflect almost nothing at grazing angles.
"""

import math

import torch
import torch.nn.functional as F
from torch import Tensor

# The renderer's lower bound: the mirror image of a point light has no finite radiance.
MIN_ROUGHNESS = 0.08
DIELECTRIC_F0 = 0.04  # equation 7
# Integrand values per batch: 64 KB fit in a core's cache, and malloc serves them without a system call.
BATCH = 2**14


def hammersley(count: int) -> Tensor:
    """Return ``(2, count)`` float64 points that fill the open unit square evenly; the result is deterministic."""
    index = torch.arange(count, dtype=torch.int64)
    # The binary digits of the index in reverse order, after the binary point.
    mirrored = torch.zeros(count, dtype=torch.float64)
    for bit in range(max(count - 1, 1).bit_length()):
        mirrored += ((index >> bit) & 1) * 0.5 ** (bit + 1)
    return torch.stack(((index + 0.5) / count, mirrored + 0.5 / count))


def _integrate(roughness: float, n_dot_v: Tensor, points: Tensor) -> Tensor:
    """Return A and B (equations 16 and 17), ``(2, N)``, at ``n_dot_v (N,)`` in (0, 1] for one positive roughness.

    Half vectors are drawn from the visible ones (Heitz 2018; as a cap of the sphere: Dupuy and Benyoub 2023). With
    their density the averaged weight is ``G1(l) G1(v) / smith(v)``, which is smooth and bounded; with the density of
    all half vectors, A would be wrong by some percent at grazing angles.
    """
    alpha = roughness * roughness
    k = (alpha + 1.0) ** 2 / 8.0  # equation 10
    cos_v = n_dot_v[:, None]
    sin_v = (1.0 - cos_v * cos_v).clamp(min=0.0).sqrt()
    # The eye's direction where the ellipsoid of normals is a sphere; the plane of n and v is that of x and z.
    stretch = torch.hypot(alpha * sin_v, cos_v)
    eye_x, eye_z = alpha * sin_v / stretch, cos_v / stretch
    z = (1.0 - points[0]) * (1.0 + eye_z) - eye_z
    radius = (1.0 - z * z).clamp(min=0.0).sqrt()
    azimuth = 2.0 * math.pi * points[1]
    h_x = alpha * (radius * torch.cos(azimuth) + eye_x)
    h_y = alpha * radius * torch.sin(azimuth)
    h_z = z + eye_z
    length = torch.sqrt(h_x * h_x + h_y * h_y + h_z * h_z)
    v_dot_h = ((sin_v * h_x + cos_v * h_z) / length).clamp(0.0, 1.0)
    # Light from below the horizon does not count: its cosine, and so its weight, is 0.
    n_dot_l = (2.0 * v_dot_h * h_z / length - cos_v).clamp(min=0.0)

    def masking(cosine: Tensor) -> Tensor:
        """Return G1 (equation 9)."""
        return cosine / (cosine * (1.0 - k) + k)

    smith = 2.0 * cos_v / (cos_v + (alpha * alpha + (1.0 - alpha * alpha) * cos_v * cos_v).sqrt())
    weight = masking(n_dot_l) * (masking(cos_v) / smith)
    fresnel = (1.0 - v_dot_h).pow(5)  # equation 18
    bias = (weight * fresnel).mean(dim=1)
    return torch.stack((weight.mean(dim=1) - bias, bias))


def integrate_table(size: int = 512, samples: int = 1024) -> Tensor:
    """Compute the table of A and B, equations 15 to 18: ``specular reflectance = F0 * A + B``.

    Column ``i`` is ``n_dot_v = (i + 0.5) / size``; row ``j`` is the perceptual roughness ``(j + 0.5) / size`` (the
    paper's vertical axis is "roughness alpha"; with perceptual roughness, more rows fall where the table changes).
    Computing in float32 throughout is within 4e-7 of float64. Use `supersampling.data.brdf_table` outside tests: it
    caches the table.

    Returns:
        ``(2, size, size)`` float32 in [0, 1].
    """
    centres = (torch.arange(size, dtype=torch.float64) + 0.5) / size
    batches = centres.float().split(max(1, BATCH // samples))
    points = hammersley(samples).float()
    rows = [torch.cat([_integrate(r, batch, points) for batch in batches], dim=1) for r in centres.tolist()]
    return torch.stack(rows, dim=1).clamp(0.0, 1.0)


def specular_f0(albedo: Tensor, metallic: Tensor) -> Tensor:
    """Return F0, the reflectance at normal incidence, ``(B, 3, h, w)`` (equation 7): 0.04, or the albedo of pure metal.

    Args:
        albedo: ``(B, 3, h, w)`` linear, in [0, 1].
        metallic: ``(B, 1, h, w)`` in [0, 1].
    """
    return DIELECTRIC_F0 + (albedo - DIELECTRIC_F0) * metallic


def material(
    albedo: Tensor, metallic: Tensor, roughness: Tensor, specular: Tensor, n_dot_v: Tensor, table: Tensor
) -> Tensor:
    """Return the material component F_beta of NSRD equation 3: ``(1 - m) c + F0 A + B`` (equations 12, 14 and 15).

    Half-precision buffers are converted to float32 first. The sky has no material; its pixels are not masked here.

    Args:
        albedo: ``c``, ``(B, 3, h, w)`` linear, in [0, 1].
        metallic: ``m``, ``(B, 1, h, w)`` in [0, 1].
        roughness: perceptual, ``(B, 1, h, w)`` in [0, 1]; clamped to at least `MIN_ROUGHNESS`, as in the
            renderer's shading.
        specular: F0, ``(B, 3, h, w)`` in [0, 1]; see `specular_f0`.
        n_dot_v: ``(B, 1, h, w)``; clamped to [0, 1], which it leaves where a shading normal faces away.
        table: ``(2, size, size)`` of `integrate_table`, on the buffers' device.

    Returns:
        ``(B, 3, h, w)``, non-negative; float32 (float64 if the albedo is).
    """
    dtype = torch.promote_types(albedo.dtype, torch.float32)
    albedo, metallic, roughness, specular, n_dot_v, table = (
        x.to(dtype) for x in (albedo, metallic, roughness, specular, n_dot_v, table)
    )
    grid = torch.cat((n_dot_v, roughness.clamp(min=MIN_ROUGHNESS)), dim=1).permute(0, 2, 3, 1) * 2.0 - 1.0
    tables = table.expand(len(grid), -1, -1, -1)
    a, b = F.grid_sample(tables, grid, padding_mode="border", align_corners=False).split(1, dim=1)
    return (1.0 - metallic) * albedo + specular * a + b
