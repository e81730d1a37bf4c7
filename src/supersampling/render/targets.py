"""Framebuffers of a frame, made on first use and kept while their size is in use."""

from collections import OrderedDict

import moderngl
import numpy as np
from numpy.typing import NDArray

from supersampling.render.programs import assign

KEPT = 6  # framebuffers; a frame needs two, and a tiled target's edges up to four


class GBuffer:
    """Depth, material when shaded, motion when asked, and the lit image; row 0 is the top row."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int], shade: bool, motion: bool) -> None:
        self.size, self.shade, self.motion = size, shade, motion
        textures: dict[str, moderngl.Texture] = {"depth": ctx.texture(size, 1, dtype="f4")}
        if shade:
            textures |= {name: ctx.texture(size, 4, dtype="f2") for name in ("albedo", "normal", "emission")}
        if motion:
            textures["motion"] = ctx.texture(size, 2, dtype="f4")
        for texture in textures.values():
            texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._textures = textures
        self._depth = ctx.depth_renderbuffer(size)
        self._buffer = ctx.framebuffer(list(textures.values()), self._depth)
        if shade:
            self.shaded = ctx.texture(size, 4, dtype="f4")
            self._lit = ctx.framebuffer([self.shaded])

    def begin(self) -> None:
        """Clears to sky: depth 1."""
        self._buffer.use()
        self._buffer.clear(1.0, 1.0, 1.0, 1.0, depth=1.0)

    def bind_for_shading(self, program: moderngl.Program) -> None:
        self._lit.use()
        for unit, name in enumerate(("depth", "albedo", "normal", "emission")):
            self._textures[name].use(unit)
            assign(program, **{f"{name}_map": unit})

    def read(self, name: str) -> NDArray[np.float32]:
        """``(h, w, C)`` of one attachment."""
        index, channels = list(self._textures).index(name), self._textures[name].components
        data = self._buffer.read(components=channels, attachment=index, dtype="f4")
        return np.frombuffer(data, np.float32).reshape(self.size[1], self.size[0], channels)

    def read_shaded(self) -> NDArray[np.float32]:
        """``(h, w, 3)`` display-referred colour."""
        data = self._lit.read(components=3, dtype="f4")
        return np.frombuffer(data, np.float32).reshape(self.size[1], self.size[0], 3)

    def release(self) -> None:
        self._buffer.release()
        self._depth.release()
        for texture in self._textures.values():
            texture.release()
        if self.shade:
            self._lit.release()
            self.shaded.release()


class Targets:
    """Least recently used framebuffers are let go."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._kept: OrderedDict[tuple[tuple[int, int], bool, bool], GBuffer] = OrderedDict()
        self._resolved: OrderedDict[tuple[int, int], moderngl.Framebuffer] = OrderedDict()

    def gbuffer(self, size: tuple[int, int], shade: bool, motion: bool) -> GBuffer:
        key = (size, shade, motion)
        if key not in self._kept:
            self._kept[key] = GBuffer(self._ctx, *key)
        self._kept.move_to_end(key)
        while len(self._kept) > KEPT:
            self._kept.popitem(last=False)[1].release()
        return self._kept[key]

    def resolved(self, size: tuple[int, int]) -> moderngl.Framebuffer:
        """Where a target of ``size`` is averaged."""
        if size not in self._resolved:
            self._resolved[size] = self._ctx.framebuffer([self._ctx.renderbuffer(size, 4, dtype="f4")])
        self._resolved.move_to_end(size)
        while len(self._resolved) > KEPT:
            old = self._resolved.popitem(last=False)[1]
            old.color_attachments[0].release()
            old.release()
        return self._resolved[size]
