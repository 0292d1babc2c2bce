"""The eight-node hexahedron of a voxel, in nodal and in modal form.

A voxel of the sides h has its nodes at the corners (0 or h along x, y, z), in the order 000, 001, 010, ... 111 with z
fastest. Strains are (xx, yy, zz, yz, xz, xy) with engineering shear. Its matrices are integrated by 2 x 2 x 2 Gauss
points, which is exact for a box. In *modes* (sums and differences along each axis, a Hadamard transform) few of their
entries are left: 45 of 576 where the material is isotropic, and that is what makes the loops fast.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
#: The corners of a voxel, (8, 3), z fastest.
CORNERS = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)])
#: The axes of the shear strains: yz, xz, xy.
SHEARS = ((1, 2), (0, 2), (0, 1))
#: Entries below this share of the largest are rounding, and are zero.
_NONE = 1e-13


@dataclass(frozen=True, slots=True)
class Element:
    """What a voxel of unit density does.

    `matrix` (8 d, 8 d) gives nodal forces of nodal values (d to a node, the node first), `source` (8 d, cases) those of
    unit mean gradients, `uniform` (cases, cases) is the property itself; `rows`, `cols`, `entries` are the matrix in
    modes, the component first: what is at 8 c + m is mode m of component c.
    """

    matrix: Floats
    source: Floats
    uniform: Floats
    volume: float
    rows: NDArray[np.int64]
    cols: NDArray[np.int64]
    entries: Floats

    @property
    def parts(self) -> int:
        """Values to a node: 3 displacements, or 1 temperature."""
        return len(self.matrix) // 8


def isotropic(nu: float) -> Floats:
    """The stiffness (6, 6) of a unit Young's modulus, engineering shear.

    >>> float(1 / np.linalg.inv(isotropic(0.3))[0, 0].round(12))
    1.0
    """
    lam, mu = nu / (1 + nu) / (1 - 2 * nu), 0.5 / (1 + nu)
    out = np.diag([2 * mu] * 3 + [mu] * 3)
    out[:3, :3] += lam
    return out


def elastic(sides: Floats, stiffness: Floats) -> Element:
    """The element of a solid with a stiffness (6, 6); sides (3,) in any length, MPa and mm give N/mm.

    >>> k = elastic(np.ones(3), isotropic(0.3)).matrix
    >>> bool(np.allclose(k, k.T)), bool(np.allclose(k.reshape(24, 8, 3).sum(1), 0))
    (True, True)
    """
    return _element(sides, stiffness, _strains)


def strains(at: Floats, sides: Floats) -> Floats:
    """The strains (6, 24) that unit displacements of the nodes make at a place of the voxel, (3,) from 0 to 1."""
    return _strains(_slopes(2 * np.asarray(at) - 1, sides))


def _strains(gradient: Floats) -> Floats:
    out = np.zeros((6, 24))
    for axis in range(3):
        out[axis, axis::3] = gradient[axis]
    for row, (a, b) in enumerate(SHEARS, 3):
        out[row, a::3], out[row, b::3] = gradient[b], gradient[a]
    return out


def _slopes(at: Floats, sides: Floats) -> Floats:
    """The slopes (3, 8) of the nodes' functions at a place, (3,) from -1 to 1."""
    signs = 2 * CORNERS - 1
    shape = 1 + signs * at
    return np.stack([signs[:, a] * shape[:, (a + 1) % 3] * shape[:, (a + 2) % 3] / 4 / sides[a] for a in range(3)])


def conducting(sides: Floats) -> Element:
    """The element of a solid of unit conductivity."""
    return _element(sides, np.eye(3), lambda gradient: gradient)


def _element(sides: Floats, uniform: Floats, made: Callable[[Floats], Floats]) -> Element:
    volume = float(np.prod(sides))
    gauss = np.array([(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]) / np.sqrt(3)
    matrices, sources = [], []
    for at in gauss:
        b = made(_slopes(at, sides))
        matrices.append(b.T @ uniform @ b)
        sources.append(b.T @ uniform)
    matrix = volume * np.mean(matrices, axis=0)
    parts = len(matrix) // 8
    pair = np.array([[1.0, 1.0], [-1.0, 1.0]])
    modes = np.kron(np.kron(np.kron(pair, pair), pair) / 8, np.eye(parts))
    modal = (modes @ matrix @ modes.T).reshape(8, parts, 8, parts).transpose(1, 0, 3, 2).reshape(matrix.shape)
    rows, cols = np.nonzero(np.abs(modal) > _NONE * np.abs(modal).max())
    return Element(matrix, volume * np.mean(sources, axis=0), uniform, volume, rows, cols, modal[rows, cols])
