"""GLSL programs from the files of `shaders/`, compiled once per set of definitions."""

from importlib.resources import files

import moderngl
import numpy as np

from supersampling.render.gpu_scene import GpuScene

_VERSION = "#version 430\n"


def source(names: tuple[str, ...], definitions: tuple[str, ...]) -> str:
    """The named files one after another, behind ``#define``s."""
    folder = files("supersampling.render") / "shaders"
    lines = [f"#define {d}\n" for d in definitions]
    return _VERSION + "".join(lines) + "\n".join((folder / f"{name}.glsl").read_text() for name in names)


class Programs:
    """Compiles on first use. ``mesh`` gives a vertex array over the scene, ``screen`` one over a full-screen triangle."""

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
        """The fragment shader is made of ``names`` in order."""
        key = (names, definitions)
        if key not in self._arrays:
            program = self._ctx.program(
                vertex_shader=source(("fullscreen_vertex",), ()), fragment_shader=source(names, definitions)
            )
            self._arrays[key] = self._ctx.vertex_array(program, [])
        return self._arrays[key]


def assign(program: moderngl.Program, **values: object) -> None:
    """Sets the uniforms that the program has; a compiler drops those that it does not need."""
    for name, value in values.items():
        member = program.get(name, None)
        if isinstance(member, moderngl.Uniform):
            member.value = value


def matrix(value: object) -> tuple[float, ...]:
    """A row-major numpy matrix as GL's column-major tuple."""
    return tuple(float(v) for v in np.asarray(value).T.ravel())
