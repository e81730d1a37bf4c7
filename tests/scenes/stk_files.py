"""Writes tiny SuperTuxKart files byte by byte, from the format's description alone."""

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Vertex:
    position: tuple[float, float, float]
    normal: tuple[int, int, int] = (0, 511, 0)  # -511..511
    color: tuple[int, int, int] | None = None  # None: the one-byte white
    uv: tuple[float, float] = (0.0, 0.0)
    uv2: tuple[float, float] = (0.0, 0.0)


def packed_normal(normal: tuple[int, int, int]) -> int:
    x, y, z = (value & 0x3FF for value in normal)
    return x | y << 10 | z << 20


def spm_bytes(
    buffers: Sequence[tuple[Sequence[Vertex], Sequence[int], tuple[str, str]]],
    *,
    normals: bool = True,
    colors: bool = False,
    tangents: bool = False,
    skinned: bool = False,
) -> bytes:
    """Return an .spm file of one sector; buffers are ``(vertices, indices, (texture, second texture))``."""
    out = bytearray(b"SP")
    out += struct.pack("<BB", 1 << 3 | (1 if skinned else 2), normals | colors << 1 | tangents << 2)
    out += struct.pack("<6f", *range(6))
    out += struct.pack("<H", len(buffers))
    for _, _, textures in buffers:
        for texture in textures:
            out += struct.pack("<B", len(texture)) + texture.encode()
    out += struct.pack("<HH", 1, len(buffers))
    for material, (vertices, indices, textures) in enumerate(buffers):
        out += struct.pack("<IIH", len(vertices), len(indices), material)
        for vertex in vertices:
            out += struct.pack("<3f", *vertex.position)
            if normals:
                out += struct.pack("<I", packed_normal(vertex.normal))
            if colors:
                out += b"\x80" if vertex.color is None else struct.pack("<4B", 0, *vertex.color)
            if textures[0]:
                out += struct.pack("<2e", *vertex.uv)
                if textures[1]:
                    out += struct.pack("<2e", *vertex.uv2)
                if tangents:
                    out += struct.pack("<I", 0x12345678)
            if skinned:
                out += bytes(range(16))
        out += struct.pack(f"<{len(indices)}{'H' if len(vertices) > 255 else 'B'}", *indices)
    return bytes(out)


# A wall facing -z of the game's space: seen from there, its corners run clockwise.
WALL = (
    Vertex((0.0, 0.0, 5.0), normal=(0, 0, -511), uv=(0.0, 1.0)),
    Vertex((0.0, 2.0, 5.0), normal=(0, 0, -511), uv=(0.0, 0.0)),
    Vertex((3.0, 2.0, 5.0), normal=(0, 0, -511), uv=(1.0, 0.0)),
    Vertex((3.0, 0.0, 5.0), normal=(0, 0, -511), uv=(1.0, 1.0)),
)
WALL_INDICES = (0, 1, 2, 0, 2, 3)


def write_track(root: Path, name: str, scene: str, **files: str) -> Path:
    """A data folder with one track: a straight driveline of ten 20 m quads along +z, 8 m wide, and the given scene."""
    track = root / "tracks" / name
    for folder in (track, root / "textures", root / "models", root / "library"):
        folder.mkdir(parents=True, exist_ok=True)
    (track / "scene.xml").write_text(f"<scene>{scene}</scene>")
    (track / "track.xml").write_text('<track name="Test Lane" designer="A. Designer" is-during-day="Y"/>')
    quads = ['<quad p0="-4 1 0" p1="4 1 0" p2="4 1 20" p3="-4 1 20"/>']
    quads += [
        f'<quad p0="{k - 1}:3" p1="{k - 1}:2" p2="4 1 {20 * k + 20}" p3="-4 1 {20 * k + 20}"/>' for k in range(1, 10)
    ]
    (track / "quads.xml").write_text(f"<quads>{''.join(quads)}</quads>")
    (track / "graph.xml").write_text('<graph><edge-loop from="0" to="9"/></graph>')
    for file, text in files.items():
        (track / f"{file}.xml").write_text(text)
    return track
