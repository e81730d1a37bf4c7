"""Models and lamps of a track's ``scene.xml``, through library nodes and levels of detail.

Left out: physics-only objects, particles, sounds, billboards, surfaces that only refract what is behind them, and
objects whose condition does not hold in a plain forward race. Of a level-of-detail group only the most detailed model
is used.
"""

from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from supersampling.errors import UserError
from supersampling.scenes.stk.data import Assets
from supersampling.scenes.stk.numbers import attribute, number
from supersampling.scenes.stk.placement import Placement, read_placement, triple

_INVISIBLE_TYPES = {"billboard", "sfx-emitter", "action-trigger", "cutscene_camera"}
_PHYSICS_ONLY = {"physics-only", "physicsonly"}
# Script functions of objects' conditions that are true in a plain forward race.
_HOLDS = {"true", "isTrackNotReverse", "isNotReverse", "isNotCTF", "isNotNetworking", "hasNoFlooding", "showDoorClosed"}
_DEEPEST = 8


@dataclass(frozen=True)
class PlacedModel:
    """Mesh file under a chain of nodes, outermost first."""

    path: Path
    chain: tuple[Placement, ...]


@dataclass(frozen=True)
class Lamp:
    """``<light>`` element: colour between 0 and 255, range ``distance`` in metres."""

    chain: tuple[Placement, ...]
    color: tuple[float, float, float]
    energy: float
    distance: float


class _Detail(NamedTuple):
    distance: float
    path: Path


def parse(path: Path) -> Element:
    """Return the root of an XML file of the data; expat limits expanding entities.

    Raises:
        UserError: The file is not XML.
    """
    try:
        return ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:
        raise UserError(
            f"{path.parent.name}/{path.name} is not valid XML ({error}): reinstall the SuperTuxKart data."
        ) from error


class SceneReader:
    """Reader that collects ``models`` and ``lamps`` from a track's nodes; missing files are skipped."""

    def __init__(self, assets: Assets) -> None:
        self.models: list[PlacedModel] = []
        self.lamps: list[Lamp] = []
        self._assets = assets
        self._groups: dict[str, _Detail] = {}
        self._libraries: dict[Path, Element] = {}

    def read(self, scene: Element) -> None:
        self._walk(scene, self._assets.track, ())

    def _walk(self, root: Element, folder: Path, chain: tuple[Placement, ...]) -> None:
        for item in root.findall("lod/group/static-object"):
            self._define(item, folder)
        for node in root:
            if node.tag == "track":
                inner = (*chain, read_placement(node))
                self._model(node, folder, inner)
                self._walk(node, folder, inner)
            elif node.tag in ("static-object", "object", "water") and _visible(node):
                self._model(node, folder, (*chain, read_placement(node)))
            elif node.tag == "library" and _visible(node):
                self._library(node, (*chain, read_placement(node)))
            elif node.tag == "light" and _visible(node):
                self._lamp(node, (*chain, read_placement(node)))

    def _define(self, item: Element, folder: Path) -> None:
        group = item.get("lod_group", "")
        text = item.get("lod_distance")
        distance = inf if text is None else number(text, largest=inf)
        path = self._assets.model(item.get("model", ""), folder)
        nearer = group not in self._groups or distance < self._groups[group].distance
        if path is not None and nearer:
            self._groups[group] = _Detail(distance, path)

    def _model(self, node: Element, folder: Path, chain: tuple[Placement, ...]) -> None:
        group = node.get("lod_group")
        path: Path | None
        if node.get("lod_instance") == "true" and group in self._groups:
            path = self._groups[group].path
        else:
            path = self._assets.model(node.get("model", ""), folder)
        if path is not None:
            self.models.append(PlacedModel(path, chain))

    def _library(self, node: Element, chain: tuple[Placement, ...]) -> None:
        path = self._assets.library(node.get("name", ""))
        # A node that contains itself would never end.
        if path is None or len(chain) > _DEEPEST:
            return
        if path not in self._libraries:
            self._libraries[path] = parse(path)
        self._walk(self._libraries[path], path.parent, chain)

    def _lamp(self, node: Element, chain: tuple[Placement, ...]) -> None:
        energy = attribute(node, "energy", 1.0)
        color = triple(node.get("color"), (255.0, 255.0, 255.0))
        self.lamps.append(Lamp(chain, color, energy, attribute(node, "distance", 20.0 * energy)))


def _visible(node: Element) -> bool:
    return (
        node.get("type") not in _INVISIBLE_TYPES
        and node.get("interaction") not in _PHYSICS_ONLY
        and node.get("displacing") != "true"
        and node.get("enabled", "true").lower() not in ("false", "n", "no")
        and node.get("if", "true") in _HOLDS
        and node.get("ifnot", "false") not in _HOLDS
    )
