"""The effective properties of a periodic cell of voxels: what all of it does under a mean strain, or gradient.

Each of the six cases relaxes the cell under one unit strain; the stiffness is the energy of pairs of them,
C_ij = mean of (e_i + strain u_i) : C : (e_j + strain u_j), whose error is the square of the residual's. Elements are
conforming, so that a stiffness is never below that of the same densities on a finer grid of displacements.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.diagnostics import fail
from porelang.parallel import parallel_for, workers
from porelang.progress import tell
from porelang.unitcell.hexahedron import Element, conducting, elastic, isotropic
from porelang.unitcell.relaxing import TOLERANCE, Cell, Relaxed

Floats = NDArray[np.float64]
#: Where each strain goes as x becomes y, y becomes z and z becomes x: xx to yy, yz to xz, ...
_STRAINS, _GRADIENTS = (1, 2, 0, 4, 5, 3), (1, 2, 0)
#: Densities that differ by less than this are the same: cases are then had from each other by a rotation.
SAME = 1e-9


@dataclass(frozen=True, slots=True)
class Effective:
    """A property of a cell: `matrix` (6, 6), the stiffness in units of Young's modulus of the solid (Voigt, engineering
    shear, xx yy zz yz xz xy), or (3, 3), the conductivity in units of the solid's; `density` is the share of solid.

    `solved` are the cases that were relaxed, the others are theirs by a rotation that the densities have; `steps` and
    `residual` are the most of them.
    """

    matrix: Floats
    density: float
    solved: int
    steps: int
    residual: float


def homogenized(
    density: Any,
    cell: Sequence[float] | Floats,
    nu: float = 0.3,
    tolerance: float = TOLERANCE,
    threads: int | None = None,
) -> Effective:
    """The effective stiffness of a periodic cell of voxels.

    `density` (nx, ny, nz) is each voxel's share of solid, or its Young's modulus in units of any solid's; `cell` (3,)
    are the sides of the cell in mm (only their ratios count), `nu` Poisson's ratio of the solid. Errors: E180 for a
    cell without length or an array that is none, E183 for a ratio that no solid has, or no convergence.

    >>> import numpy as np
    >>> found = homogenized(np.ones((4, 4, 4)), (1, 1, 1), 0.25)
    >>> bool(abs(1 / np.linalg.inv(found.matrix)[0, 0] - 1) < 1e-12)
    True
    """
    values, sides = checked(density, cell)
    return _effective(values, elastic(sides, isotropic(checked_ratio(nu))), _STRAINS, sides, tolerance, threads)


def conducted(
    density: Any, cell: Sequence[float] | Floats, tolerance: float = TOLERANCE, threads: int | None = None
) -> Effective:
    """The effective conductivity (3, 3) of a periodic cell of voxels, in units of the solid's; see `homogenized`."""
    values, sides = checked(density, cell)
    return _effective(values, conducting(sides), _GRADIENTS, sides, tolerance, threads)


def _effective(
    density: Floats, element: Element, turned: tuple[int, ...], sides: Floats, tolerance: float, threads: int | None
) -> Effective:
    cases = len(turned)
    cyclic = is_cyclic(density, sides)
    asked = [0, 3][: cases // 3] if cyclic else list(range(cases))
    at = Cell(density, element)
    found: dict[int, Relaxed] = {}

    def work(case: int) -> None:
        found[case] = at.relaxed(case, tolerance)
        tell(len(found), len(asked))

    parallel_for(work, asked, min(workers(threads), len(asked)))
    moved = {case: relaxed.values for case, relaxed in found.items()}
    for case in asked if cyclic else ():
        for _ in range(2):
            moved[turned[case]] = rotated(moved[case])
            case = turned[case]
    count, mean = density.size * element.volume, float(density.mean())
    out = element.uniform * mean
    for a in range(cases):
        loads, answer = at.loads(a), at.forces(moved[a])
        for b in range(cases):
            # e_a : C : strain u_b, and strain u_b : C : (e_a + strain u_a), which is zero but for the residual
            out[a, b] += float(np.vdot(loads, moved[b])) / count
            out[b, a] += float(np.vdot(loads + answer, moved[b])) / count
    return Effective(
        (out + out.T) / 2, mean, len(asked), max(r.steps for r in found.values()),
        max(r.residual for r in found.values()),
    )  # fmt: skip


def rotated(values: Floats) -> Floats:
    """Nodal values (d, n, n, n) as they are after x became y, y became z and z became x."""
    turned = values.transpose(0, 3, 1, 2)
    return np.ascontiguousarray(turned if len(values) == 1 else turned[[2, 0, 1]])


def is_cyclic(density: Floats, sides: Floats) -> bool:
    """Whether the voxels are the same with x, y, z turned into y, z, x; measured, not assumed."""
    if len(set(density.shape)) > 1 or np.ptp(sides) > SAME * sides.max():
        return False
    return bool(np.abs(density - density.transpose(2, 0, 1)).max() <= SAME)


def checked(density: Any, cell: Sequence[float] | Floats) -> tuple[Floats, Floats]:
    """Densities (nx, ny, nz) and the sides of a voxel (3,). Errors: E180."""
    values = np.asarray(density, np.float64)
    lengths = np.asarray(cell, np.float64)
    if lengths.shape != (3,) or not (np.isfinite(lengths).all() and (lengths > 0).all()):
        raise fail(
            "E180", f"a cell of {cell!r:.60} has no volume", hint="give its sides along x, y and z in mm: 10,10,15"
        )
    if values.ndim != 3 or min(values.shape) < 2:
        raise fail("E180", f"densities have the shape {values.shape}, not (nx, ny, nz) of 2 voxels at least",
                   hint="give the share of solid of each voxel")  # fmt: skip
    if not np.isfinite(values).all() or (values < 0).any():
        raise fail("E180", "densities are numbers from 0 on", hint="give the share of solid of each voxel")
    sides = lengths / values.shape
    return values, sides / sides.max()  # so that entries are of order 1


def checked_ratio(nu: float) -> float:
    """A Poisson's ratio that a solid can have. Errors: E183."""
    if not -1 < nu < 0.5:
        why = (
            "a solid of 0.5 cannot be compressed, and displacements alone do not tell its pressure" if nu == 0.5 else ""
        )
        raise fail(
            "E183", f"{nu:g} is no Poisson's ratio of a solid", hint=f"it lies between -1 and 0.5{why and ': '}{why}"
        )
    return float(nu)
