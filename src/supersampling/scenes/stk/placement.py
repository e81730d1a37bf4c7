"""Placement of objects: position, rotation and scale, and their composition along a tree of nodes.

SuperTuxKart (Irrlicht) is left-handed with y up; scenes are right-handed with y up. ``MIRROR`` (z to -z, S) converts
between them: points ``S p``, matrices ``S M S``.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from supersampling.scenes.scene import Array, Transform
from supersampling.scenes.stk.curves import Curve, read_curves
from supersampling.scenes.stk.numbers import attribute, number

Matrix = NDArray[np.float64]
Triple = tuple[float, float, float]
MIRROR = np.diag([1.0, 1.0, -1.0, 1.0])


def triple(text: str | None, default: Triple) -> Triple:
    """Return the three numbers of an attribute, or ``default`` if it is missing or not a triple."""
    parts = (text or "").split()
    return (number(parts[0]), number(parts[1]), number(parts[2])) if len(parts) == 3 else default


def rotation(axis: int, degrees: float) -> Matrix:
    """Return the rotation ``(3, 3)`` about the axis x, y or z (0, 1, 2): right-hand rule, column vectors."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    out = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out[i, i], out[i, j], out[j, i], out[j, j] = c, -s, s, c
    return out


@dataclass(frozen=True)
class Placement:
    """Placement of a node under its parent, in SuperTuxKart's space; ``degrees`` about x, y, z."""

    position: Triple = (0.0, 0.0, 0.0)
    degrees: Triple = (0.0, 0.0, 0.0)
    scale: Triple = (1.0, 1.0, 1.0)
    curves: Mapping[str, Curve] = field(default_factory=dict)

    def matrix(self, seconds: float = 0.0) -> Matrix:
        """Return the matrix ``(4, 4)``.

        Static nodes rotate about x, then y, then z; animated ones about x, then z, then y.
        """
        position = self._channel("Loc", self.position, seconds)
        x, y, z = (rotation(k, a) for k, a in enumerate(self._channel("Rot", self.degrees, seconds)))
        out = np.eye(4)
        # src/animations/three_d_animation.cpp: Blender's order of rotations for animated objects.
        out[:3, :3] = (y @ z @ x if self.curves else z @ y @ x) * self._channel("Scale", self.scale, seconds)
        out[:3, 3] = position
        return out

    def _channel(self, name: str, still: Triple, seconds: float) -> Matrix:
        values = [
            self.curves[name + axis].value(seconds) if name + axis in self.curves else value
            for axis, value in zip("XYZ", still)
        ]
        return np.array(values)


def read_placement(element: Element) -> Placement:
    """Return the placement and curves of a scene node; the old syntax ``x y z h`` is also read."""
    position = (attribute(element, "x", 0.0), attribute(element, "y", 0.0), attribute(element, "z", 0.0))
    return Placement(
        position=triple(element.get("xyz"), position),
        degrees=triple(element.get("hpr"), (0.0, attribute(element, "h", 0.0), 0.0)),
        scale=triple(element.get("scale"), (1.0, 1.0, 1.0)),
        curves=read_curves(element),
    )


def world_transform(chain: tuple[Placement, ...]) -> Array | Transform:
    """Return the right-handed object-to-world matrix of a chain's last node: constant unless a node moves."""

    def matrix(seconds: float) -> Array:
        out = MIRROR
        for placement in chain:
            out = out @ placement.matrix(seconds)
        return (out @ MIRROR).astype(np.float32)

    return matrix if any(placement.curves for placement in chain) else matrix(0.0)
