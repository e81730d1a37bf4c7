"""Skinned meshes in their rest pose, under the joints' default transforms (specification, section 3.7.3)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Matrices = NDArray[np.float64]


class Geometry(NamedTuple):
    """Positions ``(N, 3)``, unit normals ``(N, 3)`` and tangents ``(N, 4)`` or None, and triangles ``(M, 3)``."""

    positions: Floats
    normals: Floats | None
    tangents: Floats | None
    triangles: NDArray[np.int64]


def deform(shape: Geometry, skin: tuple[NDArray[np.int64], Floats] | None, joints: Matrices) -> Geometry:
    """Return a shape under the joint matrices ``(J, 4, 4)``, mixed by the weights.

    Triangles that mirroring joints turn inside out are wound the other way. A vertex without weights follows the first
    joint. A mesh without joints and weights is returned unchanged.
    """
    if skin is None:
        return shape
    mixed = _mixed(*skin, joints)
    linear = mixed[:, :3, :3]
    placed = np.einsum("nij,nj->ni", linear, shape.positions) + mixed[:, :3, 3]
    a, b, c = linear[:, 0], linear[:, 1], linear[:, 2]
    mirrored = (a * np.cross(b, c)).sum(axis=1) < 0.0
    sign = np.where(mirrored, -1.0, 1.0)[:, None]
    normals, tangents = shape.normals, shape.tangents
    if normals is not None:
        # Cofactors are correct under non-uniform scale. Their sign is that of the determinant, as in the renderer.
        turned = np.stack([(np.cross(*pair) * normals).sum(axis=1) for pair in ((b, c), (c, a), (a, b))], axis=1)
        normals = _unit(sign * turned, normals)
    if tangents is not None:
        along = _unit(np.einsum("nij,nj->ni", linear, tangents[:, :3]), tangents[:, :3])
        tangents = np.concatenate([along, sign * tangents[:, 3:]], axis=1).astype(np.float32)
    triangles = shape.triangles.copy()
    turned_over = mirrored[triangles].sum(axis=1) >= 2
    triangles[turned_over] = triangles[turned_over, ::-1]
    return Geometry(placed.astype(np.float32), normals, tangents, triangles)


def _mixed(numbers: NDArray[np.int64], weights: Floats, joints: Matrices) -> Matrices:
    """Return the matrix ``(N, 4, 4)`` of each vertex for its joints and weights ``(N, K)``."""
    shares = np.maximum(weights.astype(np.float64), 0.0)
    if int(numbers[shares > 0.0].max(initial=0)) >= len(joints):
        raise ValueError(f"a vertex is moved by joint {int(numbers.max())} of {len(joints)}")
    total = shares.sum(axis=1, keepdims=True)
    first = np.eye(1, shares.shape[1])
    shares = np.where(total > 0.0, shares / np.maximum(total, 1e-12), first)
    # One influence at a time: all at once would take 512 bytes per vertex.
    mixed = np.zeros((len(numbers), 4, 4))
    for k in range(shares.shape[1]):
        mixed += shares[:, k, None, None] * joints[np.minimum(numbers[:, k], len(joints) - 1)]
    return mixed


def _unit(vectors: NDArray[np.float64], fallback: Floats) -> Floats:
    """Return unit vectors ``(N, 3)``, or the fallback's where a vector has no length."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(length > 1e-20, vectors / np.maximum(length, 1e-20), fallback).astype(np.float32)
