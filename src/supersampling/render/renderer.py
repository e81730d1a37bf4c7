"""Deferred OpenGL renderer: one-sample low-resolution frames with their buffers, and supersampled targets.

A G-buffer pass writes linear depth, motion and the material; full-screen passes light it or extract single buffers, and
only what the requested buffers need is drawn. The same code runs on a GPU and on Mesa's software rasteriser; the two
differ in low bits, so a data set records `Renderer.gl_renderer`.
"""

import math
from collections.abc import Iterator
from types import TracebackType

import numpy as np
import torch
from numpy.typing import NDArray

from supersampling.errors import UserError
from supersampling.frames import BUFFERS
from supersampling.ops.dual_motion import dual_motion
from supersampling.render import matrices
from supersampling.render.camera import Shot, Window
from supersampling.render.context import open_context
from supersampling.render.passes import EXTRACTED, Passes, View
from supersampling.render.targets import Contents
from supersampling.scenes.scene import Scene

TONEMAP = "aces_narkowicz"
TILE = 2048  # side in pixels of the area that is shaded at once

Image = NDArray[np.float32]

_LIT = frozenset({"color", "radiance"})
_REFERENCE = {"target": "color", "target_radiance": "radiance"}
# High-resolution buffers that are not averaged: one sample at the pixel's centre.
_CENTRED = frozenset({"high_depth", "high_motion", "high_normal", "high_object_id"})


def _planes(image: NDArray[np.floating]) -> torch.Tensor:
    """Convert ``(h, w, C)`` to ``(1, C, h, w)`` float32."""
    return torch.from_numpy(np.ascontiguousarray(image, np.float32)).permute(2, 0, 1)[None]


class Renderer:
    """Renderer of one scene, a context manager. ``gl_renderer`` is the GL_RENDERER and GL_VERSION string.

    Raises:
        UserError: No OpenGL context can be opened.
    """

    def __init__(self, scene: Scene, shadow_size: int = 4096) -> None:
        self._ctx = open_context()
        self._ctx.gc_mode = "context_gc"
        self.gl_renderer = f"{self._ctx.info['GL_RENDERER']}, OpenGL {self._ctx.info['GL_VERSION']}"
        self.scene = scene
        self._passes = Passes(self._ctx, scene, shadow_size)

    def _view(self, shot: Shot, window: Window, size: tuple[int, int], jitter: tuple[float, float]) -> View:
        offset = matrices.jitter_offset(jitter, *size)
        return View(shot, window, size, offset, (self.scene.near, self.scene.far))

    def low(
        self, shot: Shot, scale: int, jitter: tuple[float, float], mip_bias: float, buffers: frozenset[str]
    ) -> dict[str, Image]:
        """Render low-resolution ``buffers`` of `frames.BUFFERS`, each ``(h, w, C)``.

        The window is rendered at 1 / ``scale`` with one sample per pixel, at the pixel's centre + ``jitter`` (x right,
        y down, in pixels). ``mip_bias`` is relative to the mip level of the low resolution.
        """
        window = shot.window
        if window.width % scale or window.height % scale:
            raise UserError(
                f"Invalid window of {window.width}x{window.height} pixels at scale 1/{scale}: "
                f"make both sides multiples of {scale}."
            )
        size = (window.width // scale, window.height // scale)
        view = self._view(shot, window, size, jitter)
        lit, extracted = buffers & _LIT, buffers & EXTRACTED.keys()
        dual = "motion_dual" in buffers
        contents = Contents(bool(lit or extracted), dual or "motion" in buffers, "object_id" in buffers)
        g = self._passes.surface(view, mip_bias, contents)
        out: dict[str, Image] = {}
        if lit:
            self._passes.light(g, view, radiance="radiance" in lit)
            out |= {name: g.read_image(name, 3) for name in lit}
        for name in extracted:
            self._passes.extract(g, view, name)
            out[name] = g.read_image("extracted", BUFFERS[name].channels)
        for name, attachment in {"depth": "depth", "object_id": "object"}.items():
            if name in buffers:
                out[name] = g.read(attachment)
        if contents.motion:
            motion = g.read("motion")
            out |= {"motion": motion[..., :2]} if "motion" in buffers else {}
            out |= {"motion_dual": self._dual(shot, scale, jitter, mip_bias, motion)} if dual else {}
        return out

    def preview(self, shot: Shot, scale: int) -> dict[str, Image]:
        """Render colour and motion with coarse shadows, which makes a new camera position cheap."""
        view = self._view(shot, shot.window, (shot.window.width // scale, shot.window.height // scale), (0.0, 0.0))
        g = self._passes.surface(view, -math.log2(scale), Contents(surface=True, motion=True))
        self._passes.light(g, view, radiance=False, coarse=True)
        return {"color": g.read_image("color", 3), "motion": g.read("motion")[..., :2]}

    def target(self, shot: Shot, samples: int, mip_bias: float) -> Image:
        """Render the supersampled reference ``(H, W, 3)``: see `high`."""
        return self.high(shot, samples, mip_bias, frozenset({"target"}))["target"]

    def high(self, shot: Shot, samples: int, mip_bias: float, buffers: frozenset[str]) -> dict[str, Image]:
        """Render high-resolution ``buffers`` of `frames.BUFFERS`, each ``(H, W, C)``.

        Each target pixel is the average over a regular grid of ``samples`` x ``samples`` (``target``: of displayed
        values); depth, motion, normal and object id are one sample at the centre. ``mip_bias`` is relative to the mip
        level of the target's resolution.
        """
        window = shot.window
        centred = buffers & _CENTRED
        out: dict[str, Image] = {}
        if centred:
            low = self.low(shot, 1, (0.0, 0.0), mip_bias, frozenset(n.removeprefix("high_") for n in centred))
            out = {f"high_{name}": image for name, image in low.items()}
        averaged = sorted(buffers - centred)
        if not averaged:
            return out
        for name in averaged:
            out[name] = np.empty((window.height, window.width, BUFFERS[name].channels), dtype=np.float32)
        side = max(TILE // samples, 1)
        for y in range(0, window.height, side):
            for x in range(0, window.width, side):
                width, height = min(side, window.width - x), min(side, window.height - y)
                tile = Window(window.frame_width, window.frame_height, window.x + x, window.y + y, width, height)
                for name, image in self._averaged(shot, tile, samples, mip_bias, averaged):
                    out[name][y : y + height, x : x + width] = image
        return out

    def _averaged(
        self, shot: Shot, tile: Window, samples: int, mip_bias: float, names: list[str]
    ) -> Iterator[tuple[str, Image]]:
        view = self._view(shot, tile, (tile.width * samples, tile.height * samples), (0.0, 0.0))
        # Derivatives are `samples` times smaller here than in the target.
        g = self._passes.surface(view, mip_bias + math.log2(samples), Contents(surface=True))
        if _REFERENCE.keys() & set(names):
            self._passes.light(g, view, radiance="target_radiance" in names)
        for name in names:
            if name not in _REFERENCE:
                self._passes.extract(g, view, name.removeprefix("high_"))
            mean = self._passes.average(g, _REFERENCE.get(name, "extracted"), samples)
            yield name, mean[..., : BUFFERS[name].channels]

    def _dual(self, shot: Shot, scale: int, jitter: tuple[float, float], mip_bias: float, motion: Image) -> Image:
        """Return dual motion vectors: the previous frame is drawn with its motion to this frame.

        Its alpha-tested surfaces need the frame's own mip bias: coarser levels dissolve leaves that the frame shows.
        """
        window = shot.window
        margin = scale * (max(window.width, window.height) // (4 * scale))
        wide = window.grown(margin)
        back = Shot(shot.previous_camera, shot.camera, shot.previous_seconds, shot.seconds, wide)
        view = self._view(back, wide, (wide.width // scale, wide.height // scale), (0.0, 0.0))
        g = self._passes.surface(view, mip_bias, Contents(motion=True))
        depth = g.read("depth")
        near, far = self.scene.near, self.scene.far
        seen = np.where(depth < 1.0, near + (far - near) * depth, np.float32(np.inf))
        pixels = np.array((window.width, window.height), np.float32) / scale
        forward = g.read("motion")[..., :2] * np.array(view.size, np.float32)
        dual = dual_motion(
            _planes(motion[..., :2] * pixels),
            _planes(motion[..., 2:3]),
            torch.tensor([jitter]),
            _planes(forward),
            _planes(seen),
            margin // scale,
        )
        return (dual[0].permute(1, 2, 0).numpy() / pixels).astype(np.float32)

    def close(self) -> None:
        """Release the context and all its resources."""
        self._ctx.release()

    def __enter__(self) -> "Renderer":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
