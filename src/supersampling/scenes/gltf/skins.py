"""Skinned meshes in their rest pose, under the joints' default transforms (specification, section 3.7.3)."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]


def deform(
    positions: Floats,
    normals: Floats | None,
    skin: tuple[NDArray[np.int64], Floats] | None,
    joints: NDArray[np.float64],
) -> tuple[Floats, Floats | None]:
    """Return positions ``(N, 3)`` and unit normals under the joint matrices ``(J, 4, 4)``, mixed by the weights.

    A vertex without weights follows the first joint. A mesh without joints and weights is returned unchanged.
    """
    if skin is None:
        return positions, normals
    numbers, weights = skin[0], np.maximum(np.nan_to_num(skin[1].astype(np.float64)), 0.0)
    if int(numbers[weights > 0.0].max(initial=0)) >= len(joints):
        raise ValueError(f"a vertex is moved by joint {int(numbers.max())} of {len(joints)}")
    total = weights.sum(axis=1, keepdims=True)
    weights = np.where(total > 0.0, weights / np.maximum(total, 1e-12), [1.0, 0.0, 0.0, 0.0])
    # One influence at a time: all at once would take 512 bytes per vertex.
    mixed = np.zeros((len(positions), 4, 4))
    for k in range(4):
        mixed += weights[:, k, None, None] * joints[np.minimum(numbers[:, k], len(joints) - 1)]
    placed = np.einsum("nij,nj->ni", mixed[:, :3, :3], positions) + mixed[:, :3, 3]
    if normals is None:
        return placed.astype(np.float32), None
    a, b, c = mixed[:, 0, :3], mixed[:, 1, :3], mixed[:, 2, :3]
    # Cofactors are correct under non-uniform scale. Their sign is that of the determinant, as in the renderer.
    turned = np.stack([(np.cross(*pair) * normals).sum(axis=1) for pair in ((b, c), (c, a), (a, b))], axis=1)
    turned *= np.where((a * np.cross(b, c)).sum(axis=1, keepdims=True) < 0.0, -1.0, 1.0)
    length = np.linalg.norm(turned, axis=1, keepdims=True)
    unit = np.where(length > 1e-20, turned / np.maximum(length, 1e-20), normals)
    return placed.astype(np.float32), unit.astype(np.float32)
