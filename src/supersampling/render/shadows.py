"""Shadow maps whose texels are fixed in the world, so that shadows do not crawl when the camera moves.

The sun has two maps: a near region around the camera, which moves in steps of whole texels and is rendered again only
after a step, and a far region over the whole scene, which is rendered once. The blend between them depends on the
distance from the eye, not on the steps. A point light has a row of six tiles, one per cube face. Maps of static
geometry are cached; moving objects have separate maps, drawn for each frame.
"""

from dataclasses import dataclass

import moderngl
import numpy as np
from numpy.typing import NDArray

from supersampling.render.camera import Matrix
from supersampling.render.frustum import clip_planes, touches_sphere, visible
from supersampling.render.gpu_scene import GpuScene
from supersampling.render.programs import Programs, assign, matrix
from supersampling.scenes.scene import PointLight, Sun

NEAR_REACH = 40.0  # metres from the eye within which only the near map is used
NEAR_FADE = 8.0
NEAR_STEP = 8.0
CUBE_FACE = 512
MOVING_CUBE_FACE = 256
CUBE_NEAR = 0.05
CUBE_TILE = 0.98  # half extent of a face on its tile, whose half extent is 1
CUBE_NORMAL_OFFSET = 1.5 * 2.0 / (CUBE_TILE * MOVING_CUBE_FACE)  # metres per metre from the light
_DEPTH_CLAMP = 0x864F
_TO_TEXTURE = np.array([[0.5, 0, 0, 0.5], [0, 0.5, 0, 0.5], [0, 0, 0.5, 0.5], [0, 0, 0, 1.0]])


def depth_map(ctx: moderngl.Context, width: int, height: int) -> tuple[moderngl.Texture, moderngl.Framebuffer]:
    """Create a depth texture that compares and filters, cleared to far."""
    texture = ctx.depth_texture((width, height))
    texture.compare_func = "<="
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
    texture.repeat_x = texture.repeat_y = False
    buffer = ctx.framebuffer(depth_attachment=texture)
    buffer.clear(depth=1.0)
    return texture, buffer


class Casters:
    """Shadow casters: drawn into depth maps with both faces, alpha-tested if the material is."""

    def __init__(self, ctx: moderngl.Context, gpu: GpuScene, programs: Programs) -> None:
        self._ctx = ctx
        self._gpu = gpu
        self._opaque = programs.mesh("shadow", ())
        self._tested = programs.mesh("shadow", ("ALPHA_TEST",))
        self.alpha = np.array([gpu.material(g).alpha != "opaque" for g in gpu.groups], dtype=bool)

    def draw(self, target: moderngl.Framebuffer, light: Matrix, selected: NDArray[np.bool_]) -> None:
        """Draw the draws ``selected (D,)`` into the target's current viewport."""
        gpu, ctx = self._gpu, self._ctx
        draws = gpu.in_order(selected)
        if len(draws) == 0:
            return
        target.use()
        ctx.enable_only(moderngl.DEPTH_TEST)
        ctx.enable_direct(_DEPTH_CLAMP)  # keep casters between the sun and the near plane
        ctx.polygon_offset = 1.5, 4.0
        tested = self.alpha[gpu.draw_groups[draws]]
        draws = np.concatenate([draws[~tested], draws[tested]])
        gpu.write_commands(draws)
        solid = int((~tested).sum())
        if solid:
            assign(self._opaque.program, light=matrix(light))
            self._opaque.render_indirect(gpu.indirect, moderngl.TRIANGLES, solid, 0)
        assign(self._tested.program, light=matrix(light), albedo_map=0)
        groups, starts, counts = np.unique(gpu.draw_groups[draws[solid:]], return_index=True, return_counts=True)
        for group, start, count in zip(groups, starts, counts):
            material = gpu.groups[group].material
            gpu.materials.albedo[material].use(0)
            gpu.materials.bind(material)
            self._tested.render_indirect(gpu.indirect, moderngl.TRIANGLES, int(count), solid + int(start))
        ctx.polygon_offset = 0.0, 0.0
        ctx.disable_direct(_DEPTH_CLAMP)


@dataclass
class Region:
    """Square of the sun's view: ``centre (2,)`` in light space and half the side, in metres."""

    centre: NDArray[np.float64]
    half: float


class SunShadows:
    """Three maps of the sun, on texture units 4 (near), 5 (far) and 6 (moving)."""

    def __init__(self, ctx: moderngl.Context, gpu: GpuScene, casters: Casters, sun: Sun, size: int) -> None:
        self._gpu, self._casters = gpu, casters
        self.direction = np.asarray(sun.direction, np.float64) / np.linalg.norm(sun.direction)
        aside = np.cross([0.0, 1.0, 0.0] if abs(self.direction[1]) < 0.99 else [1.0, 0.0, 0.0], self.direction)
        aside /= np.linalg.norm(aside)
        self._axes = np.stack([aside, np.cross(self.direction, aside), self.direction])  # world to light
        lo, hi = gpu.bounds
        corners = np.array([[(lo, hi)[(k >> a) & 1][0, a] for a in range(3)] for k in range(8)]) @ self._axes.T
        self._low, self._high = corners.min(axis=0), corners.max(axis=0)
        half = float((self._high - self._low)[:2].max()) / 2.0 * 1.01 + 0.1
        self._far = Region((self._high + self._low)[:2] / 2.0, half)
        self._small = half <= NEAR_REACH + NEAR_FADE + NEAR_STEP
        self._size = size
        self._near_map, self._near_buffer = depth_map(ctx, size, size)
        self._far_map, self._far_buffer = (
            (self._near_map, self._near_buffer) if self._small else depth_map(ctx, size, size)
        )
        self._moving_map, self._moving_buffer = depth_map(ctx, max(size // 2, 1), max(size // 2, 1))
        self._near = Region(np.full(2, np.inf), 0.0)  # never an eye's region: the first update renders the map
        self._far_ready = False
        self._moving = self._moving_stale = False

    def _matrix(self, region: Region) -> Matrix:
        """Return the matrix from the world to the region's clip space; depth spans the static scene."""
        out = np.eye(4)
        out[:2, :3] = self._axes[:2] / region.half
        out[:2, 3] = -region.centre / region.half
        span = max(self._high[2] - self._low[2], 1.0)  # a flat scene has no depth under a sun at the zenith
        out[2, :3] = -2.0 * self._axes[2] / span
        out[2, 3] = (self._high[2] + self._low[2]) / span
        return out

    def _region(self, eye: NDArray[np.float64]) -> Region:
        if self._small:
            return self._far
        half = NEAR_REACH + NEAR_FADE + NEAR_STEP
        texel = 2.0 * half / self._size
        step = max(round(NEAR_STEP / texel), 1) * texel
        return Region(np.round((self._axes @ eye)[:2] / step) * step, half)

    def _render(self, buffer: moderngl.Framebuffer, region: Region, selected: NDArray[np.bool_]) -> bool:
        light = self._matrix(region)
        sides = clip_planes(light)[:4]  # depth is clamped, not clipped
        inside = selected & visible(self._gpu.boxes, sides)
        self._casters.draw(buffer, light, inside)
        return bool(inside.any())

    def update(self, eye: NDArray[np.float64]) -> None:
        """Update the maps for this eye and the current transforms of moving objects."""
        region = self._region(eye)
        if not np.array_equal(region.centre, self._near.centre):
            self._near = region
            self._near_buffer.clear(depth=1.0)
            self._render(self._near_buffer, region, self._gpu.casts & ~self._gpu.moving)
        if not self._far_ready and not self._small:
            self._render(self._far_buffer, self._far, self._gpu.casts & ~self._gpu.moving)
        self._far_ready = True
        if self._moving_stale:
            self._moving_buffer.clear(depth=1.0)
        self._moving = self._moving_stale = self._render(
            self._moving_buffer, region, self._gpu.casts & self._gpu.moving
        )

    def bind(self, program: moderngl.Program, sun: Sun) -> None:
        for unit, texture in enumerate((self._near_map, self._far_map, self._moving_map), start=4):
            texture.use(unit)
        fade = (1e9, 0.0) if self._small else (NEAR_REACH, 1.0 / NEAR_FADE)
        assign(
            program,
            sun_near=4,
            sun_far=5,
            sun_moving=6,
            sun_near_matrix=matrix(_TO_TEXTURE @ self._matrix(self._near)),
            sun_far_matrix=matrix(_TO_TEXTURE @ self._matrix(self._far)),
            sun_texel=(2.0 * self._near.half / self._size, 2.0 * self._far.half / self._size),
            sun_blend=(*fade, float(self._moving)),
            sun_direction=tuple(self.direction),
            sun_radiance=sun.radiance,
        )


def face_axes() -> NDArray[np.float64]:
    """Return ``(6, 3, 3)``: the rows right, up and forward of the faces +x, -x, +y, -y, +z, -z."""
    faces = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            forward = np.zeros(3)
            forward[axis] = sign
            right = np.roll(np.abs(forward), 1)
            faces.append(np.stack([right, np.cross(forward, right), forward]))
    return np.stack(faces)


class PointShadows:
    """Cube maps of the shadowed point lights as rows of tiles, on texture units 7 (static) and 8 (moving)."""

    def __init__(self, ctx: moderngl.Context, gpu: GpuScene, casters: Casters, lights: list[PointLight]) -> None:
        self._gpu, self._casters, self._lights = gpu, casters, lights
        rows = max(len(lights), 1)
        self._map, self._buffer = depth_map(ctx, 6 * CUBE_FACE, rows * CUBE_FACE)
        self._moving_map, self._moving_buffer = depth_map(ctx, 6 * MOVING_CUBE_FACE, rows * MOVING_CUBE_FACE)
        self._faces = face_axes()
        self._ready = np.zeros(len(lights), dtype=bool)
        self._stale = np.zeros(len(lights), dtype=bool)
        self.moving = np.zeros(len(lights), dtype=bool)

    def _render(self, row: int, buffer: moderngl.Framebuffer, face_size: int, selected: NDArray[np.bool_]) -> bool:
        light = self._lights[row]
        position = np.asarray(light.position, np.float64)
        near = selected & touches_sphere(self._gpu.boxes, position, light.radius)
        if not near.any():
            return False
        for face, axes in enumerate(self._faces):
            world = np.eye(4)
            world[:3, :3], world[:3, 3] = axes, -axes @ position
            project = np.diag([CUBE_TILE, CUBE_TILE, 0.0, 0.0])
            span = light.radius - CUBE_NEAR
            project[2, 2] = (light.radius + CUBE_NEAR) / span
            project[2, 3] = -2.0 * light.radius * CUBE_NEAR / span
            project[3, 2] = 1.0
            buffer.viewport = (face * face_size, row * face_size, face_size, face_size)
            self._casters.draw(buffer, project @ world, near & visible(self._gpu.boxes, clip_planes(project @ world)))
        return True

    def update(self, rows: list[int]) -> None:
        """Update the tiles of the lights ``rows``."""
        for row in rows:
            if not self._ready[row]:
                self._render(row, self._buffer, CUBE_FACE, self._gpu.casts & ~self._gpu.moving)
                self._ready[row] = True
            size = MOVING_CUBE_FACE
            if self._stale[row]:
                self._moving_buffer.clear(depth=1.0, viewport=(0, row * size, 6 * size, size))
            self.moving[row] = self._stale[row] = self._render(
                row, self._moving_buffer, size, self._gpu.casts & self._gpu.moving
            )

    def bind(self, program: moderngl.Program) -> None:
        self._map.use(7)
        self._moving_map.use(8)
        faces = [matrix(axes) for axes in self._faces]
        assign(program, cubes=7, moving_cubes=8, cube_faces=faces, cube_tile=(CUBE_TILE, CUBE_NEAR))
