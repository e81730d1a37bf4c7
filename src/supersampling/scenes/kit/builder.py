"""Collector of shapes: one static mesh per material, and one object for everything that moves together."""

from collections.abc import Sequence

import numpy as np

from supersampling.scenes.kit.shapes import Shape, join
from supersampling.scenes.scene import Material, Mesh, Object, Transform

Color = tuple[float, float, float]
Part = tuple[Shape, int]  # a shape and its material


class Builder:
    """Collector of shapes: they are added by material, and `build` returns meshes and objects."""

    def __init__(self) -> None:
        self.materials: list[Material] = []
        self._tiles: list[float] = []
        self._static: dict[int, list[tuple[Shape, Color]]] = {}
        self._moving: list[tuple[list[tuple[Shape, int]], Transform]] = []

    def material(self, material: Material, tile: float = 1.0) -> int:
        """Add a material whose texture covers ``tile`` metres and return its index.

        Use a tile of 1 where uv are texture coordinates already.
        """
        self.materials.append(material)
        self._tiles.append(tile)
        return len(self.materials) - 1

    def put(self, shape: Shape, material: int, color: Color = (1.0, 1.0, 1.0)) -> None:
        """Add a shape that stands still, its albedo multiplied by ``color``."""
        self._static.setdefault(material, []).append((shape, color))

    def move(self, parts: Sequence[tuple[Shape, int]], transform: Transform) -> None:
        """Add an object that moves; the shapes are in its own frame."""
        self._moving.append((list(parts), transform))

    def build(self) -> tuple[list[Mesh], list[Object]]:
        """Return all meshes and objects: the static meshes under one object, then the moving objects."""
        meshes = [self._mesh(parts, material) for material, parts in sorted(self._static.items())]
        objects = [Object(tuple(range(len(meshes))), np.eye(4, dtype=np.float32))]
        for parts, transform in self._moving:
            first = len(meshes)
            for material in sorted({m for _, m in parts}):
                meshes.append(self._mesh([(s, (1.0, 1.0, 1.0)) for s, m in parts if m == material], material))
            objects.append(Object(tuple(range(first, len(meshes))), transform))
        return meshes, objects

    def _mesh(self, parts: list[tuple[Shape, Color]], material: int) -> Mesh:
        shape = join([s for s, _ in parts])
        colors = np.concatenate([np.tile(np.asarray(c, np.float32), (len(s.positions), 1)) for s, c in parts])
        return Mesh(
            shape.positions.astype(np.float32),
            shape.normals.astype(np.float32),
            (shape.uv / self._tiles[material]).astype(np.float32),
            shape.triangles.astype(np.uint32),
            material,
            None if (colors == 1).all() else colors,
        )
