"""Demodulation where there is nothing to divide by: F_beta towards 0, roughness 0, grazing view."""

from functools import cache, partial

import torch
from torch import Tensor

from supersampling.ops.brdf import integrate_table, material, specular_f0
from supersampling.ops.demodulate import MIN_MATERIAL
from supersampling.stress.clip import Clip, each
from supersampling.stress.extreme import Extreme

MATERIAL = frozenset({"material", "high_material"})


@cache
def table() -> Tensor:
    """A small one; what is tried lies in its first row and column."""
    return integrate_table(64, 128).double()


def surface(clip: Clip, albedo: float, metallic: float, roughness: float, n_dot_v: float) -> Clip:
    """F_beta of one surface everywhere, and the radiance that light of 1 leaves on it."""
    one = torch.ones(1, 1, 1, 1, dtype=torch.float64)
    colour = albedo * one.expand(1, 3, 1, 1)
    value = material(
        colour, metallic * one, roughness * one, specular_f0(colour, metallic * one), n_dot_v * one, table()
    ).view(3, 1, 1)
    return lit(each(clip, lambda v: value.expand_as(v).clone(), *MATERIAL))


def even(clip: Clip, value: float) -> Clip:
    """F_beta of one value everywhere, lit by 1."""
    return lit(each(clip, lambda v: torch.full_like(v, value), *MATERIAL))


def unlit_by(clip: Clip, value: float) -> Clip:
    """F_beta of one value below a radiance that it cannot have reflected."""
    return each(clip, lambda v: torch.full_like(v, value), *MATERIAL)


def lit(clip: Clip) -> Clip:
    """Radiance as light of 1 makes it."""
    for light, reflecting, emission in (
        ("radiance", "material", "emission"), ("target_radiance", "high_material", "high_emission"),
    ):  # fmt: skip
        if light in clip and reflecting in clip:
            clip = {**clip, light: clip[reflecting] + clip[emission]}
    return clip


def _extreme(name: str, says: str, change: object) -> Extreme:
    return Extreme(f"demodulation/{name}", says, change, MATERIAL)  # type: ignore[arg-type]


DEMODULATION = (
    _extreme("F_beta 0", "F_beta is 0 everywhere, radiance is not.", partial(unlit_by, value=0.0)),
    _extreme("F_beta least", "F_beta is the least that is divided by, 2^-14.", partial(even, value=MIN_MATERIAL)),
    _extreme("F_beta below", "F_beta is just below the least.", partial(even, value=MIN_MATERIAL * 0.999)),
    _extreme("F_beta small and lit", "F_beta is 2^-14 below a radiance that it cannot have reflected: a lighting of 10^4.",
             partial(unlit_by, value=MIN_MATERIAL)),
    _extreme("roughness 0", "A mirror of metal, seen at 60 degrees.",
             partial(surface, albedo=0.9, metallic=1.0, roughness=0.0, n_dot_v=0.5)),
    _extreme("grazing", "N.V is 0 on a rough dielectric.",
             partial(surface, albedo=0.5, metallic=0.0, roughness=1.0, n_dot_v=0.0)),
    _extreme("black smooth grazing", "Albedo 0, roughness 0, N.V 0.",
             partial(surface, albedo=0.0, metallic=0.0, roughness=0.0, n_dot_v=0.0)),
)  # fmt: skip
