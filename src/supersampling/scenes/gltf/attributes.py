"""Attributes of a primitive's vertices, with morph targets at fixed weights (specification, section 3.7.2)."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError
from supersampling.scenes.gltf.accessors import Accessors
from supersampling.scenes.gltf.coordinates import Coordinates
from supersampling.scenes.gltf.features import Deviation
from supersampling.scenes.gltf.notes import Notes

Floats = NDArray[np.float32]
Indices = NDArray[np.int64]


class AttributeReader:
    """Reader of a primitive's ``attributes`` at the vertices ``rows`` that it uses.

    ``targets`` are pairs of a weight and the displacements by attribute. ``what`` names the primitive in messages.

    Raises:
        UserError: An attribute has another number of elements than POSITION, or positions are not finite.
    """

    def __init__(
        self,
        accessors: Accessors,
        notes: Notes,
        *,
        attributes: Mapping[str, Any],
        targets: Sequence[tuple[float, Mapping[str, Any]]],
        rows: slice | Indices,
        what: str,
    ) -> None:
        self._accessors, self._notes = accessors, notes
        self._attributes, self._targets, self._rows, self._what = attributes, targets, rows, what
        self._count = len(accessors.floats(attributes["POSITION"], 3))

    def positions(self) -> Floats:
        positions = self._displaced("POSITION", self._select("POSITION", self._attributes["POSITION"], 3))
        if not np.isfinite(positions).all():
            raise UserError(f"Some positions of {self._what} are not finite: export it again.")
        return positions

    def normals(self) -> Floats | None:
        normals = self._floats("NORMAL", 3)
        return None if normals is None else unit(normals)

    def tangents(self) -> Floats | None:
        return self._floats("TANGENT", 4)

    def uv(self, coordinates: Coordinates) -> Floats:
        uv = self._floats(f"TEXCOORD_{coordinates.number}", 2)
        if uv is not None:
            return uv
        if coordinates.textured:
            self._notes.add(Deviation.NO_COORDINATES)
        return np.zeros((len(np.arange(self._count)[self._rows]), 2), np.float32)

    def colors(self, opaque: bool) -> Floats | None:
        """Return ``(N, 3)`` or, with the opacity that an opaque material ignores, ``(N, 4)``."""
        colors = self._floats("COLOR_0", 3, 4)
        return None if colors is None else np.clip(colors[:, : 3 if opaque else 4], 0.0, 1.0)

    def skin(self) -> tuple[Indices, Floats] | None:
        """Return the joints and weights ``(N, 4 K)`` of all influences; None without any."""
        joints: list[Indices] = []
        weights: list[Floats] = []
        while (index := self._attributes.get(f"JOINTS_{len(joints)}")) is not None:
            influence = self._floats(f"WEIGHTS_{len(joints)}", 4)
            if influence is None:
                break
            name = f"JOINTS_{len(joints)}"
            joints.append(self._checked(name, self._accessors.integers(index, 4)))
            weights.append(influence)
        return (np.concatenate(joints, axis=1), np.concatenate(weights, axis=1)) if joints else None

    def _floats(self, name: str, *widths: int) -> Floats | None:
        index = self._attributes.get(name)
        if index is None:
            return None
        values = self._displaced(name, self._select(name, index, *widths))
        return finite(values, self._notes)

    def _displaced(self, name: str, values: Floats) -> Floats:
        """Return the attribute plus its weighted displacements: those of tangents have three components."""
        for weight, target in self._targets:
            if target.get(name) is not None:
                step = self._select(name, target[name], 2, 3, 4)
                width = min(step.shape[1], values.shape[1])
                values = values.copy()
                values[:, :width] += np.float32(weight) * step[:, :width]
        return values

    def _select(self, name: str, index: int, *widths: int) -> Floats:
        return self._checked(name, self._accessors.floats(index, *widths))

    def _checked(self, name: str, values: NDArray[Any]) -> NDArray[Any]:
        if len(values) != self._count:
            raise UserError(
                f"{name} of {self._what} has {len(values)} elements for {self._count} vertices: export it again."
            )
        return values[self._rows]


def finite(values: Floats, notes: Notes) -> Floats:
    """Return the values with 0 in place of those that are not finite, which is noted."""
    if np.isfinite(values).all():
        return values
    notes.add(Deviation.NOT_FINITE)
    return np.nan_to_num(values, posinf=0.0, neginf=0.0)


def unit(vectors: Floats) -> Floats:
    """Return unit vectors; a vector without length becomes up."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    up = np.array((0.0, 1.0, 0.0), np.float32)
    return np.where(length > 1e-12, vectors / np.maximum(length, 1e-12), up).astype(np.float32)
