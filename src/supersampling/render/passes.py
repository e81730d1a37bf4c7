"""Passes of a frame: the G-buffer, its lighting, extraction of single buffers, and the average over samples."""

from dataclasses import dataclass
from functools import cached_property

import moderngl
import numpy as np
from numpy.typing import NDArray

from supersampling.render import matrices
from supersampling.render.camera import Matrix, Shot, Window
from supersampling.render.environment import Environment
from supersampling.render.frustum import clip_planes, visible
from supersampling.render.gpu_scene import GpuScene
from supersampling.render.lighting import Lights
from supersampling.render.programs import Programs, assign, matrix
from supersampling.render.shadows import Casters
from supersampling.render.targets import Contents, Framebuffers, GBuffer
from supersampling.scenes.scene import Scene

PREVIEW_SHADOWS = 256  # texels per side of the sun's map for previews

# Buffers that a pass over the G-buffer extracts, as expressions of extract_fragment.glsl.
EXTRACTED = {
    "normal": "solid * (image_axes * s.normal)",
    "albedo": "solid * albedo.rgb",
    "metallic": "vec3(solid * s.metallic)",
    "roughness": "vec3(solid * s.roughness)",
    "specular": "solid * s.f0",
    "n_dot_v": "vec3(solid * s.n_dot_v)",
    "material": "lit * (s.diffuse + specular_integral(s))",
    "emission": "unlit",
}


@dataclass(frozen=True, eq=False)
class View:
    """Window of a shot at ``size`` pixels, sampled ``jitter`` (clip space, right and down) off the pixels' centres."""

    shot: Shot
    window: Window
    size: tuple[int, int]
    jitter: tuple[float, float]
    depth: tuple[float, float]  # near and far plane, metres

    @cached_property
    def projection(self) -> Matrix:
        return matrices.window_projection(self.shot.camera, self.window, *self.depth)

    @cached_property
    def previous_projection(self) -> Matrix:
        return matrices.window_projection(self.shot.previous_camera, self.window, *self.depth)

    @cached_property
    def clip(self) -> Matrix:
        """World-to-clip matrix, unjittered."""
        return self.projection @ self.shot.camera.view


class Passes:
    """Passes of one scene in one OpenGL context."""

    def __init__(self, ctx: moderngl.Context, scene: Scene, shadow_size: int) -> None:
        self._ctx, self._scene = ctx, scene
        self._gpu = GpuScene(ctx, scene)
        self._programs = Programs(ctx, self._gpu)
        self._targets = Framebuffers(ctx)
        self._environment = Environment(ctx, scene.sky)
        self._casters = Casters(ctx, self._gpu, self._programs)
        self._lights = Lights(ctx, self._gpu, self._casters, shadow_size)
        self._coarse: Lights | None = None

    def surface(self, view: View, mip_bias: float, contents: Contents) -> GBuffer:
        """Draw the G-buffer: the sky, all draws that the view may see, and the interface on top."""
        gpu, ctx = self._gpu, self._ctx
        shot = view.shot
        seconds = (shot.seconds, shot.previous_seconds)
        views = (shot.camera.view, shot.previous_camera.view)
        gpu.place(seconds, views, (view.projection, view.previous_projection))
        g = self._targets.gbuffer(view.size, contents)
        g.begin()
        self._background(g, view)
        ctx.enable_only(moderngl.DEPTH_TEST)
        planes = clip_planes(view.clip)
        # Jitter moves the image by up to half a pixel, so widen the volume by as much.
        planes[:4] += view.clip[3] / min(view.size)
        draws = gpu.in_order(visible(gpu.boxes, planes))
        gpu.write_commands(draws)
        groups, starts, counts = np.unique(gpu.draw_groups[draws], return_index=True, return_counts=True)
        behind = True
        for group, start, count in zip(groups, starts, counts):
            if behind and gpu.material(gpu.groups[group]).interface:
                if not contents.surface:
                    break
                g.write_emission_only()
                behind = False
            array = self._mesh_program(int(group), view, contents, mip_bias)
            array.render_indirect(gpu.indirect, moderngl.TRIANGLES, int(count), int(start))
        return g

    def _background(self, g: GBuffer, view: View) -> None:
        array = self._programs.screen(("background_fragment",), g.contents.definitions)
        before = view.shot.previous_camera.view
        warp = matrices.sky_homography(view.shot.camera.view, view.projection, before, view.previous_projection)
        assign(array.program, homography=matrix(warp), size=view.size, jitter=view.jitter)
        self._ctx.enable_only(moderngl.NOTHING)
        array.render(moderngl.TRIANGLES, vertices=3)

    def _mesh_program(self, index: int, view: View, contents: Contents, mip_bias: float) -> moderngl.VertexArray:
        """Return the program of a group of draws, with its material bound."""
        gpu, ctx = self._gpu, self._ctx
        group = gpu.groups[index]
        material = gpu.material(group)
        maps = gpu.materials.maps(group.material)
        switches = {
            "ALPHA_TEST": material.alpha != "opaque",
            "NORMAL_MAP": contents.surface and maps[1] is not None,
            "SURFACE_MAP": contents.surface and maps[2] is not None,
            "GLOW_MAP": contents.surface and maps[3] is not None,
        }
        material_definitions = tuple(name for name, on in switches.items() if on)
        array = self._programs.mesh("gbuffer", (*material_definitions, *contents.definitions))
        near, far = view.depth
        assign(array.program, jitter=view.jitter, mip_bias=mip_bias, depth_range=(near, 1.0 / (far - near)))
        assign(array.program, albedo_map=0, normal_map=1, surface_map=2, glow_map=3)
        gpu.materials.bind(group.material)
        for unit, texture in enumerate(maps):
            if texture is not None:
                texture.use(unit)
        # The image is drawn with y down, which reverses the winding; a mirroring transform reverses it again.
        ctx.front_face = "ccw" if group.mirrored else "cw"
        if material.double_sided:
            ctx.disable(moderngl.CULL_FACE)
        else:
            ctx.enable(moderngl.CULL_FACE)
        return array

    def light(self, g: GBuffer, view: View, *, radiance: bool, coarse: bool = False) -> None:
        """Draw the lit image ``color``, display-referred, and optionally ``radiance``. ``coarse`` shadows are quick."""
        lights = self._coarse_lights() if coarse else self._lights
        eye = matrices.eye_position(view.shot.camera.view)
        array = lights.prepare(self._programs, eye, clip_planes(view.clip), radiance)
        near, far = view.depth
        assign(array.program, eye=tuple(eye), depth_range=(near, far - near))
        g.draw_to(*(("color", "radiance") if radiance else ("color",)))
        self._screen(array, g, view)

    def _coarse_lights(self) -> Lights:
        if self._coarse is None:
            self._coarse = Lights(self._ctx, self._gpu, self._casters, PREVIEW_SHADOWS)
        return self._coarse

    def extract(self, g: GBuffer, view: View, name: str) -> None:
        """Draw one buffer of `EXTRACTED` as the image ``extracted``."""
        array = self._programs.screen(("brdf", "surface", "sky", "extract_fragment"), (f"EXTRACT ({EXTRACTED[name]})",))
        axes = np.diag([1.0, -1.0, 1.0]) @ view.shot.camera.view[:3, :3]
        assign(array.program, image_axes=matrix(axes))
        g.draw_to("extracted")
        self._screen(array, g, view)

    def _screen(self, array: moderngl.VertexArray, g: GBuffer, view: View) -> None:
        """Draw a full-screen pass over the surface."""
        self._ctx.enable_only(moderngl.NOTHING)
        g.bind(array.program)
        self._environment.bind(array.program)
        rays = matrices.ray_basis(view.shot.camera.view, view.projection)
        exposure = self._scene.exposure
        assign(array.program, rays=matrix(rays), size=view.size, jitter=view.jitter, exposure=exposure)
        array.render(moderngl.TRIANGLES, vertices=3)

    def average(self, g: GBuffer, image: str, samples: int) -> NDArray[np.float32]:
        """Return an image of ``g`` under a box filter: ``(h / samples, w / samples, 3)``."""
        array = self._programs.screen(("resolve_fragment",))
        g.image(image).use(0)
        assign(array.program, image=0, samples=samples)
        width, height = g.size[0] // samples, g.size[1] // samples
        buffer = self._targets.resolved((width, height))
        self._ctx.enable_only(moderngl.NOTHING)
        buffer.use()
        array.render(moderngl.TRIANGLES, vertices=3)
        return np.frombuffer(buffer.read(components=3, dtype="f4"), np.float32).reshape(height, width, 3)
