"""Reader of SuperTuxKart's mesh format ``.spm`` (version 1).

Little-endian: ``SP``; a byte ``version << 3 | type`` (1 skinned, 2 plain); a byte of flags (1 normals, 2 colours, 4
tangents); a bounding box of 6 floats; the materials as pairs of texture names; then sectors of buffers, each with
vertices and indices. Source: ``src/graphics/sp_mesh_loader.cpp`` of SuperTuxKart 1.4. Skinned meshes are in their bind
pose.
"""

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError

Floats = NDArray[np.float32]
_NORMALS, _COLOURS, _TANGENTS = 1, 2, 4
_WHITE = 128
_FARTHEST = 1e6  # metres


@dataclass(frozen=True, eq=False)
class MeshBuffer:
    """Vertices and triangles of one material, in the file's left-handed space and winding.

    ``positions, normals (N, 3)``, ``colors (N, 3)`` uint8 or None for white, ``uv (N, 2)`` or None, ``triangles (M,
    3)``. ``textures`` are the texture names of the first and the second uv set, empty without a texture.
    """

    positions: Floats
    normals: Floats
    colors: NDArray[np.uint8] | None
    uv: Floats | None
    triangles: NDArray[np.uint32]
    textures: tuple[str, str]


class _ByteReader:
    def __init__(self, data: bytes) -> None:
        self.data = data
        self.position = 0

    def take(self, layout: str) -> tuple[int, ...]:
        values = struct.unpack_from("<" + layout, self.data, self.position)
        self.position += struct.calcsize("<" + layout)
        return values

    def text(self) -> str:
        (length,) = self.take("B")
        self.position += length
        return self.data[self.position - length : self.position].decode("utf-8", "replace")

    def array(self, dtype: str, count: int) -> NDArray[np.generic]:
        values = np.frombuffer(self.data, dtype, count, self.position)
        self.position += values.nbytes
        return values


def read_spm(path: Path) -> list[MeshBuffer]:
    """Return the buffers of a mesh file.

    Raises:
        UserError: The file is not ``.spm`` of version 1, or is cut short.
    """
    reader = _ByteReader(path.read_bytes())
    try:
        return _read(reader)
    except (struct.error, ValueError, IndexError) as error:
        raise UserError(
            f"{path.name} is not a valid .spm mesh of version 1 ({error}): reinstall the SuperTuxKart data."
        ) from error


def _read(reader: _ByteReader) -> list[MeshBuffer]:
    if reader.data[:2] != b"SP":
        raise ValueError("it does not begin with SP")
    reader.position = 2
    kind, flags = reader.take("BB")
    if kind >> 3 != 1 or kind & 7 not in (1, 2):
        raise ValueError(f"its version is {kind >> 3} and its type {kind & 7}")
    reader.take("6f")
    materials = [(reader.text(), reader.text()) for _ in range(reader.take("H")[0])]
    buffers = []
    for _ in range(reader.take("H")[0]):
        for _ in range(reader.take("H")[0]):
            vertices, indices, material = reader.take("IIH")
            buffers.append(_buffer(reader, vertices, indices, materials[material], flags, kind & 7 == 1))
    return buffers


def _buffer(
    reader: _ByteReader, vertices: int, indices: int, textures: tuple[str, str], flags: int, skinned: bool
) -> MeshBuffer:
    head = [("position", "<3f4")] + ([("normal", "<u4")] if flags & _NORMALS else [])
    tail = []
    if textures[0]:
        tail = [("uv", "<2f2")] + ([("uv2", "<2f2")] if textures[1] else [])
        tail += [("tangent", "<u4")] if flags & _TANGENTS else []
    tail += [("skin", "16u1")] if skinned else []
    front, back, colors = _vertices(reader, vertices, np.dtype(head), np.dtype(tail), bool(flags & _COLOURS))
    # Vertex counts up to 255 have byte indices.
    triangles = reader.array("<u2" if vertices > 255 else "u1", indices).astype(np.uint32).reshape(-1, 3)
    if triangles.size and triangles.max() >= vertices:
        raise ValueError(f"its indices reach vertex {triangles.max()} of {vertices}")
    positions = np.ascontiguousarray(front["position"], dtype=np.float32)
    if not (np.abs(positions) < _FARTHEST).all():
        raise ValueError("some of its positions are not finite")
    normals = _unpacked(front["normal"]) if flags & _NORMALS else _face_normals(positions, triangles)
    uv = np.nan_to_num(np.ascontiguousarray(back["uv"], dtype=np.float32)) if textures[0] else None
    return MeshBuffer(positions, normals, colors, uv, triangles, textures)


def _vertices(
    reader: _ByteReader, count: int, head: np.dtype, tail: np.dtype, coloured: bool
) -> tuple[NDArray, NDArray, NDArray[np.uint8] | None]:
    """Return the fields before a vertex's colour, those after it, and the colours ``(count, 3)`` or None."""
    data = np.frombuffer(reader.data, np.uint8, offset=reader.position)
    short = head.itemsize + tail.itemsize + int(coloured)
    if count * short > len(data):
        raise ValueError("it is cut short")
    if not coloured:
        starts = np.arange(count) * short
        ends, white = starts + head.itemsize, None
    else:
        starts = _coloured_starts(data, count, head.itemsize, short)
        white = data[starts + head.itemsize] == _WHITE
        ends = starts + head.itemsize + np.where(white, 1, 4)
    front = _gathered(data, starts, head)
    back = _gathered(data, ends, tail)
    reader.position += int(ends[-1]) + tail.itemsize if count else 0
    if white is None or white.all():
        return front, back, None
    colors = data[np.minimum(starts[:, None] + head.itemsize + np.arange(1, 4), len(data) - 1)]
    colors[white] = 255
    return front, back, colors


def _coloured_starts(data: NDArray[np.uint8], count: int, mark: int, short: int) -> NDArray[np.int64]:
    """Return the start of each vertex; a white one takes ``short`` bytes and any other three more."""
    for stride, white in ((short, True), (short + 3, False)):
        starts = np.arange(count) * stride
        if count and starts[-1] + mark < len(data) and bool(((data[starts + mark] == _WHITE) == white).all()):
            return starts
    # Each start depends on the previous ones. A plain loop over bytes costs 0.1 us per vertex.
    raw, position, positions = data.tobytes(), 0, []
    for _ in range(count):
        positions.append(position)
        position += short if raw[position + mark] == _WHITE else short + 3
    return np.asarray(positions, dtype=np.int64)


def _gathered(data: NDArray[np.uint8], starts: NDArray[np.int64], dtype: np.dtype) -> NDArray:
    if dtype.itemsize == 0:
        return np.zeros(len(starts), dtype)
    if len(starts) and int(starts[-1]) + dtype.itemsize > len(data):
        raise ValueError("it is cut short")
    return np.ascontiguousarray(data[starts[:, None] + np.arange(dtype.itemsize)]).view(dtype)[:, 0]


def _unpacked(packed: NDArray) -> Floats:
    """Return unit vectors ``(N, 3)`` of signed 10-10-10-2 integers; a zero vector becomes up."""
    signed = packed.astype(np.uint32)[:, None] << np.array([22, 12, 2], np.uint32)
    vectors = (signed.view(np.int32) >> 22).astype(np.float32)
    return _normalised(vectors)


def _face_normals(positions: Floats, triangles: NDArray[np.uint32]) -> Floats:
    """Return area-weighted vertex normals for meshes without normals; faces are clockwise in left-handed space."""
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    face = np.cross(b - a, c - a)
    normals = np.zeros_like(positions)
    for k in range(3):
        np.add.at(normals, triangles[:, k], face)
    return _normalised(normals)


def _normalised(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    # A zero vector has no direction: use up.
    up = np.array((0.0, 1.0, 0.0), np.float32)
    return np.where(length > 1e-12, vectors / np.maximum(length, 1e-12), up).astype(np.float32)
