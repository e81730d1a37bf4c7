"""KHR_lights_punctual as the scene's sun and point lights, and the brightness of it all.

glTF gives lux and candela; the scene has irradiance / pi and radiant intensity / pi in units of its own, so that one factor is
free. It is chosen such that the brightest light gives what the scenes' default sun gives; the ratios of the lights are kept.
Emission is not scaled with them: glTF's emission of 1 is display white, whatever the lights' units, as viewers have it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError
from supersampling.scenes.gltf.document import Document
from supersampling.scenes.gltf.nodes import Matrix, SceneNode
from supersampling.scenes.gltf.notes import Notes
from supersampling.scenes.scene import PointLight, Sky, Sun

Vector = NDArray[np.float64]
EXTENSION = "KHR_lights_punctual"
BRIGHTEST = 3.0  # radiance / pi that the brightest light gives where it falls, as the default sun's
_FAINT = 0.005  # of the brightest: where a light without a range ends
_NEAREST = 0.03  # of the surface: how much of it a lamp may light more brightly still
_SHADOWED = 8  # point lights with shadow maps, the strongest
_LUMINANCE = np.array((0.2126, 0.7152, 0.0722))
# Indoors, or at night: lamps are what lights the scene, the sky only keeps the shadows from going black.
_DIM = Sky((0.05, 0.07, 0.11), (0.1, 0.1, 0.12), (0.06, 0.055, 0.05))


@dataclass(frozen=True, eq=False)
class PunctualLight:
    """A light of the file in world space; ``power`` is colour times lux or candela, ``toward`` where it shines."""

    kind: str
    power: Vector
    position: Vector
    toward: Vector
    reach: float | None
    cone: tuple[float, float] | None


def read_lights(document: Document, nodes: Sequence[SceneNode], notes: Notes) -> list[PunctualLight]:
    """The lights of the scene's nodes, where they are at time 0."""
    lights = document.extensions.get(EXTENSION, {}).get("lights", [])
    lamps = []
    for placed in nodes:
        index = ((placed.node.extensions or {}).get(EXTENSION) or {}).get("light")
        if index is None:
            continue
        if not 0 <= index < len(lights):
            raise UserError(
                f"{document.name} refers to light {index}, but it has {len(lights)} lights: the file is broken, export it again."
            )
        if placed.place.moves:
            notes.add("moving lights stand where they are at time 0")
        lamp = _lamp(lights[index], index, placed.place.at(0.0), document.name)
        if lamp.power.max() > 0.0:
            lamps.append(lamp)
    return lamps


def _lamp(light: dict[str, Any], index: int, world: Matrix, name: str) -> PunctualLight:
    kind = light.get("type")
    power = np.array([float(c) for c in light.get("color", (1.0, 1.0, 1.0))]) * float(light.get("intensity", 1.0))
    reach = None if light.get("range") is None else float(light["range"])
    if kind not in ("directional", "point", "spot") or power.shape != (3,) or not np.isfinite(power).all():
        raise UserError(
            f"Light {index} of {name} is of type {kind!r} and power {power.tolist()}: use directional, point or spot."
        )
    cone = None
    if kind == "spot":
        spot = light.get("spot") or {}
        outer = float(np.clip(spot.get("outerConeAngle", np.pi / 4.0), 2e-3, np.pi / 2.0))
        # The specification wants inner < outer: between them the light fades.
        cone = (float(np.clip(spot.get("innerConeAngle", 0.0), 0.0, outer - 1e-3)), outer)
    toward = -world[:3, 2]
    length = float(np.linalg.norm(toward))
    # A node of no size has no direction: glTF's own, -z, stands for it.
    toward = toward / length if length > 1e-12 else np.array((0.0, 0.0, -1.0))
    return PunctualLight(kind, np.maximum(power, 0.0), world[:3, 3].copy(), toward, reach, cone)


def lit(
    lamps: Sequence[PunctualLight], surface: Vector, notes: Notes
) -> tuple[Sun | None, tuple[PointLight, ...], Sky]:
    """Sun, point lights and sky. ``surface (N, 3)`` are points of the scene.

    A directional light's brightness is its illuminance, another one's that of the nearest thirtieth of the surface.
    """
    if not lamps:
        return Sun(), (), Sky()
    unit = BRIGHTEST / max(max(_illuminance(lamp, surface) for lamp in lamps), 1e-12)
    suns = sorted((lamp for lamp in lamps if lamp.kind == "directional"), key=lambda lamp: -_luminance(lamp.power))
    if len(suns) > 1:
        notes.add(f"of {len(suns)} directional lights only the brightest is kept")
    points = [_point(lamp, unit, surface) for lamp in lamps if lamp.kind != "directional"]
    strongest = sorted(range(len(points)), key=lambda k: -_luminance(np.array(points[k].intensity)))
    for k in strongest[_SHADOWED:]:
        points[k] = replace(points[k], shadowed=False)
    if not suns:
        return None, tuple(points), _DIM
    return Sun(_triple(-suns[0].toward), _triple(unit * suns[0].power)), tuple(points), Sky()


def _illuminance(lamp: PunctualLight, surface: Vector) -> float:
    if lamp.kind == "directional":
        return _luminance(lamp.power)
    square = np.maximum(((surface - lamp.position) ** 2).sum(axis=1), 1e-6)  # a point on the lamp itself
    return _luminance(lamp.power) / float(np.quantile(square, _NEAREST))


def _point(lamp: PunctualLight, unit: float, surface: Vector) -> PointLight:
    intensity = unit * lamp.power
    reach = np.sqrt(intensity.max() / (_FAINT * BRIGHTEST)) if lamp.reach is None else lamp.reach
    # Far beyond all that it lights, a light's end no longer shows; a shadow map would only lose precision.
    farthest = float(np.linalg.norm(surface - lamp.position, axis=1).max())
    radius = float(np.clip(reach, 0.1, max(10.0 * farthest, 0.1)))
    if lamp.cone is None:
        return PointLight(_triple(lamp.position), _triple(intensity), radius)
    return PointLight(_triple(lamp.position), _triple(intensity), radius, True, _triple(lamp.toward), lamp.cone)


def _luminance(color: Vector) -> float:
    return float(color @ _LUMINANCE)


def _triple(values: Vector) -> tuple[float, float, float]:
    return (float(values[0]), float(values[1]), float(values[2]))
