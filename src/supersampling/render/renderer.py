"""Deferred OpenGL renderer: one-sample low-resolution frames with their buffers, and supersampled targets.

A G-buffer pass writes linear depth, motion and the material; a full-screen pass lights it. The same code runs on a GPU
and on Mesa's software rasteriser; the two differ in low bits, so a data set records `Renderer.gl_renderer`.
"""

import math
from types import TracebackType

import moderngl
import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError
from supersampling.render import matrices
from supersampling.render.camera import Matrix, Shot, Window
from supersampling.render.frustum import planes_of, visible
from supersampling.render.gpu_scene import GpuScene
from supersampling.render.lighting import Lights
from supersampling.render.programs import Programs, assign, matrix
from supersampling.render.scene import Scene
from supersampling.render.shadows import Casters
from supersampling.render.targets import GBuffer, Targets

TONEMAP = "aces_narkowicz"
BUFFERS = frozenset({"color", "depth", "motion"})
TILE = 2048  # pixels of a side that are shaded at once

Image = NDArray[np.float32]


def open_context() -> moderngl.Context:
    """An OpenGL 4.3 context without a screen, or a `UserError` that says what to install."""
    try:
        # The stub types each setting as a dictionary of settings.
        return moderngl.create_context(standalone=True, backend="egl", require=430)  # type: ignore[arg-type]
    except Exception as error:  # moderngl raises bare Exceptions, and OSError for a missing library
        reason = str(error).strip().rstrip(".") or type(error).__name__
        raise UserError(
            f"No OpenGL 4.3 context without a screen could be opened ({reason}): "
            "run `apt-get install libegl1 libgl1-mesa-dri`."
        ) from None


class Renderer:
    """Draws a scene. A context manager; ``gl_renderer`` is the GL_RENDERER and GL_VERSION string.

    Raises `UserError` where no OpenGL context can be opened.
    """

    def __init__(self, scene: Scene, shadow_size: int = 4096) -> None:
        self._ctx = open_context()
        self._ctx.gc_mode = "context_gc"
        self.gl_renderer = f"{self._ctx.info['GL_RENDERER']}, OpenGL {self._ctx.info['GL_VERSION']}"
        self.scene = scene
        self._gpu = GpuScene(self._ctx, scene)
        self._programs = Programs(self._ctx, self._gpu)
        self._targets = Targets(self._ctx)
        casters = Casters(self._ctx, self._gpu, self._programs)
        self._alpha = casters.alpha
        self._lights = Lights(self._ctx, self._gpu, casters, shadow_size)

    def low(
        self, shot: Shot, scale: int, jitter: tuple[float, float], mip_bias: float, buffers: frozenset[str]
    ) -> dict[str, Image]:
        """One sample a pixel of the window at 1 / ``scale``, at the pixel's centre + ``jitter`` (x right, y down, in pixels).

        ``buffers`` are of ``color (h, w, 3)``, ``depth (h, w, 1)`` and ``motion (h, w, 2)``; see `frames.BUFFERS` for their
        units. ``mip_bias`` is relative to the level that the low resolution would choose.
        """
        unknown = sorted(buffers - BUFFERS)
        if unknown:
            raise UserError(f"The renderer has no buffer {unknown[0]!r}: ask for some of {sorted(BUFFERS)}.")
        window = shot.window
        if window.width % scale or window.height % scale:
            raise UserError(
                f"A window of {window.width}x{window.height} pixels cannot be rendered at 1/{scale}: "
                f"make both sides multiples of {scale}."
            )
        size = (window.width // scale, window.height // scale)
        g = self._targets.gbuffer(size, shade="color" in buffers, motion="motion" in buffers)
        lens = self._aim(shot, window)
        self._draw(g, shot, lens, matrices.jitter_offset(jitter, *size), mip_bias)
        out: dict[str, Image] = {}
        if "color" in buffers:
            self._shade(g, shot, lens, matrices.jitter_offset(jitter, *size))
            out["color"] = g.read_shaded()
        if "depth" in buffers:
            out["depth"] = g.read("depth")
        if "motion" in buffers:
            out["motion"] = g.read("motion")
        return out

    def target(self, shot: Shot, samples: int, mip_bias: float) -> Image:
        """``(H, W, 3)``: a regular grid of ``samples`` x ``samples`` in each target pixel, averaged as displayed.

        ``mip_bias`` is relative to the level that the target's resolution would choose.
        """
        window = shot.window
        out = np.empty((window.height, window.width, 3), dtype=np.float32)
        side = max(TILE // samples, 1)
        for y in range(0, window.height, side):
            for x in range(0, window.width, side):
                width, height = min(side, window.width - x), min(side, window.height - y)
                tile = Window(
                    window.frame_width, window.frame_height, window.x + x, window.y + y, width, height
                )
                g = self._targets.gbuffer((width * samples, height * samples), shade=True, motion=False)
                lens = self._aim(shot, tile)
                # Derivatives are `samples` times smaller here than in the target.
                self._draw(g, shot, lens, (0.0, 0.0), mip_bias + math.log2(samples))
                self._shade(g, shot, lens, (0.0, 0.0))
                out[y : y + height, x : x + width] = self._resolve(g, samples)
        return out

    def _aim(self, shot: Shot, window: Window) -> tuple[Matrix, Matrix]:
        """Current and previous projection of a window; the scene's transforms are brought to the shot."""
        near, far = self.scene.near, self.scene.far
        now = matrices.window_projection(shot.camera, window, near, far)
        before = matrices.window_projection(shot.previous_camera, window, near, far)
        self._gpu.place(
            shot.seconds, shot.previous_seconds, now @ shot.camera.view, before @ shot.previous_camera.view
        )
        return now, before

    def _draw(
        self,
        g: GBuffer,
        shot: Shot,
        lens: tuple[Matrix, Matrix],
        jitter: tuple[float, float],
        mip_bias: float,
    ) -> None:
        """Sky, then all draws that the window may see, into the G-buffer."""
        gpu, ctx = self._gpu, self._ctx
        g.begin()
        if g.motion:
            sky = self._programs.screen(("sky_motion_fragment",), ("SHADE",) if g.shade else ())
            warp = matrices.sky_homography(shot.camera.view, lens[0], shot.previous_camera.view, lens[1])
            assign(sky.program, homography=matrix(warp), size=g.size, jitter=jitter)
            ctx.enable_only(moderngl.NOTHING)
            sky.render(moderngl.TRIANGLES, vertices=3)
        ctx.enable_only(moderngl.DEPTH_TEST)
        planes = planes_of(lens[0] @ shot.camera.view)
        # Jitter moves the image by up to half a pixel, so the volume is that much wider.
        planes[:4] += (lens[0] @ shot.camera.view)[3] / min(g.size)
        draws = np.flatnonzero(visible(gpu.boxes, planes))
        gpu.write_commands(draws)
        span = 1.0 / (self.scene.far - self.scene.near)
        ready: set[int] = set()
        groups, starts, counts = np.unique(gpu.group_of[draws], return_index=True, return_counts=True)
        for group, start, count in zip(groups, starts, counts):
            array = self._programs.mesh("gbuffer", self._definitions(int(group), g))
            if id(array) not in ready:
                assign(array.program, jitter=jitter, mip_bias=mip_bias, depth_range=(self.scene.near, span))
                assign(array.program, albedo_map=0, normal_map=1, surface_map=2)
                ready.add(id(array))
            self._bind_group(int(group))
            array.render_indirect(gpu.indirect, moderngl.TRIANGLES, int(count), int(start))

    def _definitions(self, group: int, g: GBuffer) -> tuple[str, ...]:
        material = self._gpu.groups[group].material
        chosen = {
            "ALPHA_TEST": bool(self._alpha[group]),
            "SHADE": g.shade,
            "NORMAL_MAP": g.shade and self._gpu.normal[material] is not None,
            "SURFACE_MAP": g.shade and self._gpu.surface[material] is not None,
            "MOTION": g.motion,
        }
        return tuple(name for name, on in chosen.items() if on)

    def _bind_group(self, index: int) -> None:
        gpu, ctx = self._gpu, self._ctx
        group = gpu.groups[index]
        gpu.bind_material(group.material)
        maps = (gpu.albedo[group.material], gpu.normal[group.material], gpu.surface[group.material])
        for unit, chosen in enumerate(maps):
            if chosen is not None:
                chosen.use(unit)
        # The image is drawn y down, which turns the winding; a mirroring transform turns it again.
        ctx.front_face = "ccw" if group.mirrored else "cw"
        if gpu.material(group).double_sided:
            ctx.disable(moderngl.CULL_FACE)
        else:
            ctx.enable(moderngl.CULL_FACE)

    def _shade(
        self, g: GBuffer, shot: Shot, lens: tuple[Matrix, Matrix], jitter: tuple[float, float]
    ) -> None:
        """Lights the G-buffer into its display-referred image."""
        eye = matrices.eye_of(shot.camera.view)
        array = self._lights.prepare(self._programs, eye, planes_of(lens[0] @ shot.camera.view))
        self._ctx.enable_only(moderngl.NOTHING)
        g.bind_for_shading(array.program)
        assign(
            array.program, rays=matrix(matrices.ray_basis(shot.camera.view, lens[0])), eye=tuple(eye), size=g.size,
            jitter=jitter, depth_range=(self.scene.near, self.scene.far - self.scene.near), exposure=self.scene.exposure,
        )  # fmt: skip
        array.render(moderngl.TRIANGLES, vertices=3)

    def _resolve(self, g: GBuffer, samples: int) -> Image:
        array = self._programs.screen(("resolve_fragment",))
        g.shaded.use(0)
        assign(array.program, image=0, samples=samples)
        size = (g.size[0] // samples, g.size[1] // samples)
        buffer = self._targets.resolved(size)
        buffer.use()
        array.render(moderngl.TRIANGLES, vertices=3)
        return np.frombuffer(buffer.read(components=3, dtype="f4"), np.float32).reshape(size[1], size[0], 3)

    def close(self) -> None:
        """Releases the context and all that it holds."""
        self._ctx.release()

    def __enter__(self) -> "Renderer":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
