"""What a surface reflects in all: the pre-integrated BRDF table and the material component made from it.

Li et al. 2024 (NSRD), supplement, section 1; equation numbers are the supplement's. Symbols: ``n`` normal, ``l`` and ``v`` the
directions to the light and to the eye (the paper's omega_i, omega_o), ``h`` half vector, ``alpha = roughness**2``.

Two readings of the paper:
- It calls alpha "the roughness". Ours is the perceptual roughness of a material, and alpha its square, as in Burley's Disney
  model, which the paper builds on; equations 5 and 10 both take that alpha.
- Equation 4 prints ``4 (v.h) (l.h)`` below the fraction. Cook and Torrance, whom it cites, have ``4 (n.v) (n.l)``, and so have
  we: as printed, a rough surface would reflect almost nothing at grazing angles.
"""

import math

import torch
import torch.nn.functional as F
from torch import Tensor

MIN_ROUGHNESS = 0.08  # the renderer's floor: the mirror image of a point light has no finite radiance
DIELECTRIC_F0 = 0.04  # equation 7
PIECE = 2**14  # integrand values at once: 64 KB stay in a core's cache, and with malloc instead of the system


def hammersley(count: int) -> Tensor:
    """``(2, count)`` float64 points that fill the open unit square evenly; the same ones every time."""
    index = torch.arange(count, dtype=torch.int64)
    # The index's binary digits in reverse, behind the point.
    mirrored = torch.zeros(count, dtype=torch.float64)
    for bit in range(max(count - 1, 1).bit_length()):
        mirrored += ((index >> bit) & 1) * 0.5 ** (bit + 1)
    return torch.stack(((index + 0.5) / count, mirrored + 0.5 / count))


def _integrate(roughness: float, n_dot_v: Tensor, points: Tensor) -> Tensor:
    """``(2, N)`` A and B (equations 16 and 17) at ``n_dot_v (N,)`` in (0, 1] for one roughness > 0.

    Half vectors are drawn from those that the eye sees (Heitz 2018; as a cap of the sphere: Dupuy and Benyoub 2023), whose
    density leaves ``G1(l) G1(v) / smith(v)`` to be averaged: smooth and bounded, where the density of all half vectors would
    miss A by some percent at grazing angles.
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
    # Light from below the horizon counts as none: its weight is 0 through its cosine.
    n_dot_l = (2.0 * v_dot_h * h_z / length - cos_v).clamp(min=0.0)

    def masking(cosine: Tensor) -> Tensor:  # equation 9
        return cosine / (cosine * (1.0 - k) + k)

    smith = 2.0 * cos_v / (cos_v + (alpha * alpha + (1.0 - alpha * alpha) * cos_v * cos_v).sqrt())
    weight = masking(n_dot_l) * (masking(cos_v) / smith)
    fresnel = (1.0 - v_dot_h).pow(5)  # equation 18
    bias = (weight * fresnel).mean(dim=1)
    return torch.stack((weight.mean(dim=1) - bias, bias))


def integrate_table(size: int = 512, samples: int = 1024) -> Tensor:
    """The table of A and B, equations 15 to 18: ``specular reflectance = F0 * A + B``.

    Column ``i`` is ``n_dot_v = (i + 0.5) / size``; row ``j`` is the perceptual roughness ``(j + 0.5) / size`` (the paper's
    vertical axis is "roughness alpha"; the perceptual one spends its rows where the table changes). Float32 all along is
    within 4e-7 of float64. Everyone but tests wants `supersampling.data.brdf_table`, which keeps it.

    Returns:
        ``(2, size, size)`` float32 in [0, 1].
    """
    centres = (torch.arange(size, dtype=torch.float64) + 0.5) / size
    pieces = centres.float().split(max(1, PIECE // samples))
    points = hammersley(samples).float()
    rows = [torch.cat([_integrate(r, piece, points) for piece in pieces], dim=1) for r in centres.tolist()]
    return torch.stack(rows, dim=1).clamp(0.0, 1.0)


def specular_f0(albedo: Tensor, metallic: Tensor) -> Tensor:
    """F0, the reflectance at normal incidence, ``(B, 3, h, w)`` (equation 7): 0.04, or the albedo where all metal.

    Args:
        albedo: ``(B, 3, h, w)`` linear, in [0, 1].
        metallic: ``(B, 1, h, w)`` in [0, 1].
    """
    return DIELECTRIC_F0 + (albedo - DIELECTRIC_F0) * metallic


def material(
    albedo: Tensor, metallic: Tensor, roughness: Tensor, specular: Tensor, n_dot_v: Tensor, table: Tensor
) -> Tensor:
    """The material component F_beta of NSRD equation 3: ``(1 - m) c + F0 A + B`` (equations 12, 14 and 15).

    Half-precision buffers are computed on in float32. The sky has no material: whatever its buffers hold is not masked here.

    Args:
        albedo: ``c``, ``(B, 3, h, w)`` linear, in [0, 1].
        metallic: ``m``, ``(B, 1, h, w)`` in [0, 1].
        roughness: perceptual, ``(B, 1, h, w)`` in [0, 1]; floored at `MIN_ROUGHNESS`, as the renderer's shading is.
        specular: F0, ``(B, 3, h, w)`` in [0, 1]; see `specular_f0`.
        n_dot_v: ``(B, 1, h, w)``; outside of [0, 1] (a shading normal that looks away) it counts as the nearer end.
        table: ``(2, size, size)`` of `integrate_table`, on the buffers' device.

    Returns:
        ``(B, 3, h, w)``, 0 or more; float32 (float64 if the albedo is).
    """
    dtype = torch.promote_types(albedo.dtype, torch.float32)
    albedo, metallic, roughness, specular, n_dot_v, table = (
        x.to(dtype) for x in (albedo, metallic, roughness, specular, n_dot_v, table)
    )
    place = torch.cat((n_dot_v, roughness.clamp(min=MIN_ROUGHNESS)), dim=1).permute(0, 2, 3, 1) * 2.0 - 1.0
    tables = table.expand(len(place), -1, -1, -1)
    a, b = F.grid_sample(tables, place, padding_mode="border", align_corners=False).split(1, dim=1)
    return (1.0 - metallic) * albedo + specular * a + b
