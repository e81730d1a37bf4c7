"""A SuperTuxKart track as a scene.

Supported: every model of ``scene.xml`` in its finest detail, keyframed objects, textures, normal and gloss maps, vertex
colours, sun, sky colours, the strongest lamps. Not supported: fog, particles, scrolling textures, waving grass, and the
second texture layer of decals and splatted ground; skinned characters stand in their bind pose.
"""

from pathlib import Path

import numpy as np

from supersampling.errors import UserError
from supersampling.scenes.scene import Mesh, Object, Route, Scene
from supersampling.scenes.stk.attribution import attribution
from supersampling.scenes.stk.data import Assets, data_folder, track_folder
from supersampling.scenes.stk.images import linear
from supersampling.scenes.stk.materials import TrackMaterials
from supersampling.scenes.stk.nodes import SceneReader, parse
from supersampling.scenes.stk.placement import world_transform
from supersampling.scenes.stk.routes import read_routes
from supersampling.scenes.stk.sky import exposure_for, nearby_lamps, read_sky, read_sun, sky_files
from supersampling.scenes.stk.spm import MeshBuffer, read_spm

_FLIP = np.array([1.0, 1.0, -1.0], np.float32)
_NEAR = 0.2
_FARTHEST = 1000.0


def load_track(name: str, root: Path | None = None) -> Scene:
    """Return the track called ``name`` of the SuperTuxKart data in ``root`` (default: the folder of `find_data`).

    Raises:
        UserError: The data are not installed, the track does not exist, or one of its files cannot be read.
    """
    folder = track_folder(name, root)
    assets = Assets(data_folder(root), folder)
    source = parse(folder / "scene.xml")
    head = parse(folder / "track.xml") if (folder / "track.xml").is_file() else None
    reader = SceneReader(assets)
    reader.read(source)
    geometry = _Geometry(TrackMaterials(assets, by_day=head is None or head.get("is-during-day", "Y") == "Y"))
    objects = []
    for model in reader.models:
        meshes = geometry.load(model.path)
        item = Object(meshes, world_transform(model.chain))
        if not np.isfinite(item.at(0.0)).all():
            raise UserError(f"The place of {model.path.name} in {name} is not finite: reinstall the SuperTuxKart data.")
        if meshes:
            objects.append(item)
    routes = read_routes(folder)
    sun, sky = read_sun(source), read_sky(source, assets)
    files = {model.path for model in reader.models} | geometry.materials.files | set(sky_files(source, assets))
    return Scene(
        name=f"stk/{name}",
        materials=geometry.materials.materials,
        meshes=geometry.meshes,
        objects=objects,
        routes=routes,
        sun=sun,
        points=nearby_lamps(reader.lamps, routes),
        sky=sky,
        exposure=exposure_for(sun, sky),
        near=_NEAR,
        far=_far(routes, geometry.meshes, objects),
        attribution=attribution(folder, assets.root, files),
    )


def _far(routes: list[Route], meshes: list[Mesh], objects: list[Object]) -> float:
    """Return a far plane that contains the scenery as seen from the middle of the routes, up to a kilometre."""
    middle = np.concatenate([route.points for route in routes]).mean(axis=0)
    reach = [_FARTHEST * 0.3]
    for item in objects:
        for mesh in item.meshes:
            corners = np.stack([meshes[mesh].positions.min(axis=0), meshes[mesh].positions.max(axis=0)])
            placed = corners @ item.at(0.0)[:3, :3].T + item.at(0.0)[:3, 3]
            reach.append(float(np.linalg.norm(np.abs(placed - middle).max(axis=0))))
    return float(min(1.2 * max(reach), _FARTHEST))


class _Geometry:
    """Meshes of the track; each file is read once, so that instances of a model share its meshes."""

    def __init__(self, materials: TrackMaterials) -> None:
        self.meshes: list[Mesh] = []
        self.materials = materials
        self._files: dict[Path, tuple[int, ...]] = {}

    def load(self, path: Path) -> tuple[int, ...]:
        if path not in self._files:
            first = len(self.meshes)
            for buffer in read_spm(path):
                self._add(buffer, path.parent)
            self._files[path] = tuple(range(first, len(self.meshes)))
        return self._files[path]

    def _add(self, buffer: MeshBuffer, folder: Path) -> None:
        material = self.materials.number(buffer.textures, folder)
        if material is None or not len(buffer.triangles):
            return
        # Grass stores its swaying in the colours: do not draw them.
        sways = self.materials.attributes(buffer.textures, folder).get("shader") == "grass"
        colors = None if buffer.colors is None or sways else linear(buffer.colors / np.float32(255.0))
        uv = np.zeros((len(buffer.positions), 2), np.float32) if buffer.uv is None else buffer.uv
        positions, normals = buffer.positions * _FLIP, buffer.normals * _FLIP
        # The game's front faces are clockwise on screen, the renderer's counter-clockwise.
        triangles = np.ascontiguousarray(buffer.triangles[:, ::-1])
        self.meshes.append(Mesh(positions, normals, uv, triangles, material, colors))
