"""A glTF 2.0 file as a scene.

Supported: the default scene's hierarchy, triangles, metallic-roughness materials with their textures, vertex colours,
unlit and emissive materials, punctual lights, perspective cameras, and the repeated animation of nodes; skins and morph
targets at rest. `features` lists what is drawn otherwise than the file says, with the warning for each.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from supersampling.errors import UserError
from supersampling.scenes.gltf.accessors import Accessors
from supersampling.scenes.gltf.animation import FARTHEST, read_keyframes
from supersampling.scenes.gltf.document import MALFORMED, Document, malformed
from supersampling.scenes.gltf.features import SUPPORTED, Deviation
from supersampling.scenes.gltf.lights import PunctualLight, read_lights, scene_lights
from supersampling.scenes.gltf.materials import MaterialReader
from supersampling.scenes.gltf.meshes import MeshReader
from supersampling.scenes.gltf.nodes import Matrix, NodeTransform, SceneNode, scene_nodes
from supersampling.scenes.gltf.notes import Notes
from supersampling.scenes.gltf.routes import camera_routes, geometry_routes, is_walkable, planes
from supersampling.scenes.gltf.survey import survey
from supersampling.scenes.scene import Object, Scene

# Radii in metres that walking speeds, shadow maps and near planes are designed for; other sizes are scaled to them.
_SMALLEST, _LARGEST = 0.5, 100.0
_NEAREST = 1e-6  # metres; a survey takes smaller geometry, a single point, for this large


def load_gltf(path: Path) -> Scene:
    """Return the default scene of a ``.gltf`` or ``.glb`` file, scaled if its radius is not between 0.5 and 100 m.

    Unsupported content is reported as one `UserWarning` per kind.

    Raises:
        UserError: The file is not readable glTF 2.0, or refers to something missing, out of range or outside its
        folder.
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
    nodes = scene_nodes(document, read_keyframes(document, accessors, notes), notes)
    instances = _instances(document, accessors, meshes, nodes, notes)
    if not instances:
        raise UserError(f"The default scene of {path.name} has no triangles: add meshes to it.")
    geometry = survey(meshes.meshes, instances)
    if not _NEAREST < geometry.radius < FARTHEST:
        raise UserError(
            f"The geometry of {path.name} spans {2.0 * geometry.radius:.3g} m: check its nodes' transforms."
        )
    factor = float(np.clip(geometry.radius, _SMALLEST, _LARGEST) / geometry.radius)
    walkable = is_walkable(geometry.radius)
    root = np.diag([factor, factor, factor, 1.0])
    geometry = geometry.scaled(factor)
    routes = camera_routes(document, nodes, geometry, factor, notes) + geometry_routes(geometry, walkable)
    lights = [_scaled(light, factor) for light in read_lights(document, nodes, notes)]
    sun, points, sky = scene_lights(lights, geometry.surface, notes)
    near, far = planes(geometry, routes)
    for extension in sorted(document.used_extensions() - SUPPORTED):
        notes.add_extension(extension)
    notes.warn()
    return Scene(
        name=f"gltf/{path.stem}",
        materials=materials.materials,
        meshes=meshes.meshes,
        objects=[Object(numbers, transform.under(root).scene_transform()) for numbers, transform in instances],
        routes=routes,
        sun=sun,
        points=points,
        sky=sky,
        near=near,
        far=far,
        attribution=_attribution(document),
    )


def _instances(
    document: Document, accessors: Accessors, meshes: MeshReader, nodes: Sequence[SceneNode], notes: Notes
) -> list[tuple[tuple[int, ...], NodeTransform]]:
    """Return the meshes and the transform of each node that has meshes."""
    placed = {item.index: item for item in nodes}
    instances = []
    for item in nodes:
        node, transform = item.node, item.transform
        if node.mesh is None:
            continue
        if node.skin is not None:
            skin = document.item("skins", node.skin)
            joints = [_joint(document, placed, joint) for joint in skin.joints]
            if any(joint.transform.moves for joint in joints):
                notes.add(Deviation.SKINS)
            numbers = meshes.skinned(node.mesh, item.weights, _joint_matrices(accessors, skin, joints))
            transform = NodeTransform((np.eye(4),))
        elif not transform.moves and np.linalg.det(transform.matrix(0.0)[:3, :3]) == 0.0:
            notes.add(Deviation.FLAT_MESHES)
            continue
        else:
            numbers = meshes.plain(node.mesh, item.weights)
        if numbers:
            instances.append((numbers, transform))
    return instances


def _joint(document: Document, placed: Mapping[int, SceneNode], index: int) -> SceneNode:
    if index not in placed:
        raise UserError(f"The joint {index} of a skin of {document.name} is no node of its scene: export it again.")
    return placed[index]


def _joint_matrices(accessors: Accessors, skin: Any, joints: Sequence[SceneNode]) -> Matrix:
    """Return the joint matrices ``(J, 4, 4)`` of a skin: its joints at rest times their inverse bind matrices."""
    rest = np.stack([joint.rest for joint in joints])
    if skin.inverseBindMatrices is None:
        return rest
    # glTF stores matrices column by column.
    inverse = accessors.floats(skin.inverseBindMatrices, 16).reshape(-1, 4, 4).transpose(0, 2, 1)
    return rest @ inverse[: len(rest)]


def _scaled(light: PunctualLight, factor: float) -> PunctualLight:
    """Return a light of a scaled world: candela grow with the area, so that the illuminance does not change."""
    power = light.power if light.kind == "directional" else light.power * factor * factor
    reach = None if light.reach is None else light.reach * factor
    return replace(light, power=power, position=light.position * factor, reach=reach)


def _attribution(document: Document) -> str:
    """Return the credits that the file states."""
    asset = document.asset
    extras = asset["extras"] if isinstance(asset.get("extras"), dict) else {}
    credits_ = {"Copyright": asset.get("copyright")}
    credits_ |= {key.capitalize(): extras.get(key) for key in ("title", "author", "license", "source")}
    parts = [f"{what}: {value}" for what, value in credits_.items() if value] or ["It names no copyright holder"]
    generator = [f"Made with {asset['generator']}"] if asset.get("generator") else []
    return ". ".join([f"glTF file {document.name}", *parts, *generator]) + "."
