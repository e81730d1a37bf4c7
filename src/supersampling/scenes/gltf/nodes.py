"""The node hierarchy: where every node of the scene is, at rest and at any time (specification, section 3.5)."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError
from supersampling.scenes.gltf.animation import Keyframes, Vector, local_matrix, moving_matrix
from supersampling.scenes.gltf.document import Document
from supersampling.scenes.scene import Array, Transform

Matrix = NDArray[np.float64]
Link: TypeAlias = "Matrix | Callable[[float], Matrix]"
_IDENTITY = np.eye(4)


@dataclass(frozen=True, eq=False)
class NodeTransform:
    """A product of matrices, constant ones and functions of time, from the world inwards."""

    links: tuple[Link, ...] = ()

    @property
    def moves(self) -> bool:
        return any(callable(link) for link in self.links)

    def then(self, link: Link) -> "NodeTransform":
        """A child's place; constant matrices that follow each other become one."""
        if not self.links or callable(link) or callable(self.links[-1]):
            return NodeTransform((*self.links, link))
        return NodeTransform((*self.links[:-1], self.links[-1] @ link))

    def under(self, root: Matrix) -> "NodeTransform":
        """The same place in a world that ``root`` brings into another one."""
        out = NodeTransform((root,))
        for link in self.links:
            out = out.then(link)
        return out

    def at(self, seconds: float) -> Matrix:
        """``(4, 4)`` to the world."""
        out = _IDENTITY
        for link in self.links:
            out = out @ (link(seconds) if callable(link) else link)
        return out

    def transform(self) -> Array | Transform:
        """As the scene has it: a constant float32 matrix, or a function of time."""
        if not self.moves:
            return self.at(0.0).astype(np.float32)
        return lambda seconds: self.at(seconds).astype(np.float32)


@dataclass(frozen=True, eq=False)
class SceneNode:
    """A node of the scene: pygltflib's object, where it is, and where it is at rest in its hierarchy."""

    index: int
    node: Any
    place: NodeTransform
    rest: Matrix


def scene_nodes(document: Document, curves: Mapping[int, Mapping[str, Keyframes]]) -> list[SceneNode]:
    """Every node below the default scene's, parents before children.

    Without a default the first scene is taken, without scenes all nodes that are no one's children.
    """
    count = len(document.gltf.nodes)
    waiting = [(index, NodeTransform(), _IDENTITY) for index in reversed(_roots(document))]
    seen: set[int] = set()
    found = []
    while waiting:
        index, place, rest = waiting.pop()
        node = document.item("nodes", index)
        if index in seen:
            raise UserError(
                f"Node {index} of {document.name} is its own ancestor or has two parents: glTF's nodes must be trees, "
                "export it again."
            )
        seen.add(index)
        local, moving = _local(document, index, curves.get(index, {}))
        place, rest = place.then(local if moving is None else moving), rest @ local
        found.append(SceneNode(index, node, place, rest))
        waiting += [(child, place, rest) for child in reversed(node.children or [])]
    if not document.gltf.scenes and len(seen) < count:
        raise UserError(f"The nodes of {document.name} form a cycle: glTF's nodes must be trees, export it again.")
    return found


def _roots(document: Document) -> list[int]:
    gltf = document.gltf
    if gltf.scenes:
        return list(document.item("scenes", gltf.scene or 0).nodes or [])
    children = {child for node in gltf.nodes for child in node.children or []}
    return [index for index in range(len(gltf.nodes)) if index not in children]


def _local(
    document: Document, index: int, curves: Mapping[str, Keyframes]
) -> tuple[Matrix, Callable[[float], Matrix] | None]:
    """A node's resting matrix, and its matrix over time where it moves."""
    node = document.gltf.nodes[index]
    if node.matrix is not None:
        if curves:
            raise UserError(
                f"Node {index} of {document.name} is animated and has a matrix, which glTF forbids: export it with translation, "
                "rotation and scale."
            )
        return _numbers(document, index, "matrix", node.matrix, 16).reshape(4, 4).T, None
    rest = {
        "translation": _numbers(document, index, "translation", node.translation or [0.0] * 3, 3),
        "rotation": _numbers(document, index, "rotation", node.rotation or [0.0, 0.0, 0.0, 1.0], 4),
        "scale": _numbers(document, index, "scale", node.scale or [1.0] * 3, 3),
    }
    length = float(np.linalg.norm(rest["rotation"]))
    rest["rotation"] = rest["rotation"] / length if length > 1e-12 else np.array((0.0, 0.0, 0.0, 1.0))
    local = local_matrix(rest["translation"], rest["rotation"], rest["scale"])
    moving = {path: curve for path, curve in curves.items() if not curve.constant}
    rest |= {path: curve.at(0.0) for path, curve in curves.items() if curve.constant}
    if not moving:
        return local_matrix(rest["translation"], rest["rotation"], rest["scale"]), None
    # A moment is asked for once for every object below: the last few are kept.
    return local, lru_cache(maxsize=4)(moving_matrix(rest, moving))


def _numbers(document: Document, index: int, what: str, values: list[float], count: int) -> Vector:
    numbers = np.array([float(v) for v in values])
    if numbers.shape != (count,) or not np.isfinite(numbers).all():
        raise UserError(
            f"The {what} of node {index} of {document.name} should be {count} finite numbers, not {values}: export it again."
        )
    return numbers
