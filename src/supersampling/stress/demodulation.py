"""Demodulation at the limits of its division: F_beta towards 0, roughness 0, grazing view."""

from collections.abc import Callable
from functools import cache, partial

import torch
from torch import Tensor

from supersampling.ops.brdf import integrate_table, material, specular_f0
from supersampling.ops.demodulate import MIN_MATERIAL
from supersampling.stress.clip import Clip, change_buffers, fill_buffers
from supersampling.stress.extreme import Extreme

MATERIAL = frozenset({"material", "high_material"})
LIT = (("radiance", "material", "emission"), ("target_radiance", "high_material", "high_emission"))


@cache
def table() -> Tensor:
    """Return a small table of the integrated BRDF; the surfaces below lie in its first row and column."""
    return integrate_table(64, 128).double()


def surface(clip: Clip, albedo: float, metallic: float, roughness: float, n_dot_v: float) -> Clip:
    """Return the clip with F_beta of one surface everywhere, lit by a light of 1."""
    ones = torch.ones(1, 1, 1, 1, dtype=torch.float64)
    colour = albedo * ones.expand(1, 3, 1, 1)
    f0 = specular_f0(colour, metallic * ones)
    value = material(colour, metallic * ones, roughness * ones, f0, n_dot_v * ones, table()).view(3, 1, 1)
    return light(change_buffers(clip, lambda values: value.expand_as(values).clone(), *MATERIAL))


def uniform(clip: Clip, value: float) -> Clip:
    """Return the clip with one value of F_beta everywhere, lit by a light of 1."""
    return light(fill_buffers(clip, value, *MATERIAL))


def inconsistent(clip: Clip, value: float) -> Clip:
    """Return the clip with one value of F_beta everywhere, under a radiance that it cannot have reflected."""
    return fill_buffers(clip, value, *MATERIAL)


def light(clip: Clip) -> Clip:
    """Return the clip with the radiance that a light of 1 causes."""
    for radiance, reflecting, emission in LIT:
        if radiance in clip and reflecting in clip:
            clip = {**clip, radiance: clip[reflecting] + clip[emission]}
    return clip


def _extreme(name: str, meaning: str, change: Callable[[Clip], Clip]) -> Extreme:
    return Extreme(f"demodulation/{name}", meaning, change=change, touches=MATERIAL)


def _surface(name: str, meaning: str, albedo: float, metallic: float, roughness: float, n_dot_v: float) -> Extreme:
    change = partial(surface, albedo=albedo, metallic=metallic, roughness=roughness, n_dot_v=n_dot_v)
    return _extreme(name, meaning, change)


DEMODULATION = (
    _extreme("F_beta 0", "F_beta is 0 everywhere, radiance is not.", partial(inconsistent, value=0.0)),
    _extreme("F_beta least", "F_beta is the smallest divisor, 2^-14.", partial(uniform, value=MIN_MATERIAL)),
    _extreme(
        "F_beta below", "F_beta is just below the smallest divisor.", partial(uniform, value=MIN_MATERIAL * 0.999)
    ),
    _extreme(
        "F_beta small and lit",
        "F_beta is 2^-14 under a radiance that it cannot have reflected: a lighting of 10^4.",
        partial(inconsistent, value=MIN_MATERIAL),
    ),
    _surface("roughness 0", "A metal mirror, seen at 60 degrees.", 0.9, 1.0, 0.0, 0.5),
    _surface("grazing", "N.V is 0 on a rough dielectric.", 0.5, 0.0, 1.0, 0.0),
    _surface("black smooth grazing", "Albedo 0, roughness 0, N.V 0.", 0.0, 0.0, 0.0, 0.0),
)
