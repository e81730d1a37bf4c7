"""Files of the rows about nodes, animations, cameras and lights in docs/gltf.md."""

from typing import Any

import numpy as np
from gltf_cases import case, quarter
from gltf_files import SQUARE, Builder, data_uri

from supersampling.scenes.gltf.features import Deviation

STILL = {"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}


def _rows(matrix: Any) -> list[float]:
    """Return a matrix in glTF's order, column by column."""
    return [float(v) for v in np.asarray(matrix, float).T.ravel()]


@case("`.glb`, `.gltf` with data URIs or files beside it")
def containers(file: Builder, plain: Builder) -> None:
    file.node(mesh=file.square())
    file.json["buffers"] = [{"byteLength": len(file.blob), "uri": data_uri(file.blob)}]
    file.blob = b""
    plain.node(mesh=plain.square())


@case("Other versions than 2.0, also as `minVersion`", error="requires a reader of glTF 2.1 or newer")
def versions(file: Builder) -> None:
    file.node(mesh=file.square())
    file.json["asset"] = {"version": "2.1", "minVersion": "2.1"}


@case("Hierarchy of translations, rotations, scales and matrices, sheared ones as well")
def hierarchy(file: Builder, plain: Builder) -> None:
    shear = np.array([[1.0, 0.5, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    child = file.node(mesh=file.square(), matrix=_rows(shear))
    file.node(children=[child], translation=[1.0, 2.0, 3.0], rotation=quarter(2), scale=[2.0, 1.0, 1.0])
    place = np.array([[0, -1, 0, 1], [2, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]) @ shear
    plain.node(mesh=plain.square(), matrix=_rows(place))


@case("Negative scales")
def mirrored(file: Builder, plain: Builder) -> None:
    file.node(mesh=file.square(), scale=[-1.0, 1.0, 1.0])
    plain.node(mesh=plain.square(), matrix=_rows(np.diag([-1.0, 1.0, 1.0, 1.0])))


@case("Matrices that flatten or shrink a mesh to nothing", Deviation.FLAT_MESHES)
def no_size(file: Builder) -> None:
    file.node(mesh=file.square())
    file.node(mesh=0, matrix=_rows(np.diag([0.0, 0.0, 0.0, 1.0])))


@case("Several nodes with the same mesh")
def instances(file: Builder, plain: Builder) -> None:
    mesh = file.square()
    for x in (0.0, 5.0):
        file.node(mesh=mesh, translation=[x, 0.0, 0.0])
        plain.node(mesh=plain.square(), translation=[x, 0.0, 0.0])


@case("The default scene, or all nodes without a scene")
def scenes(file: Builder, plain: Builder) -> None:
    file.node(mesh=file.square())
    file.node(mesh=0, translation=[9.0, 0.0, 0.0])
    file.json |= {"scenes": [{"nodes": [1]}, {"nodes": [0]}], "scene": 1}
    plain.node(mesh=plain.square())
    plain.json["scenes"] = []


@case("Several scenes without a default", Deviation.SCENES)
def no_default(file: Builder) -> None:
    file.node(mesh=file.square())
    file.json |= {"scenes": [{"nodes": [0]}, {"nodes": []}]}


@case("Nodes that form cycles or have two parents", error="its own ancestor or has two parents")
def cycles(file: Builder) -> None:
    file.node(mesh=file.square(), children=[1])
    file.node(children=[0])
    file.json["scenes"] = [{"nodes": [0]}]


@case("Steps, straight lines and cubic splines of translation, rotation and scale")
def animations(file: Builder, plain: Builder) -> None:
    """At the times that are compared, the curves have the same values in both files."""
    rise = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]
    node, copy = file.node(mesh=file.square()), plain.node(mesh=plain.square())
    line = np.array([[[1.0, 0, 0], p, [1.0, 0, 0]] for p in rise]).reshape(6, 3)
    file.animate(node, "translation", [0.0, 2.0], line, "CUBICSPLINE")
    file.animate(node, "scale", [0.0, 2.0], [[2.0, 2.0, 2.0], [1.0, 1.0, 1.0]], "STEP")
    plain.animate(copy, "translation", [0.0, 2.0], rise)
    plain.animate(copy, "scale", [0.0, 1.9, 1.99, 2.0], [[2.0] * 3] * 3 + [[1.0] * 3])


@case("Animated scales that become negative")
def mirroring(file: Builder, plain: Builder) -> None:
    """How they are drawn is compared in test_gltf_rendered.py."""
    for builder in (file, plain):
        node = builder.node(mesh=builder.square())
        builder.animate(node, "scale", [0.0, 2.0], [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]])


@case("Several animations of the same property", Deviation.TWICE)
def twice(file: Builder) -> None:
    node = file.node(mesh=file.square())
    for _ in range(2):
        file.animate(node, "translation", [0.0, 1.0], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])


@case("Animations of nodes that have a matrix", error="animated and has a matrix")
def animated_matrix(file: Builder) -> None:
    node = file.node(mesh=file.square(), matrix=_rows(np.eye(4)))
    file.animate(node, "translation", [0.0, 1.0], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])


@case("Skins whose joints are not in the scene", error="joint 0 of a skin of a.glb is no node of its scene")
def outer_joints(file: Builder) -> None:
    file.node()
    file.add("skins", {"joints": [0]})
    file.node(mesh=file.square(), skin=0)
    file.json["scenes"] = [{"nodes": [1]}]


@case("Animations of joints", Deviation.SKINS)
def moving_skins(file: Builder) -> None:
    bone = {"JOINTS_0": file.accessor([[0, 0, 0, 0]] * 4, "u1"), "WEIGHTS_0": file.accessor([[1.0, 0, 0, 0]] * 4)}
    joint = file.node()
    file.add("skins", {"joints": [joint]})
    file.node(mesh=file.square(None, **bone), skin=0)
    file.animate(joint, "translation", [0.0, 1.0], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])


@case("Animations of morph targets", Deviation.WEIGHTS)
def moving_targets(file: Builder) -> None:
    node = file.node(mesh=file.square())
    file.json["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": file.accessor(SQUARE)}]
    file.animate(node, "weights", [0.0, 1.0], [0.0, 1.0])


@case("Animations of materials, lights and cameras", Deviation.CHANNELS)
def pointers(file: Builder) -> None:
    file.node(mesh=file.square())
    file.animate(0, "pointer", [0.0, 1.0], [0.0, 1.0])
    del file.json["animations"][0]["channels"][0]["target"]["node"]


@case("Perspective cameras, moving ones as well")
def cameras(file: Builder, plain: Builder) -> None:
    """Scales of the nodes above do not change what a camera sees."""
    for builder in (file, plain):
        builder.node(mesh=builder.square())
        builder.node(camera=builder.add("cameras", STILL), name="eye", translation=[0.0, 0.0, 4.0])
    file.json["nodes"][1]["scale"] = [2.0, 2.0, 2.0]


def _camera(file: Builder, lens: dict[str, Any], kind: str = "perspective", **node: Any) -> None:
    file.node(mesh=file.square())
    file.node(camera=file.add("cameras", {"type": kind, kind: lens}), translation=[0.0, 0.0, 4.0], **node)


@case("Aspect ratios of cameras", Deviation.ASPECT)
def aspect(file: Builder) -> None:
    _camera(file, {"yfov": 0.7, "znear": 0.1, "aspectRatio": 1.0})


@case("Near and far planes of cameras, where they cut geometry", Deviation.PLANES)
def lens_planes(file: Builder) -> None:
    _camera(file, {"yfov": 0.7, "znear": 0.1, "zfar": 3.0})


@case("Orthographic cameras", Deviation.ORTHOGRAPHIC)
def orthographic(file: Builder) -> None:
    _camera(file, {"xmag": 1.0, "ymag": 1.0, "znear": 0.1, "zfar": 9.0}, "orthographic")


@case("Cameras whose matrix has no size", Deviation.FLAT_CAMERAS)
def flat_camera(file: Builder) -> None:
    file.node(mesh=file.square())
    file.node(camera=file.add("cameras", STILL), matrix=_rows(np.diag([0.0, 0.0, 0.0, 1.0])))


def _light(file: Builder, light: dict[str, Any], **node: Any) -> int:
    return file.node(extensions={"KHR_lights_punctual": {"light": file.light(**light)}}, **node)


@case("Directional, point and spot lights of `KHR_lights_punctual`: colour, intensity, range and cone")
def lights(file: Builder, plain: Builder) -> None:
    """Only the ratio of intensities counts."""
    for builder, unit in ((file, 2.0), (plain, 1.0)):
        builder.node(mesh=builder.square())
        _light(builder, {"type": "directional", "intensity": 2.0 * unit, "color": [1.0, 0.5, 0.25]})
        _light(builder, {"type": "point", "intensity": unit, "range": 5.0}, translation=[0.0, 0.0, 2.0])
        cone = {"innerConeAngle": 0.2, "outerConeAngle": 0.5}
        _light(builder, {"type": "spot", "intensity": unit, "range": 9.0, "spot": cone}, translation=[0.0, 1.0, 2.0])


@case("Several directional lights", Deviation.SUNS)
def suns(file: Builder) -> None:
    file.node(mesh=file.square())
    for intensity in (1.0, 2.0):
        _light(file, {"type": "directional", "intensity": intensity})


@case("Lights on moving nodes", Deviation.MOVING_LIGHTS)
def moving_lights(file: Builder) -> None:
    file.node(mesh=file.square())
    node = _light(file, {"type": "point"}, translation=[0.0, 0.0, 2.0])
    file.animate(node, "translation", [0.0, 1.0], [[0.0, 0.0, 2.0], [1.0, 0.0, 2.0]])
