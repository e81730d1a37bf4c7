"""Conversion of glTF's meshes to the scene's: triangles and attributes of primitives (specification, section 3.7.2)."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError
from supersampling.scenes.gltf.accessors import Accessors
from supersampling.scenes.gltf.document import Document
from supersampling.scenes.gltf.materials import MaterialReader
from supersampling.scenes.gltf.notes import Notes
from supersampling.scenes.gltf.skins import deform
from supersampling.scenes.scene import Mesh

Floats = NDArray[np.float32]
Indices = NDArray[np.int64]
_TRIANGLES, _STRIP, _FAN = 4, 5, 6


def triangulate(mode: int, corners: Indices) -> Indices:
    """Return triangles ``(M, 3)`` of vertex indices ``(N,)``, wound as in section 3.7.2.1.

    Degenerate triangles of strips and fans are left out.
    """
    if mode == _TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    i = np.arange(max(len(corners) - 2, 0))
    if mode == _STRIP:
        order = np.stack([i, i + 1 + i % 2, i + 2 - i % 2], axis=1)
    else:
        order = np.stack([i + 1, i + 2, np.zeros_like(i)], axis=1)
    triangles = corners[order]
    a, b, c = triangles.T
    return triangles[(a != b) & (b != c) & (c != a)]


@dataclass(frozen=True, eq=False)
class _Vertices:
    """Rows of the vertices that a primitive uses, and its triangles in terms of these rows."""

    rows: slice | Indices
    triangles: Indices


class MeshReader:
    """Reader that converts each mesh once; ``meshes`` are the scene's. Joints are matrices of a skin's rest pose."""

    def __init__(self, document: Document, accessors: Accessors, materials: MaterialReader, notes: Notes) -> None:
        self.meshes: list[Mesh] = []
        self.plain = cache(self._plain)
        self._document, self._accessors, self._materials, self._notes = document, accessors, materials, notes

    def _plain(self, index: int) -> tuple[int, ...]:
        """Return indices in ``meshes`` for the file's mesh, one per primitive."""
        return self._read(index, None)

    def skinned(self, index: int, joints: NDArray[np.float64]) -> tuple[int, ...]:
        """Return the same as `plain` for a mesh under the joint matrices ``(J, 4, 4)`` of a skin, in world space."""
        return self._read(index, joints)

    def _read(self, index: int, joints: NDArray[np.float64] | None) -> tuple[int, ...]:
        indices = []
        for number, primitive in enumerate(self._document.item("meshes", index).primitives):
            mesh = self._primitive(primitive, f"primitive {number} of mesh {index}", joints)
            if mesh is not None:
                indices.append(len(self.meshes))
                self.meshes.append(mesh)
        return tuple(indices)

    def _primitive(self, primitive: Any, what: str, joints: NDArray[np.float64] | None) -> Mesh | None:
        mode = _TRIANGLES if primitive.mode is None else primitive.mode
        attributes = vars(primitive.attributes)
        if mode not in (_TRIANGLES, _STRIP, _FAN):
            self._notes.add("points and lines are left out")
            return None
        if attributes.get("POSITION") is None:
            self._notes.add("primitives without positions are left out")
            return None
        if primitive.targets:
            self._notes.add("morph targets stay at rest")
        positions = self._accessors.floats(attributes["POSITION"], 3)
        vertices = self._vertices(primitive, mode, len(positions), what)
        if not len(vertices.triangles):
            return None
        source = f"{what} of {self._document.name}"
        reader = _AttributeReader(self._accessors, attributes, vertices.rows, len(positions), source)
        positions = positions[vertices.rows]
        if not np.isfinite(positions).all():
            raise UserError(f"Some positions of {what} of {self._document.name} are not finite: export it again.")
        normals = reader.normals()
        if joints is not None:
            positions, normals = deform(positions, normals, reader.skin(), joints)
        material, coordinates = self._materials.number(primitive.material)
        uv = coordinates.apply(reader.uv(coordinates.number))
        if not coordinates.repeats and len(uv) and (uv.min() < -0.01 or uv.max() > 1.01):
            self._notes.add("textures that should not repeat do so beyond their edges")
        return _mesh(positions, normals, uv, reader.colors(), vertices.triangles, material)

    def _vertices(self, primitive: Any, mode: int, count: int, what: str) -> _Vertices:
        if primitive.indices is None:
            return _Vertices(slice(None), triangulate(mode, np.arange(count)))
        corners = self._accessors.integers(primitive.indices)[:, 0]
        if int(corners.max()) >= count:
            raise UserError(
                f"The indices of {what} of {self._document.name} reach vertex {int(corners.max())} of {count}: "
                "the file is broken, export it again."
            )
        # Primitives may share one large vertex buffer: keep only the vertices that this one uses.
        first, last = int(corners.min()), int(corners.max())
        used = np.zeros(last + 1 - first, bool)
        used[corners - first] = True
        if used.all():
            return _Vertices(slice(first, last + 1), triangulate(mode, corners - first))
        renumbered = np.cumsum(used) - 1
        return _Vertices(first + np.flatnonzero(used), triangulate(mode, renumbered[corners - first]))


class _AttributeReader:
    """Reader of a primitive's attributes at the vertices that it uses."""

    def __init__(
        self, accessors: Accessors, attributes: dict[str, Any], rows: slice | Indices, count: int, what: str
    ) -> None:
        self._accessors, self._attributes, self._rows, self._what = accessors, attributes, rows, what
        self._count, self._used = count, len(np.arange(count)[rows])

    def _floats(self, name: str, *widths: int) -> Floats | None:
        index = self._attributes.get(name)
        if index is None:
            return None
        return self._select(name, self._accessors.floats(index, *widths))

    def _select(self, name: str, values: NDArray[Any]) -> NDArray[Any]:
        if len(values) != self._count:
            raise UserError(
                f"{name} of {self._what} has {len(values)} elements for {self._count} vertices: export it again."
            )
        return values[self._rows]

    def normals(self) -> Floats | None:
        normals = self._floats("NORMAL", 3)
        return None if normals is None else unit(np.nan_to_num(normals, posinf=0.0, neginf=0.0))

    def uv(self, number: int) -> Floats:
        uv = self._floats(f"TEXCOORD_{number}", 2)
        return np.zeros((self._used, 2), np.float32) if uv is None else np.nan_to_num(uv, posinf=0.0, neginf=0.0)

    def colors(self) -> Floats | None:
        colors = self._floats("COLOR_0", 3, 4)
        return None if colors is None else np.clip(np.nan_to_num(colors[:, :3]), 0.0, 1.0)

    def skin(self) -> tuple[Indices, Floats] | None:
        """Return the joints ``(N, 4)`` and weights ``(N, 4)`` of the first four influences."""
        weights = self._floats("WEIGHTS_0", 4)
        if weights is None or self._attributes.get("JOINTS_0") is None:
            return None
        joints = self._accessors.integers(self._attributes["JOINTS_0"], 4)
        return self._select("JOINTS_0", joints), weights


def unit(vectors: Floats) -> Floats:
    """Return unit vectors; a vector without length becomes up."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    up = np.array((0.0, 1.0, 0.0), np.float32)
    return np.where(length > 1e-12, vectors / np.maximum(length, 1e-12), up).astype(np.float32)


def _mesh(
    positions: Floats, normals: Floats | None, uv: Floats, colors: Floats | None, triangles: Indices, material: int
) -> Mesh:
    if normals is None:
        # Section 3.7.2.1: flat normals, so that no two triangles share a vertex.
        order = triangles.ravel()
        positions, uv = positions[order], uv[order]
        colors = None if colors is None else colors[order]
        a, b, c = positions[0::3], positions[1::3], positions[2::3]
        cross = np.cross((b - a).astype(np.float64), (c - a).astype(np.float64)).astype(np.float32)
        normals = np.repeat(unit(cross), 3, axis=0)
        triangles = np.arange(len(order)).reshape(-1, 3)
    contiguous = np.ascontiguousarray
    return Mesh(
        contiguous(positions, np.float32),
        contiguous(normals, np.float32),
        contiguous(uv, np.float32),
        contiguous(triangles, np.uint32),
        material,
        None if colors is None else contiguous(colors, np.float32),
    )
