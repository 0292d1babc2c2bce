"""A voxel with a lattice in it as a finite element: the hexahedron of unit cells, with constants of its own.

Its stiffness is linear in the elastic constants of its material. So a grid of voxels is a few matrices (24, 24), one
for each `base` tensor, and as many weights a voxel. Strains are in Voigt's order (xx, yy, zz, yz, xz, xy) with
engineering shears.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.unitcell import hexahedron
from porelang.unitcell.hexahedron import CORNERS, strains
from porelang.unitcell.moduli import cubic_matrix as cubic

Array = NDArray[np.float64]

__all__ = ["CORNERS", "cubic", "interpolation", "isotropic", "stiffness", "strains"]


def stiffness(tensor: Array, spacing: Array) -> Array:
    """The matrix (24, 24), N/mm, of a voxel of a size (3,) mm whose material has the tensor (6, 6) MPa.

    >>> k = stiffness(isotropic(1.0, 0.3), np.array([1.0, 1.0, 1.0]))
    >>> bool(np.allclose(k, k.T)), bool(np.allclose(k.reshape(24, 8, 3).sum(1), 0))
    (True, True)
    """
    matrix = hexahedron.elastic(spacing, tensor).matrix
    return (matrix + matrix.T) / 2


def isotropic(young: float, poisson: float) -> Array:
    """The tensor (6, 6) of an isotropic material, in the unit of `young`.

    >>> round(float(np.linalg.inv(isotropic(2.0, 0.3))[0, 0]), 12)  # 1/E
    0.5
    """
    return young * hexahedron.isotropic(poisson)


def interpolation(child: tuple[int, int, int]) -> Array:
    """What the nodes of a voxel twice as large give to those of one of its children: (8 of child, 8 of parent)."""
    place = (CORNERS + np.array(child)) / 2.0
    return np.array([[np.where(corner == 1, p, 1 - p).prod() for corner in CORNERS] for p in place])
