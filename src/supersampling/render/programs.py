"""GLSL programs from the files of `shaders/`, compiled once per set of definitions."""

from importlib.resources import files

import moderngl
import numpy as np

from supersampling.render.gpu_scene import GpuScene

_VERSION = "#version 430\n"


def source(names: tuple[str, ...], definitions: tuple[str, ...]) -> str:
    """Return the concatenation of the named files after one ``#define`` per definition."""
    folder = files("supersampling.render") / "shaders"
    lines = [f"#define {d}\n" for d in definitions]
    return _VERSION + "".join(lines) + "\n".join((folder / f"{name}.glsl").read_text() for name in names)


class Programs:
    """Programs compiled on first use.

    ``mesh`` returns a vertex array over the scene, ``screen`` one over a full-screen triangle.
    """

    def __init__(self, ctx: moderngl.Context, gpu: GpuScene) -> None:
        self._ctx = ctx
        self._gpu = gpu
        self._arrays: dict[tuple[tuple[str, ...], tuple[str, ...]], moderngl.VertexArray] = {}

    def mesh(self, name: str, definitions: tuple[str, ...]) -> moderngl.VertexArray:
        key = ((name,), definitions)
        if key not in self._arrays:
            program = self._ctx.program(
                vertex_shader=source((f"{name}_vertex",), definitions),
                fragment_shader=source((f"{name}_fragment",), definitions),
            )
            self._arrays[key] = self._gpu.vertex_array(program)
        return self._arrays[key]

    def screen(self, names: tuple[str, ...], definitions: tuple[str, ...] = ()) -> moderngl.VertexArray:
        """Return a full-screen pass whose fragment shader is the concatenation of ``names``."""
        key = (names, definitions)
        if key not in self._arrays:
            program = self._ctx.program(
                vertex_shader=source(("fullscreen_vertex",), ()), fragment_shader=source(names, definitions)
            )
            self._arrays[key] = self._ctx.vertex_array(program, [])
        return self._arrays[key]


def assign(program: moderngl.Program, **values: object) -> None:
    """Set the uniforms that the program has; the compiler drops unused ones."""
    for name, value in values.items():
        member = program.get(name, None)
        if isinstance(member, moderngl.Uniform):
            member.value = value


def matrix(value: object) -> tuple[float, ...]:
    """Return a row-major matrix as OpenGL's column-major tuple."""
    return tuple(float(v) for v in np.asarray(value).T.ravel())
