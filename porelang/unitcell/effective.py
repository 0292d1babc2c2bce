"""The effective properties of a periodic cell of voxels: what all of it does under a mean strain, or gradient.

Each of the six cases relaxes the cell under one unit strain; the stiffness is the energy of pairs of them,
C_ij = mean of (e_i + strain u_i) : C : (e_j + strain u_j), whose error is the square of the residual's. Elements are
conforming, so that a stiffness is never below that of the same densities on a finer grid of displacements.
"""

from __future__ import annotations

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
#: What a side of a cell may be, in mm.
SHORTEST, LONGEST = 1e-6, 1e5


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
    cell: Any,
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


def conducted(density: Any, cell: Any, tolerance: float = TOLERANCE, threads: int | None = None) -> Effective:
    """The effective conductivity (3, 3) of a periodic cell of voxels, in units of the solid's; see `homogenized`."""
    values, sides = checked(density, cell)
    return _effective(values, conducting(sides), _GRADIENTS, sides, tolerance, threads)


def _effective(
    density: Floats, element: Element, cycled: tuple[int, ...], sides: Floats, tolerance: float, threads: int | None
) -> Effective:
    cases = len(cycled)
    cyclic = is_cyclic(density, sides)
    # the first normal case and the first shear, or the first gradient: the others are theirs, cycled
    asked = list(range(0, cases, 3)) if cyclic else list(range(cases))
    at = Cell(density, element)
    found: dict[int, Relaxed] = {}

    def work(case: int) -> None:
        found[case] = at.relaxed(case, tolerance)
        tell(len(found), len(asked))

    parallel_for(work, asked, min(workers(threads), len(asked)))
    moved = {case: relaxed.values for case, relaxed in found.items()}
    if cyclic:
        for case in asked:
            once = cycled[case]
            moved[once] = rotated(moved[case])
            moved[cycled[once]] = rotated(moved[once])
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


def checked_sides(cell: Any) -> Floats:
    """The sides (3,) of a cell, or of a cube by one number, in mm. Errors: E180."""
    try:
        lengths = np.array(cell, np.float64)
    except (TypeError, ValueError):
        lengths = np.zeros(0)
    lengths = np.full(3, lengths) if lengths.shape == () else lengths
    if lengths.shape != (3,) or not (np.isfinite(lengths).all() and (lengths > 0).all()):
        raise fail("E180", f"{cell!r:.60} are no sides of a cell",
                   hint="give three lengths above 0 along x, y and z in mm, or one: --cell 10,10,15")  # fmt: skip
    if lengths.min() < SHORTEST or lengths.max() > LONGEST:
        raise fail("E180", f"a cell of {' x '.join(f'{v:g}' for v in lengths)} mm is no size for a cell",
                   hint=f"its sides lie between {SHORTEST:g} and {LONGEST:g} mm")  # fmt: skip
    return lengths


def checked(density: Any, cell: Any) -> tuple[Floats, Floats]:
    """Densities (nx, ny, nz) and the sides of a voxel (3,). Errors: E180."""
    lengths = checked_sides(cell)
    hint = "give the share of solid of each voxel"
    try:
        values = np.asarray(density, np.float64)
    except (TypeError, ValueError):
        raise fail("E180", "densities are an array of numbers", hint=hint) from None
    if values.ndim != 3 or min(values.shape) < 2:
        raise fail("E180", f"densities have the shape {values.shape}, not (nx, ny, nz) of 2 voxels at least", hint=hint)
    for wrong, what in ((~np.isfinite(values), "no number"), (values < 0, "below 0")):
        if wrong.any():
            at = tuple(int(i) for i in np.argwhere(wrong)[0])
            raise fail("E180", f"the density of voxel {at} is {values[at]:g}, which is {what}", hint=hint)
    sides = lengths / values.shape
    return values, sides / sides.max()  # so that entries are of order 1


def checked_ratio(nu: Any) -> float:
    """A Poisson's ratio that a solid can have. Errors: E183."""
    try:
        ratio = float(nu)
    except (TypeError, ValueError):
        raise fail("E183", f"{nu!r:.40} is no Poisson's ratio", hint="give a number between -1 and 0.5") from None
    if not -1 < ratio < 0.5:
        why = ": at 0.5 a solid cannot be compressed, and displacements alone do not tell its pressure"
        raise fail("E183", f"{ratio:g} is no Poisson's ratio of a solid",
                   hint=f"it lies between -1 and 0.5{why if ratio == 0.5 else ''}")  # fmt: skip
    return ratio
