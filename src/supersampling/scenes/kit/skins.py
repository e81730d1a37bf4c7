"""Smooth surfaces through grids of points, and the closed outlines that they are built on."""

import numpy as np

from supersampling.scenes.kit.shapes import Floats, Shape, grid


def skin(points: Floats, uv: Floats) -> Shape:
    """Return the smooth surface through ``points (R, C, 3)``, rows down and columns right as seen from outside."""
    down, right = np.gradient(points, axis=0), np.gradient(points, axis=1)
    normal = np.cross(right, -down)
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    return grid(points, normal / np.maximum(length, 1e-12), uv)


def outline(a: float, b: float, count: int = 96, power: float = 0.72) -> Floats:
    """Return a superellipse ``(count, 2)`` of half axes ``a`` (x) and ``b`` (z), from +x towards -z."""
    t = np.arange(count) / count * 2 * np.pi
    c, s = np.cos(t), -np.sin(t)
    return np.stack([a * np.sign(c) * np.abs(c) ** power, b * np.sign(s) * np.abs(s) ** power], 1)
