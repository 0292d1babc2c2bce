"""A voxel as a finite element: the trilinear brick with eight nodes, integrated exactly.

Its stiffness is linear in the elastic constants of its material. So a grid of voxels, each with constants of its own,
is a few matrices (24, 24), one for each `base` tensor, and as many weights a voxel. Strains are in Voigt's order (xx,
yy, zz, yz, xz, xy) with engineering shears.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: The corners of a voxel, in the order of its nodes: z is the fastest, as in an array.
CORNERS = np.array(list(itertools.product((0, 1), repeat=3)))
_POINT = 0.5 / np.sqrt(3.0)


def strains(at: Array, spacing: Array) -> Array:
    """The strains (6, 24) that unit displacements of the nodes make at a place of the voxel (0..1, three of them).

    `spacing` is the size of the voxel, mm.
    """
    sign = 2.0 * CORNERS - 1
    along = np.where(CORNERS == 1, at, 1 - at)
    slopes = np.empty((8, 3))
    for axis in range(3):
        others = [a for a in range(3) if a != axis]
        slopes[:, axis] = sign[:, axis] / spacing[axis] * along[:, others].prod(1)
    out = np.zeros((6, 8, 3))
    for axis in range(3):
        out[axis, :, axis] = slopes[:, axis]
    for row, (a, b) in enumerate(((1, 2), (0, 2), (0, 1)), start=3):
        out[row, :, a] = slopes[:, b]
        out[row, :, b] = slopes[:, a]
    return out.reshape(6, 24)


def stiffness(tensor: Array, spacing: Array) -> Array:
    """The matrix (24, 24), N/mm, of a voxel of a size (3,) mm whose material has the tensor (6, 6) MPa.

    Two points along each axis integrate it exactly.

    >>> k = stiffness(isotropic(1.0, 0.3), np.array([1.0, 1.0, 1.0]))
    >>> bool(np.allclose(k, k.T)), bool(np.allclose(k.reshape(24, 8, 3).sum(1), 0))
    (True, True)
    """
    total = np.zeros((24, 24))
    for at in itertools.product((0.5 - _POINT, 0.5 + _POINT), repeat=3):
        b = strains(np.array(at), spacing)
        total += b.T @ tensor @ b
    total *= spacing.prod() / 8
    return (total + total.T) / 2


def isotropic(young: float, poisson: float) -> Array:
    """The tensor (6, 6) of an isotropic material, in the unit of `young`.

    >>> float(np.linalg.inv(isotropic(2.0, 0.3))[0, 0])  # 1/E
    0.5
    """
    return cubic(
        young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson)),
        young * poisson / ((1 + poisson) * (1 - 2 * poisson)),
        young / (2 * (1 + poisson)),
    )


def cubic(c11: float, c12: float, c44: float) -> Array:
    """The tensor (6, 6) with the three constants of a cubic material, its axes along those of the grid."""
    out = np.zeros((6, 6))
    out[:3, :3] = c12
    out[range(3), range(3)] = c11
    out[range(3, 6), range(3, 6)] = c44
    return out


def interpolation(child: tuple[int, int, int]) -> Array:
    """What the nodes of a voxel twice as large give to those of one of its children: (8 of child, 8 of parent)."""
    place = (CORNERS + np.array(child)) / 2.0
    return np.array([[np.where(corner == 1, p, 1 - p).prod() for corner in CORNERS] for p in place])
