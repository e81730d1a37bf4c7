"""Conversion of glTF's meshes to the scene's: triangles and attributes of primitives (specification, section 3.7.2)."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError
from supersampling.scenes.gltf.accessors import Accessors
from supersampling.scenes.gltf.attributes import AttributeReader, finite, unit
from supersampling.scenes.gltf.document import Document
from supersampling.scenes.gltf.features import Deviation
from supersampling.scenes.gltf.materials import MaterialReader
from supersampling.scenes.gltf.notes import Notes
from supersampling.scenes.gltf.skins import Geometry, deform
from supersampling.scenes.scene import Mesh

Floats = NDArray[np.float32]
Indices = NDArray[np.int64]
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_DRACO = "KHR_draco_mesh_compression"
Weights = tuple[float, ...]


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
    """Reader that converts each mesh once per set of morph targets' weights; ``meshes`` are the scene's.

    Joints are matrices of a skin's rest pose.
    """

    def __init__(self, document: Document, accessors: Accessors, materials: MaterialReader, notes: Notes) -> None:
        self.meshes: list[Mesh] = []
        self.plain = cache(self._plain)
        self._document, self._accessors, self._materials, self._notes = document, accessors, materials, notes

    def _plain(self, index: int, weights: Weights | None) -> tuple[int, ...]:
        """Return indices in ``meshes`` for the file's mesh, one per primitive; a node's weights replace the mesh's."""
        return self.skinned(index, weights, None)

    def skinned(self, index: int, weights: Weights | None, joints: NDArray[np.float64] | None) -> tuple[int, ...]:
        """Return the same as `plain` for a mesh under the joint matrices ``(J, 4, 4)`` of a skin, in world space."""
        indices = []
        source = self._document.item("meshes", index)
        weights = tuple(float(w) for w in source.weights or ()) if weights is None else weights
        for number, primitive in enumerate(source.primitives):
            mesh = self._primitive(primitive, f"primitive {number} of mesh {index}", weights, joints)
            if mesh is not None:
                indices.append(len(self.meshes))
                self.meshes.append(mesh)
        return tuple(indices)

    def _primitive(
        self, primitive: Any, what: str, weights: Weights, joints: NDArray[np.float64] | None
    ) -> Mesh | None:
        mode = _TRIANGLES if primitive.mode is None else primitive.mode
        source = f"{what} of {self._document.name}"
        if mode not in range(_FAN + 1):
            raise UserError(f"The {source} has the unknown mode {mode}: use 4 for triangles.")
        attributes = vars(primitive.attributes)
        if mode < _TRIANGLES or attributes.get("POSITION") is None:
            self._notes.add(Deviation.TOPOLOGY if mode < _TRIANGLES else Deviation.POSITIONS)
            return None
        self._check_compression(primitive, source)
        count = len(self._accessors.floats(attributes["POSITION"], 3))
        vertices = self._vertices(primitive, mode, count, what)
        if not len(vertices.triangles):
            return None
        targets = [(w, target) for w, target in zip(weights, primitive.targets or ()) if w != 0.0]
        reader = AttributeReader(
            self._accessors, self._notes, attributes=attributes, targets=targets, rows=vertices.rows, what=source
        )
        material, coordinates, sampler = self._materials.number(primitive.material)
        # A transform can be too large for float32.
        uv = finite(sampler.apply(coordinates.apply(reader.uv(coordinates))), self._notes)
        shape = Geometry(reader.positions(), reader.normals(), reader.tangents(), vertices.triangles)
        if joints is not None:
            shape = deform(shape, reader.skin(), joints)
        opaque = self._materials.materials[material].alpha == "opaque"
        return _mesh(shape, uv, reader.colors(opaque), material)

    def _check_compression(self, primitive: Any, source: str) -> None:
        """Raise `UserError` if a mesh is only stored compressed by Draco: its accessors would read as zeros."""
        positions = self._document.item("accessors", primitive.attributes.POSITION)
        if _DRACO in (primitive.extensions or {}) and positions.bufferView is None:
            raise UserError(f"The {source} is stored only with {_DRACO}: export it without compression.")

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


def _mesh(shape: Geometry, uv: Floats, colors: Floats | None, material: int) -> Mesh:
    positions, normals, tangents, triangles = shape
    if normals is None:
        # Section 3.7.2.1: flat normals, so that no two triangles share a vertex, and tangents of the file are ignored.
        order = triangles.ravel()
        positions, uv, tangents = positions[order], uv[order], None
        colors = None if colors is None else colors[order]
        a, b, c = positions[0::3], positions[1::3], positions[2::3]
        cross = np.cross((b - a).astype(np.float64), (c - a).astype(np.float64)).astype(np.float32)
        normals = np.repeat(unit(cross), 3, axis=0)
        triangles = np.arange(len(order)).reshape(-1, 3)

    def stored(values: Floats | None) -> Floats | None:
        return None if values is None else np.ascontiguousarray(values, np.float32)

    return Mesh(
        np.ascontiguousarray(positions, np.float32),
        np.ascontiguousarray(normals, np.float32),
        np.ascontiguousarray(uv, np.float32),
        np.ascontiguousarray(triangles, np.uint32),
        material,
        stored(colors),
        stored(tangents),
    )
