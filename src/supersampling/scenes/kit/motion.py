"""Periodic motions: functions from seconds to ``(4, 4)`` object-to-world matrices."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supersampling.scenes.scene import Array, Transform

Matrix = NDArray[np.float64]


def translation(offset: ArrayLike) -> Matrix:
    matrix = np.eye(4)
    matrix[:3, 3] = np.asarray(offset, float)
    return matrix


def rotation(axis: ArrayLike, angle: float) -> Matrix:
    """Return the rotation by ``angle`` radians about ``axis`` (Rodrigues)."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(np.asarray(axis, float))
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    matrix = np.eye(4)
    matrix[:3, :3] = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return matrix


def spin(origin: ArrayLike, axis: ArrayLike, hertz: float, phase: float = 0.0) -> Transform:
    """Return a steady rotation about ``axis`` through ``origin``, where the object's origin is; phase in radians."""
    place = translation(origin)

    def pose(seconds: float) -> Array:
        return (place @ rotation(axis, 2 * np.pi * hertz * seconds + phase)).astype(np.float32)

    return pose


def sway(pivot: ArrayLike, axis: ArrayLike, degrees: float, hertz: float, phase: float = 0.0) -> Transform:
    """Return a pendulum of amplitude ``degrees`` about ``axis`` through ``pivot``, where the object's origin is."""
    place, amplitude = translation(pivot), np.radians(degrees)

    def pose(seconds: float) -> Array:
        return (place @ rotation(axis, amplitude * np.sin(2 * np.pi * hertz * seconds + phase))).astype(np.float32)

    return pose


def fixed(place: Matrix) -> Transform:
    """Return a place that does not move, to be the first of a `chain`."""
    matrix = place.astype(np.float32)

    def pose(_: float) -> Array:
        return matrix

    return pose


def shuttle(a: ArrayLike, b: ArrayLike, hertz: float, phase: float = 0.0) -> Transform:
    """Return a sinusoidal travel of the object's own origin between ``a`` and ``b``."""
    start, end = np.asarray(a, float), np.asarray(b, float)

    def pose(seconds: float) -> Array:
        share = 0.5 - 0.5 * np.cos(2 * np.pi * hertz * seconds + phase)
        return translation(start + share * (end - start)).astype(np.float32)

    return pose


def chain(first: Transform, *rest: Transform) -> Transform:
    """Return a motion in which each motion runs inside the frame of the one before."""

    def pose(seconds: float) -> Array:
        matrix = first(seconds)
        for motion in rest:
            matrix = matrix @ motion(seconds)
        return matrix

    return pose
