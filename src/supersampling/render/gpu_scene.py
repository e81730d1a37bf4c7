"""Geometry of a scene on the GPU, cut into chunks small enough to cull, and its materials.

A DRAW is a chunk of a mesh under an object's transform. A GROUP is the draws of the same material and winding, which
one indirect call renders, since textures are bound per material. Moving objects change their group whenever a transform
begins or ends to mirror.
"""

from dataclasses import dataclass

import moderngl
import numpy as np
from numpy.typing import NDArray

from supersampling.render.camera import Matrix
from supersampling.render.frustum import Boxes, transformed
from supersampling.render.gpu_materials import GpuMaterials
from supersampling.scenes.scene import Material, Mesh, Object, Scene

CHUNK_TRIANGLES = 2048
VERTEX_LAYOUT = ("3f 3f 2f 4f 4f1", "in_position", "in_normal", "in_uv", "in_tangent", "in_color")
MODEL_LAYOUT = ("4f 4f 4f/i", "in_model_0", "in_model_1", "in_model_2")
CLIP_LAYOUT = ("16f 4f 4f 4f/i", "in_current", "in_previous_x", "in_previous_y", "in_previous_w")
OBJECT_LAYOUT = ("1f/i", "in_object")


@dataclass(frozen=True)
class DrawGroup:
    """Draws of one material and winding."""

    material: int
    mirrored: bool


def split(mesh: Mesh) -> list[NDArray[np.uint32]]:
    """Return a mesh's triangles in spatial chunks of at most `CHUNK_TRIANGLES`, by halving along the longest axis."""
    centres = mesh.positions[mesh.triangles].mean(axis=1)
    waiting, done = [np.arange(len(mesh.triangles))], []
    while waiting:
        part = waiting.pop()
        if len(part) <= CHUNK_TRIANGLES:
            done.append(mesh.triangles[part].astype(np.uint32))
            continue
        spread = centres[part].max(axis=0) - centres[part].min(axis=0)
        order = part[np.argsort(centres[part, int(spread.argmax())], kind="stable")]
        waiting += [order[: len(order) // 2], order[len(order) // 2 :]]
    return done


def tangents(mesh: Mesh) -> NDArray[np.float32]:
    """Return vertex tangents ``(N, 4)``: the direction of increasing u and the sign of the bitangent.

    ``sign * cross(normal, tangent)`` is the up direction of the normal map.

    v runs down the image and the map's y runs up, so the bitangent is the direction of decreasing v.
    """
    tri = mesh.triangles
    p, uv = mesh.positions[tri].astype(np.float64), mesh.uv[tri].astype(np.float64)
    e1, e2 = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    d1, d2 = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    det = d1[:, 0] * d2[:, 1] - d2[:, 0] * d1[:, 1]
    # Not divided by the determinant, which keeps the area weight: only directions are needed.
    sign = np.sign(det)[:, None]
    along_u = sign * (e1 * d2[:, 1:] - e2 * d1[:, 1:])
    up = -sign * (e2 * d1[:, :1] - e1 * d2[:, :1])
    total_u, total_up = (_at_vertices(tri, values, len(mesh.positions)) for values in (along_u, up))
    handed = np.where((np.cross(mesh.normals, total_u) * total_up).sum(axis=1) < 0.0, -1.0, 1.0)
    length = np.linalg.norm(total_u, axis=1, keepdims=True)
    # Zero, and so no normal mapping, without uv or where mirrored halves cancel.
    unit = total_u / np.maximum(length, 1e-20)
    return np.concatenate([unit, handed[:, None]], axis=1).astype(np.float32)


def _at_vertices(triangles: NDArray[np.uint32], values: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Return ``(count, 3)``: for each vertex the sum of its triangles' ``values (M, 3)``."""
    corners = triangles.T.ravel().astype(np.intp)
    # np.add.at gives the same sums, several times slower.
    return np.stack([np.bincount(corners, np.tile(v, 3), count) for v in values.T], axis=1)


def in_world(item: Object, seconds: float, view: Matrix) -> Matrix:
    """Return the float64 object-to-world matrix ``(4, 4)`` at an instant; the camera's ``view`` is world-to-camera."""
    matrix = np.asarray(item.at(seconds), np.float64)
    if item.frame == "world":
        return matrix
    to_world = np.linalg.inv(view)
    if item.frame == "camera":
        return to_world @ matrix
    matrix = matrix.copy()
    matrix[:3, :3] = to_world[:3, :3] @ matrix[:3, :3]
    return matrix


class GpuScene:
    """Buffers of a scene and its table of draws.

    ``commands (D, 5)`` are OpenGL's indirect draw records, ``draw_groups (D,)`` indexes ``groups`` (groups of the
    interface come last), ``moving (D,)`` and ``casts (D,)`` tell which draws belong to moving objects and which cast
    shadows. `place` sets the transforms of one instant and with them ``draw_groups``.
    """

    def __init__(self, ctx: moderngl.Context, scene: Scene) -> None:
        self.scene = scene
        self.ctx = ctx
        chunks = self._upload_meshes()
        self._list_draws(chunks)
        self.materials = GpuMaterials(ctx, scene.materials)
        count = len(scene.objects)
        self.model_buffer = ctx.buffer(reserve=max(count, 1) * 48, dynamic=True)
        self.clip_buffer = ctx.buffer(reserve=max(count, 1) * 112, dynamic=True)
        self.object_buffer = ctx.buffer(np.arange(1, max(count, 1) + 1, dtype=np.float32).tobytes())
        self.indirect = ctx.buffer(reserve=max(len(self.commands), 1) * 20, dynamic=True)
        self.bounds = self._static_bounds()

    def _upload_meshes(self) -> list[list[tuple[int, int, NDArray[np.float64], NDArray[np.float64]]]]:
        """Upload all meshes and return the chunks ``(first index, index count, lo, hi)`` of each."""
        record = [("p", "3f4"), ("n", "3f4"), ("uv", "2f4"), ("t", "4f4"), ("c", "4u1")]
        vertices: list[NDArray[np.void]] = []
        indices: list[NDArray[np.uint32]] = []
        chunks: list[list[tuple[int, int, NDArray[np.float64], NDArray[np.float64]]]] = []
        first_vertex = first_index = 0
        for mesh in self.scene.meshes:
            data = np.zeros(len(mesh.positions), dtype=record)
            data["p"], data["n"] = mesh.positions, mesh.normals
            data["uv"], data["t"] = mesh.uv, tangents(mesh) if mesh.tangents is None else mesh.tangents
            data["c"] = 255  # white and opaque
            if mesh.colors is not None:
                rounded = np.rint(np.clip(np.asarray(mesh.colors, np.float64), 0.0, 1.0) * 255.0)
                data["c"][:, : mesh.colors.shape[1]] = rounded
            chunks.append([])
            for part in split(mesh):
                corners = mesh.positions[part.ravel()].astype(np.float64)
                chunks[-1].append((first_index, part.size, corners.min(axis=0), corners.max(axis=0)))
                indices.append(part.ravel() + np.uint32(first_vertex))
                first_index += part.size
            vertices.append(data)
            first_vertex += len(data)
        empty = np.zeros(1, np.uint32)
        self.vertex_buffer = self.ctx.buffer(np.concatenate(vertices or [np.zeros(1, record)]).tobytes())
        self.index_buffer = self.ctx.buffer(np.concatenate(indices or [empty]).astype(np.uint32).tobytes())
        return chunks

    def _list_draws(self, chunks: list[list[tuple[int, int, NDArray[np.float64], NDArray[np.float64]]]]) -> None:
        scene = self.scene
        self.models = (
            np.stack([o.at(0.0) for o in scene.objects]).astype(np.float64) if scene.objects else np.zeros((0, 4, 4))
        )
        self.previous_models = self.models.copy()
        self.movers = [i for i, o in enumerate(scene.objects) if o.moves]
        rows = []
        for i, item in enumerate(scene.objects):
            for m in item.meshes:
                material = scene.meshes[m].material
                key = (scene.materials[material].interface, material)
                rows += [(key, first, count, i, lo, hi) for first, count, lo, hi in chunks[m]]
        rows.sort(key=lambda row: row[0])
        keys = sorted({row[0] for row in rows})
        self.groups = [DrawGroup(material, mirrored) for _, material in keys for mirrored in (False, True)]
        index = {key: 2 * n for n, key in enumerate(keys)}
        self._plain_groups = np.array([index[row[0]] for row in rows], dtype=np.int64)
        self.draw_objects = np.array([row[3] for row in rows], dtype=np.int64)
        self._group_draws()
        # Records of glMultiDrawElementsIndirect; the base instance picks the object's transforms.
        self.commands = np.array([(row[2], 1, row[1], 0, row[3]) for row in rows], dtype=np.uint32).reshape(-1, 5)
        self._lo = np.array([row[4] for row in rows], dtype=np.float64).reshape(-1, 3)
        self._hi = np.array([row[5] for row in rows], dtype=np.float64).reshape(-1, 3)
        self.moving = np.isin(self.draw_objects, self.movers)
        self.casts = np.array([not row[0][0] for row in rows], dtype=bool)
        self.boxes: Boxes = transformed(self._lo, self._hi, self.models[self.draw_objects])

    def _group_draws(self) -> None:
        """Set the group of each draw by the winding of its object's present transform."""
        mirrored = np.linalg.det(self.models[:, :3, :3]) < 0.0
        self.draw_groups = self._plain_groups + mirrored[self.draw_objects]

    def in_order(self, selected: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Return the indices of the draws ``selected (D,)``, sorted by group."""
        draws = np.flatnonzero(selected)
        return draws[np.argsort(self.draw_groups[draws], kind="stable")]

    def _static_bounds(self) -> Boxes:
        """Return the ``(1, 3)`` box of all static geometry, or of all geometry if none is static."""
        selected = self.casts & ~self.moving if (self.casts & ~self.moving).any() else self.casts
        if not selected.any():
            return np.zeros((1, 3)), np.ones((1, 3))
        return self.boxes[0][selected].min(axis=0, keepdims=True), self.boxes[1][selected].max(axis=0, keepdims=True)

    def material(self, group: DrawGroup) -> Material:
        return self.scene.materials[group.material]

    def place(
        self, seconds: tuple[float, float], views: tuple[Matrix, Matrix], projections: tuple[Matrix, Matrix]
    ) -> None:
        """Set the transforms of the current and the previous instant; ``projections`` are unjittered."""
        for i in self.movers:
            item = self.scene.objects[i]
            self.models[i] = in_world(item, seconds[0], views[0])
            self.previous_models[i] = in_world(item, seconds[1], views[1])
        if self.movers:
            moved = self.moving
            lo, hi = transformed(self._lo[moved], self._hi[moved], self.models[self.draw_objects[moved]])
            self.boxes[0][moved], self.boxes[1][moved] = lo, hi
            self._group_draws()
        if len(self.models) == 0:
            return
        # Multiply in float64: large offsets of the world cancel here instead of in the shader's float32.
        now, before = (projection @ view for projection, view in zip(projections, views))
        current = (now @ self.models).transpose(0, 2, 1).reshape(-1, 16)  # columns of the matrix
        previous = (before @ self.previous_models)[:, [0, 1, 3]].reshape(-1, 12)  # rows
        self.clip_buffer.write(np.concatenate([current, previous], axis=1).astype(np.float32).tobytes())
        self.model_buffer.write(np.ascontiguousarray(self.models[:, :3], dtype=np.float32).tobytes())

    def vertex_array(self, program: moderngl.Program) -> moderngl.VertexArray:
        """Return the vertex array of a program, without attributes that the program does not read."""
        sources = (
            (self.vertex_buffer, VERTEX_LAYOUT),
            (self.model_buffer, MODEL_LAYOUT),
            (self.clip_buffer, CLIP_LAYOUT),
            (self.object_buffer, OBJECT_LAYOUT),
        )
        content = [(buffer, layout) for buffer, layout in sources if any(name in program for name in layout[1:])]
        return self.ctx.vertex_array(
            program, [(buffer, *layout) for buffer, layout in content], self.index_buffer, skip_errors=True
        )

    def write_commands(self, draws: NDArray[np.int64]) -> None:
        """Fill the indirect buffer with the selected draws, in order."""
        if len(draws):
            self.indirect.write(np.ascontiguousarray(self.commands[draws]).tobytes())
