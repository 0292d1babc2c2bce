"""Conjugate gradients with a multigrid cycle, for elasticity on a grid of voxels.

Only the finest grid is without a matrix. Coarser ones are Galerkin's: the stiffness of a voxel twice as large is what
its eight children have in its trilinear displacements, so that voids, supports and densities are seen exactly, at 576
bytes a voxel of the finest grid. Smoothing is Chebyshev's polynomial of Jacobi's; the coarsest grid is factorised.
Decision 0019 has the measurements, beside algebraic multigrid.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from porelang.diagnostics import fail
from porelang.optimize import element, loops
from porelang.progress import checkpoint

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
Flags = NDArray[np.bool_]
#: Displacements of a grid with at most so many are solved for directly.
DIRECT = 1500
#: Chebyshev's polynomial smooths this upper part of the spectrum of D^-1 K (Adams et al., J. Comput. Phys. 188, 2003).
_SMOOTHED = 1 / 8
#: Steps of the power method, and by how much what they find is widened.
_POWER, _WIDER = 12, 1.1
MOST_ITERATIONS = 500


@dataclass(frozen=True, eq=False)
class Level:
    """One grid: how its stiffness acts on (nodes, 3), 1/diagonal (0 where nothing moves), largest eigenvalue."""

    cells: tuple[int, int, int]
    apply: Callable[[Array, Array], None]
    inverse: Array
    largest: float


@dataclass(frozen=True, eq=False)
class Cycle:
    """All grids, from fine to coarse, and the factors of the coarsest. `solve` is what it is for."""

    levels: tuple[Level, ...]
    direct: Any

    def correction(self, residual: Array, depth: int = 0) -> Array:
        """Roughly K^-1 of a residual (nodes, 3): symmetric and positive definite."""
        level = self.levels[depth]
        if depth == len(self.levels) - 1:
            solved: Array = self.direct.solve(residual.ravel()).reshape(-1, 3)
            return solved
        u = _smooth(level, residual, None)
        work = np.empty_like(u)
        level.apply(u, work)
        below = self.levels[depth + 1]
        shape, coarse_shape = _nodes(level.cells), _nodes(below.cells)
        coarse = np.empty((*coarse_shape, 3))
        left = (residual - work) * (level.inverse > 0)
        loops.restrict(left.reshape(*shape, 3), coarse)
        got = self.correction(coarse.reshape(-1, 3), depth + 1)
        loops.prolong(np.ascontiguousarray(got).reshape(*coarse_shape, 3), u.reshape(*shape, 3))
        u *= level.inverse > 0
        return _smooth(level, residual, u)


@dataclass(frozen=True, slots=True)
class Solved:
    """Displacements (nodes, 3) mm, with what is left of the forces, relative to them, and after how many steps."""

    u: Array
    residual: float
    iterations: int


def solve(cycle: Cycle, forces: Array, start: Array | None, tolerance: float) -> Solved:
    """K u = forces, from a `start` (nodes, 3) if there is one. Errors: E194 where it does not converge."""
    fine = cycle.levels[0]
    free = fine.inverse > 0
    forces = forces * free
    size = _size(forces)
    u = np.zeros_like(forces) if start is None else start * free
    if size == 0:
        return Solved(np.zeros_like(forces), 0.0, 0)
    product = np.empty_like(u)
    fine.apply(u, product)
    residual = (forces - product) * free
    direction: Array | None = None
    before = 1.0
    for count in range(MOST_ITERATIONS + 1):
        left = _size(residual) / size
        if left <= tolerance:
            return Solved(u, left, count)
        if not np.isfinite(left):
            break
        checkpoint()
        better = cycle.correction(residual)
        rho = _dot(residual, better)
        direction = better if direction is None else better + rho / before * direction
        before = rho
        fine.apply(direction, product)
        product *= free
        step = rho / _dot(direction, product)
        u += step * direction
        residual -= step * product
    raise fail("E194", f"the displacements of the voxels are not found: after {count} steps {left:.1e} of the forces "
               f"are unbalanced, where {tolerance:.0e} was asked for",
               hint="voxels that meet in an edge are hinges: use a smaller voxel, or a wider support")  # fmt: skip


def cycle(
    cells: tuple[int, int, int], index: Numbers, weights: Array, bases: Array, fixed: Flags
) -> tuple[Cycle, tuple[int, int, int]]:
    """The grids for voxels at `index` (m, 3) with stiffnesses sum_k weights[m, k] bases[k] (24, 24), in N/mm.

    `fixed` (nodes, 3) are displacements that are none. `cells` must be divisible as `padded` makes it.
    """
    depth = halvings(cells)
    first, offsets = numbering(cells, index)
    corners = first[:, None] + offsets
    diagonal = np.zeros_like(fixed, float)
    own = weights @ np.array([np.diag(b) for b in bases])
    for a in range(8):
        for c in range(3):
            np.add.at(diagonal[:, c], corners[:, a], own[:, 3 * a + c])
    diagonal[fixed] = 0

    def fine(u: Array, out: Array) -> None:
        loops.weighted(first, offsets, weights, bases, u, out)

    levels = [_level(cells, fine, diagonal)]
    matrices: Array | None = None
    for _ in range(depth):
        if matrices is None:
            index, matrices = _coarse_of_bases(index, weights, bases, fixed[corners].reshape(-1, 24))
        else:
            index, matrices = _coarse(index, matrices)
        nx, ny, nz = cells
        cells = (nx // 2, ny // 2, nz // 2)
        levels.append(_matrix_level(cells, index, matrices))
    if matrices is None:
        local = fixed[corners].reshape(-1, 24)
        matrices = np.tensordot(weights, bases, 1) * ~local[:, :, None] * ~local[:, None, :]
    return Cycle(tuple(levels), _factors(cells, index, matrices)), cells


def _level(cells: tuple[int, int, int], apply: Callable[[Array, Array], None], diagonal: Array) -> Level:
    alive = diagonal > 1e-12 * diagonal.max()
    inverse = np.zeros_like(diagonal)
    inverse[alive] = 1 / diagonal[alive]
    u = np.random.default_rng(1).standard_normal(diagonal.shape) * alive
    out = np.empty_like(u)
    size = 1.0
    for _ in range(_POWER):
        apply(u, out)
        out *= inverse
        size = _size(out) / _size(u)
        u = out / _size(out)
    return Level(cells, apply, inverse, _WIDER * size)


def _matrix_level(cells: tuple[int, int, int], index: Numbers, matrices: Array) -> Level:
    first, offsets = numbering(cells, index)
    diagonal = np.zeros((int(np.prod(_nodes(cells))), 3))
    own = np.diagonal(matrices, axis1=1, axis2=2)
    for a in range(8):
        for c in range(3):
            np.add.at(diagonal[:, c], first + offsets[a], own[:, 3 * a + c])

    def apply(u: Array, out: Array) -> None:
        loops.each(first, offsets, matrices, u, out)

    return _level(cells, apply, diagonal)


def _smooth(level: Level, forces: Array, u: Array | None) -> Array:
    """Two steps of Chebyshev's iteration with Jacobi's, from `u` (None is 0)."""
    high, low = level.largest, _SMOOTHED * level.largest
    middle, half = (high + low) / 2, (high - low) / 2
    work = np.empty_like(forces)
    if u is None:
        step = level.inverse * forces / middle
        u = step.copy()
    else:
        level.apply(u, work)
        step = level.inverse * (forces - work) / middle
        u = u + step
    ratio = half / middle
    following = 1 / (2 / ratio - ratio)
    level.apply(u, work)
    u += following * ratio * step + 2 * following / half * (level.inverse * (forces - work))
    return u


def _dot(a: Array, b: Array) -> float:
    """A sum that no thread of a library takes part in: the same on every run, and quicker where cores are busy."""
    return float((a * b).sum())


def _size(a: Array) -> float:
    return float(np.sqrt(_dot(a, a)))


def _nodes(cells: tuple[int, int, int]) -> tuple[int, int, int]:
    nx, ny, nz = cells
    return nx + 1, ny + 1, nz + 1


def numbering(cells: tuple[int, int, int], index: Numbers) -> tuple[Numbers, Numbers]:
    """The number of the first node of each voxel (m,), and what leads from it to its eight (8,)."""
    _, ny, nz = _nodes(cells)
    stride = np.array([ny * nz, nz, 1])
    return np.ascontiguousarray(index @ stride), element.CORNERS @ stride


def halvings(cells: tuple[int, int, int]) -> int:
    """How often a grid is coarsened until it is solved directly."""
    for depth in range(12):
        if 3 * np.prod([-(-n // 2**depth) + 1 for n in cells]) <= DIRECT:
            return depth
    return 12


def padded(cells: tuple[int, int, int]) -> tuple[int, int, int]:
    """The least grid with room for these cells that can be halved as often as it has to be."""
    depth = halvings(cells)
    nx, ny, nz = (-(-n // 2**depth) * 2**depth for n in cells)
    return nx, ny, nz


_INTERPOLATIONS = [np.kron(element.interpolation((int(a), int(b), int(c))), np.eye(3)) for a, b, c in element.CORNERS]


def _parents(index: Numbers) -> tuple[Numbers, Numbers, Numbers]:
    """The voxels twice as large (n, 3), which of them each voxel lies in (m,), and which of eight it is there (m,)."""
    parents, which = np.unique(index // 2, axis=0, return_inverse=True)
    return parents, which.reshape(-1), (index % 2) @ np.array([4, 2, 1])


def _coarse_of_bases(index: Numbers, weights: Array, bases: Array, fixed: Flags) -> tuple[Numbers, Array]:
    parents, which, child = _parents(index)
    kinds = len(bases)
    loose = ~fixed.any(1)
    table = np.zeros((len(parents), 8, kinds))
    table[which[loose], child[loose]] = weights[loose]
    carried = np.array([[(p.T @ b @ p).ravel() for b in bases] for p in _INTERPOLATIONS])
    matrices = (table.reshape(len(parents), -1) @ carried.reshape(-1, 576)).reshape(-1, 24, 24)
    for c, p in enumerate(_INTERPOLATIONS):
        held = ~loose & (child == c)
        if held.any():
            own = np.tensordot(weights[held], bases, 1) * ~fixed[held][:, :, None] * ~fixed[held][:, None, :]
            matrices[which[held]] += p.T @ own @ p
    return parents, matrices


def _coarse(index: Numbers, matrices: Array) -> tuple[Numbers, Array]:
    parents, which, child = _parents(index)
    out = np.zeros((len(parents), 24, 24))
    for c, p in enumerate(_INTERPOLATIONS):
        one = child == c
        out[which[one]] += p.T @ matrices[one] @ p
    return parents, out


def _factors(cells: tuple[int, int, int], index: Numbers, matrices: Array) -> Any:
    first, offsets = numbering(cells, index)
    dofs = (3 * (first[:, None] + offsets)[:, :, None] + np.arange(3)).reshape(-1, 24)
    rows, columns = np.repeat(dofs, 24, 1).ravel(), np.tile(dofs, (1, 24)).ravel()
    n = 3 * int(np.prod(_nodes(cells)))
    whole = csc_matrix((matrices.ravel(), (rows, columns)), shape=(n, n))
    diagonal = whole.diagonal()
    idle = diagonal <= 1e-12 * diagonal.max()
    return splu((whole + csc_matrix((np.where(idle, diagonal.max(), 0), (range(n), range(n))), shape=(n, n))).tocsc())
