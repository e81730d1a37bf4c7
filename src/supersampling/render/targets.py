"""Framebuffers of a frame, created on first use and cached while their size is in use."""

from collections import OrderedDict
from dataclasses import dataclass

import moderngl
import numpy as np
from numpy.typing import NDArray

from supersampling.render.programs import assign

CACHED = 6  # framebuffers; a frame needs two, and the edges of a tiled target up to four

# Components and type of each attachment, in order.
_FORMATS = {
    "depth": (1, "f4"),
    "albedo": (4, "f2"),
    "normal": (4, "f2"),
    "emission": (4, "f2"),
    "motion": (4, "f4"),
    "object": (1, "f4"),
}
SURFACE = ("depth", "albedo", "normal", "emission")


@dataclass(frozen=True)
class Contents:
    """Contents of a G-buffer: the surface (for lighting or its material), motion, object ids."""

    surface: bool = False
    motion: bool = False
    objects: bool = False

    @property
    def attachments(self) -> tuple[str, ...]:
        return (
            *(SURFACE if self.surface else SURFACE[:1]),
            *(("motion",) if self.motion else ()),
            *(("object",) if self.objects else ()),
        )

    @property
    def definitions(self) -> tuple[str, ...]:
        """Definitions for the shaders: the written contents, and their attachments."""
        switches = {"SHADE": self.surface, "MOTION": self.motion, "OBJECT": self.objects}
        locations = (f"AT_{name.upper()} {k}" for k, name in enumerate(self.attachments))
        return (*(name for name, on in switches.items() if on), *locations)


class GBuffer:
    """Depth and the other contents; row 0 is the top row. Images that passes draw from it are created on first use."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int], contents: Contents) -> None:
        self.size, self.contents = size, contents
        self._ctx = ctx
        self._textures = {
            name: ctx.texture(size, *_FORMATS[name][:1], dtype=_FORMATS[name][1]) for name in contents.attachments
        }
        for texture in self._textures.values():
            texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._depth = ctx.depth_renderbuffer(size)
        self._buffer = ctx.framebuffer(list(self._textures.values()), self._depth)
        self._images: dict[str, moderngl.Texture] = {}
        self._passes: dict[tuple[str, ...], moderngl.Framebuffer] = {}

    def begin(self) -> None:
        """Clear, and draw what follows into every attachment."""
        if self.contents.surface:  # otherwise nothing was masked
            self._mask([True] * len(self._textures))
        self._buffer.depth_mask = True
        self._buffer.use()
        self._buffer.clear(depth=1.0)

    def write_emission_only(self) -> None:
        """Draw what follows into the emission only: depth, motion and object ids stay those of the surfaces behind."""
        self._mask([name == "emission" for name in self._textures])
        self._buffer.depth_mask = False
        self._buffer.use()

    def _mask(self, written: list[bool]) -> None:
        # moderngl takes one tuple per attachment, but its stub does not.
        self._buffer.color_mask = [(on,) * 4 for on in written]  # type: ignore[assignment]

    def bind(self, program: moderngl.Program) -> None:
        """Bind the surface as textures of a full-screen pass."""
        for unit, name in enumerate(SURFACE):
            self._textures[name].use(unit)
            assign(program, **{f"{name}_map": unit})

    def draw_to(self, *names: str) -> None:
        """Draw the next full-screen pass into these images."""
        if names not in self._passes:
            for name in names:
                if name not in self._images:
                    self._images[name] = self._ctx.texture(self.size, 4, dtype="f4")
                    self._images[name].filter = (moderngl.NEAREST, moderngl.NEAREST)
            self._passes[names] = self._ctx.framebuffer([self._images[name] for name in names])
        self._passes[names].use()

    def image(self, name: str) -> moderngl.Texture:
        return self._images[name]

    def read_image(self, name: str, channels: int) -> NDArray[np.float32]:
        """Read ``(h, w, channels)`` from an image."""
        data = np.frombuffer(self._images[name].read(), np.float32)
        return data.reshape(self.size[1], self.size[0], 4)[..., :channels]

    def read(self, name: str) -> NDArray[np.float32]:
        """Read ``(h, w, C)`` from one attachment."""
        index, channels = list(self._textures).index(name), self._textures[name].components
        data = self._buffer.read(components=channels, attachment=index, dtype="f4")
        return np.frombuffer(data, np.float32).reshape(self.size[1], self.size[0], channels)

    def release(self) -> None:
        for buffer in (self._buffer, *self._passes.values()):
            buffer.release()
        for texture in (*self._textures.values(), *self._images.values()):
            texture.release()
        self._depth.release()


class Framebuffers:
    """Cache of framebuffers that releases the least recently used."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._gbuffers: OrderedDict[tuple[tuple[int, int], Contents], GBuffer] = OrderedDict()
        self._resolved: OrderedDict[tuple[int, int], moderngl.Framebuffer] = OrderedDict()

    def gbuffer(self, size: tuple[int, int], contents: Contents) -> GBuffer:
        key = (size, contents)
        if key not in self._gbuffers:
            self._gbuffers[key] = GBuffer(self._ctx, *key)
        self._gbuffers.move_to_end(key)
        while len(self._gbuffers) > CACHED:
            self._gbuffers.popitem(last=False)[1].release()
        return self._gbuffers[key]

    def resolved(self, size: tuple[int, int]) -> moderngl.Framebuffer:
        """Return the framebuffer in which a target of ``size`` is averaged."""
        if size not in self._resolved:
            self._resolved[size] = self._ctx.framebuffer([self._ctx.renderbuffer(size, 4, dtype="f4")])
        self._resolved.move_to_end(size)
        while len(self._resolved) > CACHED:
            old = self._resolved.popitem(last=False)[1]
            old.color_attachments[0].release()
            old.release()
        return self._resolved[size]
