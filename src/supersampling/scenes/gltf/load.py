"""A glTF 2.0 file as a scene.

Kept: the default scene's hierarchy, triangles, metallic-roughness materials with their textures, vertex colours, unlit and
emissive materials, punctual lights, perspective cameras, and the animation of nodes, over and over. Not kept: skins' and
morph targets' motion (both stay at rest), lines and points, blending (a test at half opacity), occlusion maps, texture
wrapping other than repeating, and animations of what another one moves; a warning names what a file has of these.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError
from supersampling.scenes.gltf.accessors import Accessors
from supersampling.scenes.gltf.animation import read_keyframes
from supersampling.scenes.gltf.document import MALFORMED, SUPPORTED, Document, malformed
from supersampling.scenes.gltf.lights import PunctualLight, lit, read_lights
from supersampling.scenes.gltf.materials import MaterialReader
from supersampling.scenes.gltf.meshes import MeshReader
from supersampling.scenes.gltf.nodes import Matrix, NodeTransform, SceneNode, scene_nodes
from supersampling.scenes.gltf.notes import Notes
from supersampling.scenes.gltf.routes import camera_routes, is_place, laid_routes, planes
from supersampling.scenes.gltf.survey import survey
from supersampling.scenes.scene import Object, Scene

# Metres of the radius that walking speeds, shadow maps and near planes are made for; other sizes are brought there.
_SMALLEST, _LARGEST = 0.5, 100.0
_FARTHEST = 1e12  # metres: beyond, single precision no longer tells its vertices apart


def load_gltf(path: Path) -> Scene:
    """The default scene of a ``.gltf`` or ``.glb`` file, at its own size if its radius is between 0.5 and 100 m, else scaled.

    What cannot be drawn as the file says is told as `UserWarning`, one a kind.

    Raises:
        UserError: not a readable glTF 2.0 file, or one that refers to what is missing, out of range or outside its folder.
    """
    path = Path(path)
    try:
        return _load(path)
    except MALFORMED as error:
        raise malformed(path.name, error) from error


def _load(path: Path) -> Scene:
    document = Document(path)
    notes = Notes(path.name)
    accessors = Accessors(document)
    materials = MaterialReader(document, notes)
    meshes = MeshReader(document, accessors, materials, notes)
    nodes = scene_nodes(document, read_keyframes(document, accessors, notes))
    placed = _drawn(document, accessors, meshes, nodes, notes)
    if not placed:
        raise UserError(f"{path.name} shows no triangles in its default scene: there is nothing to render.")
    found = survey(meshes.made, placed)
    if not found.radius < _FARTHEST:
        raise UserError(f"The geometry of {path.name} spans {2.0 * found.radius:.3g} m: check its nodes' transforms.")
    factor = float(np.clip(found.radius, _SMALLEST, _LARGEST) / found.radius)
    place = is_place(found.radius)
    root = np.diag([factor, factor, factor, 1.0])
    found = found.scaled(factor)
    routes = camera_routes(document, nodes, root, notes) + laid_routes(found, place)
    lamps = [_scaled(lamp, factor) for lamp in read_lights(document, nodes, notes)]
    sun, points, sky = lit(lamps, found.surface, notes)
    near, far = planes(found, routes)
    for extension in sorted(set(document.gltf.extensionsUsed or ()) - SUPPORTED):
        notes.add(f"the extension {extension} is ignored")
    notes.tell()
    return Scene(
        name=f"gltf/{path.stem}",
        materials=materials.made,
        meshes=meshes.made,
        objects=[Object(numbers, where.under(root).transform()) for numbers, where in placed],
        routes=routes,
        sun=sun,
        points=points,
        sky=sky,
        near=near,
        far=far,
        attribution=_attribution(document),
    )


def _drawn(
    document: Document, accessors: Accessors, meshes: MeshReader, nodes: Sequence[SceneNode], notes: Notes
) -> list[tuple[tuple[int, ...], NodeTransform]]:
    """The meshes of each node that has some, and where they are."""
    rest = {placed.index: placed.rest for placed in nodes}
    drawn = []
    for placed in nodes:
        node, place = placed.node, placed.place
        if node.mesh is None:
            continue
        if node.skin is not None:
            notes.add("skinned meshes stay in their rest pose")
            numbers, place = (
                meshes.skinned(node.mesh, _joints(document, accessors, node.skin, rest)),
                NodeTransform((np.eye(4),)),
            )
        elif not place.moves and np.linalg.det(place.at(0.0)[:3, :3]) == 0.0:
            notes.add("meshes of no size are left out")
            continue
        else:
            numbers = meshes.plain(node.mesh)
        if numbers:
            drawn.append((numbers, place))
    return drawn


def _joints(document: Document, accessors: Accessors, index: int, rest: dict[int, Matrix]) -> NDArray[np.float64]:
    """Joint matrices ``(J, 4, 4)`` of a skin: where its joints are at rest, after the inverse of where they were bound."""
    skin = document.item("skins", index)
    joints = np.stack([rest[joint] for joint in skin.joints])
    if skin.inverseBindMatrices is None:
        return joints
    # Columns come one after the other.
    inverse = accessors.floats(skin.inverseBindMatrices, 16).reshape(-1, 4, 4).transpose(0, 2, 1)
    return joints @ inverse[: len(joints)]


def _scaled(lamp: PunctualLight, factor: float) -> PunctualLight:
    """A lamp of a scaled world: candela grow with the area, so that everything is lit as before."""
    power = lamp.power if lamp.kind == "directional" else lamp.power * factor * factor
    reach = None if lamp.reach is None else lamp.reach * factor
    return replace(lamp, power=power, position=lamp.position * factor, reach=reach)


def _attribution(document: Document) -> str:
    """Whom a rendering owes credit, as far as the file says."""
    asset = document.asset
    extras = asset["extras"] if isinstance(asset.get("extras"), dict) else {}
    said = {"Copyright": asset.get("copyright")}
    said |= {key.capitalize(): extras.get(key) for key in ("title", "author", "license", "source")}
    parts = [f"{what}: {value}" for what, value in said.items() if value] or ["It names no copyright holder"]
    made = [f"Made with {asset['generator']}"] if asset.get("generator") else []
    return ". ".join([f"glTF file {document.name}", *parts, *made]) + "."
