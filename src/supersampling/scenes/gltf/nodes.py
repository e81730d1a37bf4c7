"""Node hierarchy: transforms of the scene's nodes, at rest and at any time (specification, section 3.5)."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError
from supersampling.scenes.gltf.animation import FARTHEST, Keyframes, Vector, local_matrix, moving_matrix
from supersampling.scenes.gltf.document import Document
from supersampling.scenes.gltf.features import Deviation
from supersampling.scenes.gltf.notes import Notes
from supersampling.scenes.scene import Array, Transform

Matrix = NDArray[np.float64]
Link: TypeAlias = "Matrix | Callable[[float], Matrix]"
_IDENTITY = np.eye(4)


@dataclass(frozen=True, eq=False)
class NodeTransform:
    """Product of matrices, either constant or functions of time, from the world inwards."""

    links: tuple[Link, ...] = ()

    @property
    def moves(self) -> bool:
        return any(callable(link) for link in self.links)

    def then(self, link: Link) -> "NodeTransform":
        """Return the transform of a child; adjacent constant matrices are multiplied."""
        if not self.links or callable(link) or callable(self.links[-1]):
            return NodeTransform((*self.links, link))
        return NodeTransform((*self.links[:-1], self.links[-1] @ link))

    def under(self, root: Matrix) -> "NodeTransform":
        """Return this transform followed by the matrix ``root`` to another world."""
        out = NodeTransform((root,))
        for link in self.links:
            out = out.then(link)
        return out

    def matrix(self, seconds: float) -> Matrix:
        """Return the matrix ``(4, 4)`` to the world."""
        out = _IDENTITY
        for link in self.links:
            out = out @ (link(seconds) if callable(link) else link)
        return out

    def scene_transform(self) -> Array | Transform:
        """Return the scene's form: a constant float32 matrix, or a function of time."""
        if not self.moves:
            return self.matrix(0.0).astype(np.float32)
        return lambda seconds: self.matrix(seconds).astype(np.float32)


@dataclass(frozen=True, eq=False)
class SceneNode:
    """Node of the scene: pygltflib's object, its transform over time, and its matrix at rest, both to the world.

    ``weights`` are those of the node's morph targets; None stands for the mesh's.
    """

    index: int
    node: Any
    transform: NodeTransform
    rest: Matrix
    weights: tuple[float, ...] | None


def scene_nodes(document: Document, curves: Mapping[int, Mapping[str, Keyframes]], notes: Notes) -> list[SceneNode]:
    """Return all nodes of the default scene, parents before children.

    Without a default, use the first scene; without scenes, start from all nodes without a parent.
    """
    if len(document.gltf.scenes) > 1 and document.gltf.scene is None:
        notes.add(Deviation.SCENES)
    count = len(document.gltf.nodes)
    waiting = [(index, NodeTransform(), _IDENTITY) for index in reversed(_roots(document))]
    seen: set[int] = set()
    nodes = []
    while waiting:
        index, transform, rest = waiting.pop()
        node = document.item("nodes", index)
        if index in seen:
            raise UserError(
                f"Node {index} of {document.name} is its own ancestor or has two parents, but nodes must form trees: "
                "export it again."
            )
        seen.add(index)
        local, moving = _local(document, index, curves.get(index, {}))
        transform, rest = transform.then(local if moving is None else moving), rest @ local
        if not np.abs(rest).max() < FARTHEST:
            raise UserError(
                f"Node {index} of {document.name} is farther than {FARTHEST:.0e} m from the origin, or as large: "
                "check its transform and those of its parents."
            )
        nodes.append(SceneNode(index, node, transform, rest, document.weights(index)))
        waiting += [(child, transform, rest) for child in reversed(node.children or [])]
    if not document.gltf.scenes and len(seen) < count:
        raise UserError(f"The nodes of {document.name} form a cycle, but nodes must form trees: export it again.")
    return nodes


def _roots(document: Document) -> list[int]:
    gltf = document.gltf
    if gltf.scenes:
        return list(document.item("scenes", gltf.scene or 0).nodes or [])
    children = {child for node in gltf.nodes for child in node.children or []}
    return [index for index in range(len(gltf.nodes)) if index not in children]


def _local(
    document: Document, index: int, curves: Mapping[str, Keyframes]
) -> tuple[Matrix, Callable[[float], Matrix] | None]:
    """Return a node's matrix at rest, and its matrix as a function of time or None if it does not move."""
    node = document.gltf.nodes[index]
    if node.matrix is not None:
        if curves:
            raise UserError(
                f"Node {index} of {document.name} is animated and has a matrix, which glTF forbids: "
                "export it with translation, rotation and scale."
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
    rest |= {path: curve.value(0.0) for path, curve in curves.items() if curve.constant}
    if not moving:
        return local_matrix(rest["translation"], rest["rotation"], rest["scale"]), None
    # Every object below evaluates the same instants: cache the last few.
    return local, lru_cache(maxsize=4)(moving_matrix(rest, moving))


def _numbers(document: Document, index: int, what: str, values: list[float], count: int) -> Vector:
    numbers = np.array([float(v) for v in values])
    if numbers.shape != (count,) or not (np.abs(numbers) < FARTHEST).all():
        raise UserError(
            f"Invalid {what} {values} of node {index} of {document.name}: use {count} numbers below {FARTHEST:.0e}."
        )
    return numbers
