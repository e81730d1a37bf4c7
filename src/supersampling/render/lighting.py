"""The lights of a scene as the lighting pass wants them."""

import moderngl
import numpy as np
from numpy.typing import NDArray

from supersampling.render.camera import Matrix
from supersampling.render.frustum import visible
from supersampling.render.gpu_scene import GpuScene
from supersampling.render.programs import Programs, assign
from supersampling.render.shadows import CUBE_NORMAL_OFFSET, Casters, PointShadows, SunShadows

MAX_LIGHTS = 64  # in view at once; the nearest are kept


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
        self._block = ctx.buffer(reserve=MAX_LIGHTS * 32, dynamic=True)
        offset = f"CUBE_OFFSET {CUBE_NORMAL_OFFSET}"
        self._definitions = (f"MAX_LIGHTS {MAX_LIGHTS}", offset, *(("SUN",) if scene.sun else ()))

    def prepare(self, programs: Programs, eye: NDArray[np.float64], planes: Matrix) -> moderngl.VertexArray:
        """Updates the shadow maps that the view needs; returns the lighting pass with its light uniforms set."""
        array = programs.screen(("brdf", "display", "shadow_lookup", "lighting_fragment"), self._definitions)
        sky, program = self._scene.sky, array.program
        if self._sun and self._scene.sun:
            self._sun.update(eye)
            self._sun.bind(program, self._scene.sun)
        seen = self._visible(eye, planes)
        if self._cubes:
            self._cubes.update([int(r) for r in self._rows[seen] if r >= 0])
            self._cubes.bind(program)
        self._write(seen)
        self._block.bind_to_uniform_block(1)
        assign(program, light_count=len(seen), sky_zenith=(*sky.zenith, sky.ambient))
        assign(program, sky_horizon=sky.horizon, sky_ground=sky.ground)
        return array

    def _visible(self, eye: NDArray[np.float64], planes: Matrix) -> NDArray[np.int64]:
        """Indices of the point lights whose sphere the view may see."""
        reach = self._radii[:, None]
        seen = np.flatnonzero(visible((self._positions - reach, self._positions + reach), planes))
        nearest = np.argsort(np.linalg.norm(self._positions[seen] - eye, axis=1), kind="stable")
        return np.sort(seen[nearest[:MAX_LIGHTS]])

    def _write(self, seen: NDArray[np.int64]) -> None:
        data = np.zeros((2, MAX_LIGHTS, 4), np.float32)
        for slot, i in enumerate(seen):
            row = int(self._rows[i])
            moving = 0.5 if self._cubes and row >= 0 and self._cubes.moving[row] else 0.0
            data[0, slot] = [*self._positions[i], self._radii[i]]
            data[1, slot] = [*self._scene.points[i].intensity, row + moving]
        self._block.write(data.tobytes())
