"""Lights of KHR_lights_punctual as the scene's sun and point lights, and their brightness.

glTF uses lux and candela; a scene uses irradiance / pi and radiant intensity / pi in arbitrary units, so one factor is
free. It makes the brightest light as bright as the scenes' default sun and keeps the ratios of the lights. Emission is
not scaled:
in glTF, as in viewers, an emission of 1 is display white whatever the units of the lights.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError
from supersampling.scenes.gltf.document import Document
from supersampling.scenes.gltf.features import Deviation
from supersampling.scenes.gltf.nodes import Matrix, SceneNode
from supersampling.scenes.gltf.notes import Notes
from supersampling.scenes.scene import PointLight, Sky, Sun

Vector = NDArray[np.float64]
EXTENSION = "KHR_lights_punctual"
BRIGHTEST = 3.0  # irradiance / pi of the brightest light, equal to the default sun's
_FAINT = 0.005  # of the brightest: irradiance at which a light without a range ends
_NEAREST = 0.03  # part of the surface that a light may light even more brightly
_SHADOWED = 8  # strongest point lights, which have shadow maps
_LUMINANCE = np.array((0.2126, 0.7152, 0.0722))
# Indoors or at night, where lights illuminate the scene and the sky only keeps shadows from being black.
_DIM = Sky((0.05, 0.07, 0.11), (0.1, 0.1, 0.12), (0.06, 0.055, 0.05))


@dataclass(frozen=True, eq=False)
class PunctualLight:
    """Light of the file in world space; ``power`` is colour times lux or candela, ``toward`` its direction."""

    kind: str
    power: Vector
    position: Vector
    toward: Vector
    reach: float | None
    cone: tuple[float, float] | None


def read_lights(document: Document, nodes: Sequence[SceneNode], notes: Notes) -> list[PunctualLight]:
    """Return the lights of the scene's nodes, at their positions at time 0."""
    definitions = document.extensions.get(EXTENSION, {}).get("lights", [])
    lights = []
    for node in nodes:
        index = ((node.node.extensions or {}).get(EXTENSION) or {}).get("light")
        if index is None:
            continue
        if not 0 <= index < len(definitions):
            raise UserError(
                f"{document.name} refers to light {index} but has {len(definitions)} lights: the file is broken, "
                "export it again."
            )
        if node.transform.moves:
            notes.add(Deviation.MOVING_LIGHTS)
        light = _light(definitions[index], index, node.transform.matrix(0.0), document.name)
        if light.power.max() > 0.0:
            lights.append(light)
    return lights


def _light(definition: dict[str, Any], index: int, world: Matrix, name: str) -> PunctualLight:
    kind = definition.get("type")
    color = np.array([float(c) for c in definition.get("color", (1.0, 1.0, 1.0))])
    power = color * float(definition.get("intensity", 1.0))
    reach = None if definition.get("range") is None else float(definition["range"])
    if kind not in ("directional", "point", "spot") or power.shape != (3,) or not np.isfinite(power).all():
        raise UserError(
            f"Invalid light {index} of {name}, of type {kind} and power {power.tolist()}: "
            "use a directional, point or spot light of finite power."
        )
    cone = None
    if kind == "spot":
        spot = definition.get("spot") or {}
        outer = float(np.clip(spot.get("outerConeAngle", np.pi / 4.0), 2e-3, np.pi / 2.0))
        # The specification requires inner < outer; the light fades between them.
        cone = (float(np.clip(spot.get("innerConeAngle", 0.0), 0.0, outer - 1e-3)), outer)
    toward = -world[:3, 2]
    length = float(np.linalg.norm(toward))
    # A node of zero scale has no direction: use glTF's default, -z.
    toward = toward / length if length > 1e-12 else np.array((0.0, 0.0, -1.0))
    return PunctualLight(kind, np.maximum(power, 0.0), world[:3, 3].copy(), toward, reach, cone)


def scene_lights(
    lights: Sequence[PunctualLight], surface: Vector, notes: Notes
) -> tuple[Sun | None, tuple[PointLight, ...], Sky]:
    """Return sun, point lights and sky for lights and points ``surface (N, 3)`` of the scene.

    The brightness of a directional light is its illuminance, that of other lights their illuminance on the nearest 3%
    of the surface.
    """
    if not lights:
        return Sun(), (), Sky()
    unit = BRIGHTEST / max(max(_illuminance(light, surface) for light in lights), 1e-12)
    suns = sorted(
        (light for light in lights if light.kind == "directional"), key=lambda light: -_luminance(light.power)
    )
    if len(suns) > 1:
        notes.add(Deviation.SUNS)
    points = [_point(light, unit, surface) for light in lights if light.kind != "directional"]
    strongest = sorted(range(len(points)), key=lambda k: -_luminance(np.array(points[k].intensity)))
    for k in strongest[_SHADOWED:]:
        points[k] = replace(points[k], shadowed=False)
    if not suns:
        return None, tuple(points), _DIM
    return Sun(_triple(-suns[0].toward), _triple(unit * suns[0].power)), tuple(points), Sky()


def _illuminance(light: PunctualLight, surface: Vector) -> float:
    if light.kind == "directional":
        return _luminance(light.power)
    square = np.maximum(((surface - light.position) ** 2).sum(axis=1), 1e-6)  # a point at the light's position
    return _luminance(light.power) / float(np.quantile(square, _NEAREST))


def _point(light: PunctualLight, unit: float, surface: Vector) -> PointLight:
    intensity = unit * light.power
    reach = np.sqrt(intensity.max() / (_FAINT * BRIGHTEST)) if light.reach is None else light.reach
    # A larger radius would not be visible, and shadow maps would lose precision.
    farthest = float(np.linalg.norm(surface - light.position, axis=1).max())
    radius = float(np.clip(reach, 0.1, max(10.0 * farthest, 0.1)))
    if light.cone is None:
        return PointLight(_triple(light.position), _triple(intensity), radius)
    return PointLight(_triple(light.position), _triple(intensity), radius, True, _triple(light.toward), light.cone)


def _luminance(color: Vector) -> float:
    return float(color @ _LUMINANCE)


def _triple(values: Vector) -> tuple[float, float, float]:
    return (float(values[0]), float(values[1]), float(values[2]))
