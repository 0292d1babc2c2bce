"""Products of the stiffness of a grid of voxels with displacements, without a matrix; transfers between grids.

Nodes are numbered as an array (nx+1, ny+1, nz+1) is; `offsets` (8,) leads from the first node of a voxel to its others.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]


@compiled
def weighted(first: Numbers, offsets: Numbers, weights: Array, bases: Array, u: Array, out: Array) -> None:
    """out (n, 3) = K u, where the voxel e has the stiffness sum of weights[e, k] bases[k]."""
    out[:] = 0.0
    local = np.empty(24)
    force = np.empty(24)
    for e in range(first.shape[0]):
        for a in range(8):
            node = first[e] + offsets[a]
            for c in range(3):
                local[3 * a + c] = u[node, c]
        force[:] = 0.0
        for k in range(bases.shape[0]):
            w = weights[e, k]
            for i in range(24):
                t = w * local[i]
                for j in range(24):
                    force[j] += bases[k, i, j] * t
        for a in range(8):
            node = first[e] + offsets[a]
            for c in range(3):
                out[node, c] += force[3 * a + c]


@compiled
def each(first: Numbers, offsets: Numbers, matrices: Array, u: Array, out: Array) -> None:
    """out (n, 3) = K u, where the voxel e has the stiffness matrices[e] (24, 24)."""
    out[:] = 0.0
    local = np.empty(24)
    force = np.empty(24)
    for e in range(first.shape[0]):
        for a in range(8):
            node = first[e] + offsets[a]
            for c in range(3):
                local[3 * a + c] = u[node, c]
        force[:] = 0.0
        for i in range(24):
            t = local[i]
            for j in range(24):
                force[j] += matrices[e, i, j] * t
        for a in range(8):
            node = first[e] + offsets[a]
            for c in range(3):
                out[node, c] += force[3 * a + c]


@compiled
def energies(first: Numbers, offsets: Numbers, bases: Array, u: Array, out: Array) -> None:
    """out[e, k] = u bases[k] u of the nodes of the voxel e."""
    local = np.empty(24)
    for e in range(first.shape[0]):
        for a in range(8):
            node = first[e] + offsets[a]
            for c in range(3):
                local[3 * a + c] = u[node, c]
        for k in range(bases.shape[0]):
            total = 0.0
            for i in range(24):
                row = 0.0
                for j in range(24):
                    row += bases[k, i, j] * local[j]
                total += row * local[i]
            out[e, k] = total


@compiled
def prolong(coarse: Array, fine: Array) -> None:
    """Interpolate (X+1, Y+1, Z+1, 3) to a grid twice as fine (2X+1, 2Y+1, 2Z+1, 3): added to what is there."""
    nx, ny, nz, _ = fine.shape
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                for a in (i // 2, (i + 1) // 2):
                    for b in (j // 2, (j + 1) // 2):
                        for c in (k // 2, (k + 1) // 2):
                            for d in range(3):
                                fine[i, j, k, d] += 0.125 * coarse[a, b, c, d]


@compiled
def restrict(fine: Array, coarse: Array) -> None:
    """The transpose of `prolong`."""
    coarse[:] = 0.0
    nx, ny, nz, _ = fine.shape
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                for a in (i // 2, (i + 1) // 2):
                    for b in (j // 2, (j + 1) // 2):
                        for c in (k // 2, (k + 1) // 2):
                            for d in range(3):
                                coarse[a, b, c, d] += 0.125 * fine[i, j, k, d]
