"""Files of the rows about geometry in docs/gltf.md."""

import struct

import numpy as np
from gltf_cases import case, patched
from gltf_files import SQUARE, SQUARE_INDICES, SQUARE_UV, Builder

from supersampling.scenes.gltf.features import Deviation

UP = [(0.0, 0.0, 1.0)] * 4
NOISE = np.random.default_rng(3).integers(0, 256, (4, 4, 3))


def _mesh(file: Builder, attributes: dict[str, int], indices: object = SQUARE_INDICES, **more: object) -> None:
    full = {"POSITION": file.accessor(SQUARE), "NORMAL": file.accessor(UP), **attributes}
    file.node(mesh=file.mesh(full, indices=file.accessor(indices, "u2"), **more))


def _textured(file: Builder, **slots: object) -> int:
    return file.material(pbrMetallicRoughness={"baseColorTexture": {"index": file.texture(NOISE)}}, **slots)


@case("Triangles, triangle strips and fans")
def strips(file: Builder, plain: Builder) -> None:
    _mesh(file, {}, (0, 1, 3, 2), mode=5)
    _mesh(file, {}, (0, 1, 2, 3), mode=6)
    _mesh(plain, {}, (0, 1, 3, 1, 2, 3))
    _mesh(plain, {}, (1, 2, 0, 2, 3, 0))


@case("Points, lines, line strips and line loops", Deviation.TOPOLOGY)
def lines(file: Builder) -> None:
    for mode in (0, 1, 2, 3, 4):
        _mesh(file, {}, mode=mode)


@case("Unknown kinds of primitives", error="unknown mode 7")
def unknown_mode(file: Builder) -> None:
    _mesh(file, {}, mode=7)


@case("Indices of 8, 16 or 32 bits, or none")
def indices(file: Builder, plain: Builder) -> None:
    for dtype in ("u1", "u4"):
        file.node(mesh=file.mesh({"POSITION": file.accessor(SQUARE)}, indices=file.accessor(SQUARE_INDICES, dtype)))
    corners = np.array(SQUARE)[list(SQUARE_INDICES)]
    file.node(mesh=file.mesh({"POSITION": file.accessor(corners)}))
    for _ in range(3):
        plain.node(mesh=plain.mesh({"POSITION": plain.accessor(SQUARE)}, indices=plain.accessor(SQUARE_INDICES, "u2")))


@case("Indices beyond the vertices", error="reach vertex 9 of 4")
def wrong_indices(file: Builder) -> None:
    _mesh(file, {}, (0, 1, 9))


@case("Sparse accessors, strides and normalised integers")
def accessors(file: Builder, plain: Builder) -> None:
    rows = b"".join(struct.pack("<3f4b", *position, 0, 0, 127, 0) for position in SQUARE)
    view = file.view(rows, byteStride=16)
    moved = {
        "count": 1,
        "indices": {"bufferView": file.view(struct.pack("<H", 2)), "componentType": 5123},
        "values": {"bufferView": file.view(struct.pack("<3f", 2, 2, 0))},
    }
    item = {"bufferView": view, "count": 4, "type": "VEC3"}
    position = file.add("accessors", {**item, "componentType": 5126, "sparse": moved})
    normal = file.add("accessors", {**item, "componentType": 5120, "byteOffset": 12, "normalized": True})
    _mesh(file, {"POSITION": position, "NORMAL": normal})
    _mesh(plain, {"POSITION": plain.accessor([*SQUARE[:2], (2.0, 2.0, 0.0), SQUARE[3]])})


@case("Primitives without positions", Deviation.POSITIONS)
def no_positions(file: Builder) -> None:
    _mesh(file, {})
    file.json["meshes"][0]["primitives"].append({"attributes": {"NORMAL": 1}})


@case("Positions that are not finite", error="positions of primitive 0 of mesh 0 .* are not finite")
def infinite_positions(file: Builder) -> None:
    _mesh(file, {})
    patched(file, 0, {3: np.inf})


@case("Other attributes that are not finite", Deviation.NOT_FINITE)
def infinite_colors(file: Builder) -> None:
    colors = file.accessor([[1.0, 1.0, 1.0]] * 4)
    patched(file, colors, {1: np.nan})
    _mesh(file, {"COLOR_0": colors})


@case("Missing normals")
def flat(file: Builder, plain: Builder) -> None:
    file.node(mesh=file.mesh({"POSITION": file.accessor(SQUARE)}, indices=file.accessor(SQUARE_INDICES, "u2")))
    _mesh(plain, {})


@case("Tangents")
def tangents(file: Builder, plain: Builder) -> None:
    """Tangents along u, which are those that the renderer derives without any."""
    along = {"TANGENT": file.accessor([(1.0, 0.0, 0.0, 1.0)] * 4)}
    for builder, more in ((file, along), (plain, {})):
        material = builder.material(normalTexture={"index": builder.texture(NOISE)})
        _mesh(builder, {"TEXCOORD_0": builder.accessor(SQUARE_UV), **more}, material=material)


@case("Any set of texture coordinates")
def sets(file: Builder, plain: Builder) -> None:
    for builder, number in ((file, 5), (plain, 0)):
        material = _textured(builder)
        info = builder.json["materials"][material]["pbrMetallicRoughness"]["baseColorTexture"]
        info["texCoord"] = number
        _mesh(builder, {f"TEXCOORD_{number}": builder.accessor(SQUARE_UV)}, material=material)


@case("Textures whose coordinates are missing", Deviation.NO_COORDINATES)
def no_coordinates(file: Builder) -> None:
    _mesh(file, {}, material=_textured(file))


@case("Vertex colours, of floats, bytes or shorts")
def colors(file: Builder, plain: Builder) -> None:
    for dtype, unit in (("u1", 255), ("u2", 65535)):
        values = [[unit, unit // 5, 0, unit // 3]] * 4
        _mesh(file, {"COLOR_0": file.accessor(values, dtype, normalized=True)})
        _mesh(plain, {"COLOR_0": plain.accessor([[1.0, 0.2, 0.0]] * 4)})


@case("Second vertex colours and attributes of applications")
def application_attributes(file: Builder, plain: Builder) -> None:
    _mesh(file, {"COLOR_1": file.accessor([[1.0, 0.2, 0.0]] * 4), "_HEAT": file.accessor([1.0] * 4)})
    _mesh(plain, {})


@case("Morph targets with the weights of the mesh or node")
def morph_targets(file: Builder, plain: Builder) -> None:
    first = {"POSITION": file.accessor([[0.0, 0.0, 1.0]] * 4), "NORMAL": file.accessor([[0.0, 1.0, 0.0]] * 4)}
    second = {"POSITION": file.accessor([[4.0, 0.0, 0.0]] * 4)}
    _mesh(file, {}, targets=[first, second])
    file.json["meshes"][0]["weights"] = [0.5, 0.0]
    file.node(mesh=0, weights=[0.0, 0.25])
    half = np.add(SQUARE, [0.0, 0.0, 0.5])
    _mesh(plain, {"POSITION": plain.accessor(half), "NORMAL": plain.accessor([(0.0, 0.2**0.5, 0.8**0.5)] * 4)})
    _mesh(plain, {"POSITION": plain.accessor(np.add(SQUARE, [1.0, 0.0, 0.0]))})


def _skinned(file: Builder, attributes: dict[str, int], *joints: dict[str, object]) -> None:
    nodes = [file.node(**joint) for joint in joints]
    file.add("skins", {"joints": nodes})
    _mesh(file, attributes)
    file.json["nodes"][-1]["skin"] = 0


@case("Skins at rest, with any number of influences per vertex")
def skins(file: Builder, plain: Builder) -> None:
    def shares(weight: float) -> int:
        return file.accessor([[weight, 0.0, 0.0, 0.0]] * 4)

    joints = {f"JOINTS_{k}": file.accessor([[k, 0, 0, 0]] * 4, "u1") for k in (0, 1)}
    attributes = {**joints, "WEIGHTS_0": shares(0.25), "WEIGHTS_1": shares(0.75)}
    _skinned(file, attributes, {}, {"translation": [4.0, 0.0, 0.0]})
    _mesh(plain, {"POSITION": plain.accessor(np.add(SQUARE, [3.0, 0.0, 0.0]))})


@case("Skins whose joints mirror")
def mirrored_skins(file: Builder, plain: Builder) -> None:
    joints = {"JOINTS_0": file.accessor([[0, 0, 0, 0]] * 4, "u1"), "WEIGHTS_0": file.accessor([[1.0, 0, 0, 0]] * 4)}
    _skinned(file, joints, {"scale": [-1.0, 1.0, 1.0], "translation": [3.0, 0.0, 0.0]})
    mirrored = np.array(SQUARE) * [-1.0, 1.0, 1.0] + [3.0, 0.0, 0.0]
    _mesh(plain, {"POSITION": plain.accessor(mirrored)}, (2, 1, 0, 3, 2, 0))
