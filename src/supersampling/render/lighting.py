"""Lights of a scene as inputs of the lighting pass."""

import moderngl
import numpy as np
from numpy.typing import NDArray

from supersampling.render.camera import Matrix
from supersampling.render.frustum import visible
from supersampling.render.gpu_scene import GpuScene
from supersampling.render.programs import Programs, assign
from supersampling.render.shadows import CUBE_NORMAL_OFFSET, Casters, PointShadows, SunShadows
from supersampling.scenes.scene import PointLight

MAX_LIGHTS = 64  # in view at once; only the nearest are drawn


def spot(light: PointLight) -> tuple[float, float, float, float]:
    """Return ``(direction * scale, offset)`` of KHR_lights_punctual's angular attenuation.

    (0, 0, 0, 1) shines in all directions.
    """
    if light.cone is None:
        return 0.0, 0.0, 0.0, 1.0
    inner, outer = (float(np.cos(angle)) for angle in light.cone)
    scale = 1.0 / max(inner - outer, 1e-3)
    axis = np.asarray(light.direction, np.float64)
    x, y, z = axis * (scale / max(float(np.linalg.norm(axis)), 1e-9))
    return float(x), float(y), float(z), -outer * scale


class Lights:
    """Sun, sky and point lights with their shadow maps."""

    def __init__(self, ctx: moderngl.Context, gpu: GpuScene, casters: Casters, shadow_size: int) -> None:
        scene = gpu.scene
        self._scene, self._gpu = scene, gpu
        self._sun = SunShadows(ctx, gpu, casters, scene.sun, shadow_size) if scene.sun else None
        self._positions = np.array([p.position for p in scene.points], np.float64).reshape(-1, 3)
        self._radii = np.array([p.radius for p in scene.points], np.float64)
        shadowed = [p for p in scene.points if p.shadowed]
        self._rows = np.full(len(scene.points), -1)
        self._rows[[i for i, p in enumerate(scene.points) if p.shadowed]] = np.arange(len(shadowed))
        self._cubes = PointShadows(ctx, gpu, casters, shadowed) if shadowed else None
        self._block = ctx.buffer(reserve=MAX_LIGHTS * 48, dynamic=True)
        offset = f"CUBE_OFFSET {CUBE_NORMAL_OFFSET}"
        self._definitions = (f"MAX_LIGHTS {MAX_LIGHTS}", offset, *(("SUN",) if scene.sun else ()))

    def prepare(
        self, programs: Programs, eye: NDArray[np.float64], planes: Matrix, radiance: bool
    ) -> moderngl.VertexArray:
        """Update the shadow maps that the view needs, and return the lighting pass with its light uniforms set."""
        parts = ("brdf", "surface", "sky", "display", "shadow_lookup", "lighting_fragment")
        array = programs.screen(parts, (*self._definitions, *(("RADIANCE",) if radiance else ())))
        program = array.program
        if self._sun and self._scene.sun:
            self._sun.update(eye)
            self._sun.bind(program, self._scene.sun)
        seen = self._visible(eye, planes)
        if self._cubes:
            self._cubes.update([int(r) for r in self._rows[seen] if r >= 0])
            self._cubes.bind(program)
        self._write(seen)
        self._block.bind_to_uniform_block(1)
        assign(program, light_count=len(seen))
        return array

    def _visible(self, eye: NDArray[np.float64], planes: Matrix) -> NDArray[np.int64]:
        """Return the indices of the nearest `MAX_LIGHTS` point lights whose sphere the view may see."""
        reach = self._radii[:, None]
        seen = np.flatnonzero(visible((self._positions - reach, self._positions + reach), planes))
        nearest = np.argsort(np.linalg.norm(self._positions[seen] - eye, axis=1), kind="stable")
        return np.sort(seen[nearest[:MAX_LIGHTS]])

    def _write(self, seen: NDArray[np.int64]) -> None:
        data = np.zeros((3, MAX_LIGHTS, 4), np.float32)
        for slot, i in enumerate(seen):
            row = int(self._rows[i])
            moving = 0.5 if self._cubes and row >= 0 and self._cubes.moving[row] else 0.0
            data[0, slot] = [*self._positions[i], self._radii[i]]
            data[1, slot] = [*self._scene.points[i].intensity, row + moving]
            data[2, slot] = spot(self._scene.points[i])
        self._block.write(data.tobytes())
