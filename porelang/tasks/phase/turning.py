"""A phase whose Jacobian is as near a rotation over w as can be: the local-global iteration.

Minimises the sum over cells of m |w grad(phi) - R|^2 over the phase phi (three numbers, in turns) and rotations R of
the cells (O. Sorkine, M. Alexa, As-rigid-as-possible surface modeling, SGP 2007): the rotations nearest to w grad(phi)
are found cell by cell, the phase for given rotations by a Poisson equation with the weights m w^2. Neither step can
raise the sum. Momentum (Y. Nesterov, 1983) carries it there in some 30 steps; it begins again where the sum rises, for
without that it diverges (B. O'Donoghue, E. Candes, Adaptive restart for accelerated gradient schemes, 2015).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.progress import tell
from porelang.tasks.phase.poisson import Poisson, along, poisson, pull, solve, to_cells

Values = NDArray[np.float64]
#: Steps of the iteration on one grid, and what the sum falls by in one when it is done.
STEPS = 40
DONE = 1e-5
#: Of the residual of a Poisson equation: the next step asks for another one anyway.
PRECISION = 1e-3
#: A step that would fold a cell is halved so often before it is not taken at all.
HALVINGS = 6


@dataclass(frozen=True, eq=False)
class Wanted:
    """What is asked for in the cells of a grid of nodes: `period` in mm, `weights`, and which lie `within` the part."""

    period: Values
    weights: Values
    within: NDArray[np.bool_]
    spacing: tuple[float, float, float]


def turned(wanted: Wanted, start: Values, free: bool, steps: int = STEPS) -> Values:
    """The phase (3, nx, ny, nz) at the nodes, in turns, from a `start` that has no folds; nor has what is returned.

    With `free`, cells may turn, and their mean rotation is taken out; else they keep the directions of the axes.
    """
    equation = poisson(wanted.weights * wanted.period**2, wanted.spacing)
    if not free:
        return _unfolded(wanted, start, _fitted(wanted, equation, np.eye(3)[:, :, None, None, None], start, 1e-6))
    phi, last = start, start
    rotation = rotations(_stretched(wanted, phi))
    sum_ = _sum(wanted, phi, rotation)
    speed = 1.0
    for step in range(steps):
        tell(step, steps)
        faster = (1 + math.sqrt(1 + 4 * speed * speed)) / 2
        ahead = phi + (speed - 1) / faster * (phi - last)
        new = _stepped(wanted, equation, ahead, phi)
        turn = rotations(_stretched(wanted, new))
        found = _sum(wanted, new, turn)
        if found > sum_ and speed > 1:
            faster = 1.0
            new = _stepped(wanted, equation, phi, phi)
            turn = rotations(_stretched(wanted, new))
            found = _sum(wanted, new, turn)
        if found > sum_:
            break
        fallen, last, phi, rotation, sum_, speed = sum_ - found, phi, new, turn, found, faster
        if fallen <= DONE * found:
            break
    mean = np.einsum("abxyz,xyz->ab", rotation, wanted.weights)
    u, _, v = np.linalg.svd(mean)
    back = (u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v).T
    return np.asarray(np.einsum("ab,bxyz->axyz", back, phi))


def jacobian(phi: Values, spacing: Sequence[float]) -> Values:
    """The derivative (3, 3, cells) of a phase at the nodes, of each component along each axis, the mean over cells."""
    return np.stack([to_cells(along(phi, a, spacing[a]), a) for a in range(3)], axis=1)


def determinant(matrices: Values) -> Values:
    """Of matrices (3, 3, ...)."""
    (a, b, c), (d, e, f), (g, h, i) = matrices
    return np.asarray(a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g))


def cofactors(matrices: Values) -> Values:
    """Of matrices (3, 3, ...): the inverse, transposed, times the determinant."""
    a, b, c = matrices
    return np.stack([np.cross(b, c, axis=0), np.cross(c, a, axis=0), np.cross(a, b, axis=0)])


def rotations(matrices: Values) -> Values:
    """The nearest rotations to matrices (3, 3, ...); of what is folded or nearly flat, none: the identity.

    Newton's iteration for the polar factor, with scaling (N. Higham, Computing the polar decomposition, 1986).
    """
    size = np.sqrt((matrices**2).sum((0, 1)))
    flat = ~(determinant(matrices) > 1e-6 * size**3)
    identity = np.eye(3).reshape(3, 3, *(1,) * (matrices.ndim - 2))
    found = np.where(flat, identity, matrices)
    for _ in range(30):
        other = cofactors(found) / determinant(found)
        scale = ((other**2).sum((0, 1)) / (found**2).sum((0, 1))) ** 0.25
        new = 0.5 * (scale * found + other / scale)
        moved = float(np.abs(new - found).max())
        found = new
        if moved < 1e-7:
            break
    return found


def first_fold(phi: Values, wanted: Wanted) -> tuple[int, int, int] | None:
    """A cell within the part where the phase folds at one of its corners or in the mean; None where there is none."""
    folded = wanted.within & _folds(phi, wanted.spacing)
    if not folded.any():
        return None
    i, j, k = (int(v) for v in np.argwhere(folded)[0])
    return i, j, k


def _folds(phi: Values, spacing: Sequence[float]) -> NDArray[np.bool_]:
    slopes = [along(phi, a, spacing[a]) for a in range(3)]
    folds = determinant(jacobian(phi, spacing)) <= 0
    low, high = slice(None, -1), slice(1, None)
    for corner in np.ndindex(2, 2, 2):
        side = [high if c else low for c in corner]
        at = [slopes[a][(slice(None), *(slice(None) if b == a else side[b] for b in range(3)))] for a in range(3)]
        folds |= determinant(np.stack(at, axis=1)) <= 0
    return np.asarray(folds)


def _stretched(wanted: Wanted, phi: Values) -> Values:
    return wanted.period * jacobian(phi, wanted.spacing)


def _sum(wanted: Wanted, phi: Values, rotation: Values) -> float:
    """What is minimised: over the four edges of each cell along each axis."""
    total = 0.0
    for axis in range(3):
        slope = along(phi, axis, wanted.spacing[axis])
        square, mean = to_cells(slope**2, axis), to_cells(slope, axis)
        here = wanted.period**2 * square - 2 * wanted.period * rotation[:, axis] * mean + rotation[:, axis] ** 2
        total += float((wanted.weights * here).sum())
    return total


def _stepped(wanted: Wanted, equation: Poisson, ahead: Values, phi: Values) -> Values:
    """The phase for the rotations nearest to `ahead`, as far towards it from `phi` as nothing folds."""
    turn = rotations(_stretched(wanted, ahead))
    return _unfolded(wanted, phi, _fitted(wanted, equation, turn, ahead, PRECISION))


def _fitted(wanted: Wanted, equation: Poisson, turn: Values, start: Values, precision: float) -> Values:
    gradients = [np.broadcast_to(turn[:, a], (3, *wanted.period.shape)) / wanted.period for a in range(3)]
    return solve(equation, pull(equation, gradients), start, precision)[0]


def _unfolded(wanted: Wanted, phi: Values, new: Values) -> Values:
    """As far from `phi`, which has no folds, towards `new` as there are none."""
    part = 1.0
    for _ in range(HALVINGS):
        tried = phi + part * (new - phi)
        if first_fold(tried, wanted) is None:
            return tried
        part /= 2
    return phi
