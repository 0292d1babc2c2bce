"""A phase whose Jacobian is as near a rotation over w as can be: the local-global iteration.

Minimises the sum over cells of m |w grad(phi) - R|^2 over the phase phi (three numbers, in turns) and rotations R of
the cells (O. Sorkine, M. Alexa, As-rigid-as-possible surface modeling, SGP 2007), w being one period, or one for each
axis of the cells: the rotations nearest to w grad(phi) are found cell by cell, the phase for given rotations by a
Poisson equation with the weights m w^2. Cells may keep the axes of the part (R is 1), turn freely, or stand along a
direction (the first row of R is it) or in a frame. To keep volume rather than
shape, most of the weight is on |w grad(phi) - D|^2, D being the nearest matrix of the determinant 1. Neither step can
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
from porelang.tasks.phase.frames import axes_of, beside, nearest
from porelang.tasks.phase.poisson import OUTSIDE, Poisson, along, poisson, pull, solve, to_cells

Values = NDArray[np.float64]
#: Steps of the iteration on one grid, and what the sum falls by in one when it is done.
STEPS = 40
DONE = 1e-5
#: Of the residual of a Poisson equation: the next step asks for another one anyway.
PRECISION = 1e-3
#: With `volume`, the share of the weight that shape keeps.
SHAPE = 0.2
#: A step that would fold cells is halved so often about them, and then everywhere, before it is not taken at all: the
#: iteration ends there, as if nothing were to be gained. Each time it is farther about them: where volumes are kept,
#: of a dip to a quarter of the size 6 leave them off by 604 % (95 %), 16 by 424 %, and shapes are kept with 531 %.
HALVINGS, OF_VOLUMES = 6, 16
#: Times that nodes about a fold are made the mean of those beside them, before it is looked again; and how often.
SWEEPS, ROUNDS = 8, 12
#: Cells that are made smooth where they stand along directions: with so few in the volume that is to hold one.
NEARLY = 0.1


@dataclass(frozen=True, eq=False)
class Wanted:
    """What is asked for in the cells of a grid of nodes: `period` in mm (3, cells), for each axis of the cells,
    `weights`, and which lie `within` the part.

    With `free` cells may turn; or they stand along a `direction` (3, cells), of length 1, or in a frame (6, cells);
    else they keep the axes of the part. With `volume` their shape gives way to their size.
    """

    period: Values
    weights: Values
    within: NDArray[np.bool_]
    spacing: tuple[float, float, float]
    free: bool = True
    volume: bool = False
    direction: Values | None = None


def turned(wanted: Wanted, start: Values, steps: int = STEPS) -> Values:
    """The phase (3, nx, ny, nz) at the nodes, in turns, from a `start` that has no folds; nor has what is returned,
    but for cells that stand along a direction, beyond the part.

    Of cells that may turn the mean rotation is taken out.
    """
    equations = _equations(wanted)
    if not wanted.free and wanted.direction is None and not wanted.volume:
        return _unfolded(wanted, start, _fitted(wanted, equations, np.eye(3)[:, :, None, None, None], start, 1e-6))
    if wanted.direction is not None:
        phi = _fitted(wanted, equations, axes_of(wanted.direction), start, 1e-6)
        if len(wanted.direction) == 3 or wanted.volume:
            phi = _nearer(wanted, equations, phi, steps, folding=True)
        phi = _smoothed(wanted, phi)
        if not (_folds(phi, wanted.spacing) & (wanted.weights > OUTSIDE)).any():
            return phi
    phi = _nearer(wanted, equations, start, steps)
    return phi if wanted.direction is not None or not wanted.free else _upright(wanted, phi)


def _nearer(wanted: Wanted, equations: Sequence[Poisson], start: Values, steps: int, folding: bool = False) -> Values:
    """The phase that steps from a start lead to; none of them folds cells, or with `folding` they may."""
    phi, last = start, start
    target, size = _targets(wanted, phi)
    sum_ = _sum(wanted, phi, target, size)
    speed = 1.0

    def stepped(ahead: Values) -> Values:
        new = _fitted(wanted, equations, _targets(wanted, ahead)[0], ahead, PRECISION)
        return new if folding else _unfolded(wanted, phi, new)

    for step in range(steps):
        tell(step, steps)
        faster = (1 + math.sqrt(1 + 4 * speed * speed)) / 2
        new = stepped(phi + (speed - 1) / faster * (phi - last))
        found = _sum(wanted, new, *_targets(wanted, new))
        if found > sum_ and speed > 1:
            faster = 1.0
            new = stepped(phi)
            found = _sum(wanted, new, *_targets(wanted, new))
        if found > sum_:
            break
        fallen, last, phi, sum_, speed = sum_ - found, phi, new, found, faster
        if fallen <= DONE * found:
            break
    return phi


def _upright(wanted: Wanted, phi: Values) -> Values:
    """A phase turned so that its cells are not turned on average; only where the cells' three periods are the same."""
    if np.ptp(wanted.period, axis=0).max() > 0:
        return phi
    back = mean_rotation(rotations(_stretched(wanted, phi)), wanted.weights).T
    return np.asarray(np.einsum("ab,bxyz->axyz", back, phi))


def mean_rotation(turns: Values, weights: Values) -> Values:
    """The rotation (3, 3) nearest to the mean of those of cells (3, 3, cells)."""
    u, _, v = np.linalg.svd(np.einsum("abxyz,xyz->ab", turns, weights))
    return np.asarray(u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v)


def jacobian(phi: Values, spacing: Sequence[float]) -> Values:
    """The derivative (3, 3, cells) of a phase at the nodes, of each component along each axis, the mean over cells."""
    return np.stack([to_cells(along(phi, a, spacing[a]), a) for a in range(3)], axis=1)


def determinant(matrices: Values) -> Values:
    """Of matrices (3, 3, ...)."""
    (a, b, c), (d, e, f), (g, h, i) = matrices
    return np.asarray(a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g))


def cofactors(matrices: Values) -> Values:
    """Of matrices (3, 3, ...): the inverse, transposed, times the determinant."""
    (a, b, c), (d, e, f), (g, h, i) = matrices
    out = np.empty_like(matrices)
    out[0, 0], out[0, 1], out[0, 2] = e * i - f * h, f * g - d * i, d * h - e * g
    out[1, 0], out[1, 1], out[1, 2] = c * h - b * i, a * i - c * g, b * g - a * h
    out[2, 0], out[2, 1], out[2, 2] = b * f - c * e, c * d - a * f, a * e - b * d
    return out


def rotations(matrices: Values) -> Values:
    """The nearest rotations to matrices (3, 3, ...); of what is folded or nearly flat, none: the identity.

    Newton's iteration for the polar factor, with scaling (N. Higham, Computing the polar decomposition, 1986).
    """
    from porelang.tasks.phase import loops

    out = np.empty(matrices.shape)
    loops.rotations(np.ascontiguousarray(matrices, np.float64).reshape(3, 3, -1), out.reshape(3, 3, -1))
    return out


def first_fold(phi: Values, wanted: Wanted) -> tuple[int, int, int] | None:
    """A cell within the part where the phase folds at one of its corners or in the mean; None where there is none."""
    folded = wanted.within & _folds(phi, wanted.spacing)
    if not folded.any():
        return None
    i, j, k = (int(v) for v in np.argwhere(folded)[0])
    return i, j, k


def _folds(phi: Values, spacing: Sequence[float], flat: Values | float = 0.0) -> NDArray[np.bool_]:
    """Where a phase folds at a corner of a cell or in the mean, or has no more cells in a mm3 than `flat`."""
    slopes = [along(phi, a, spacing[a]) for a in range(3)]
    folds = determinant(jacobian(phi, spacing)) <= flat
    low, high = slice(None, -1), slice(1, None)
    for corner in np.ndindex(2, 2, 2):
        side = [high if c else low for c in corner]
        at = [slopes[a][(slice(None), *(slice(None) if b == a else side[b] for b in range(3)))] for a in range(3)]
        folds |= determinant(np.stack(at, axis=1)) <= flat
    return np.asarray(folds)


def _stretched(wanted: Wanted, phi: Values) -> Values:
    return wanted.period[:, None] * jacobian(phi, wanted.spacing)


def _targets(wanted: Wanted, phi: Values) -> tuple[Values, Values | float]:
    """What w grad(phi) is to be in each cell, the nearest that is wanted to what it is, and the square of its size."""
    now = _stretched(wanted, phi)
    if wanted.direction is not None:
        turn = standing(now, wanted.direction) if len(wanted.direction) == 3 else nearest(now, wanted.direction)
    elif wanted.free:
        turn = rotations(now)
    else:
        turn = np.broadcast_to(np.eye(3)[:, :, None, None, None], now.shape)
    if not wanted.volume:
        return turn, 3.0
    full = filled(now, turn)
    return SHAPE * turn + (1 - SHAPE) * full, SHAPE * 3.0 + (1 - SHAPE) * (full**2).sum((0, 1))


def standing(matrices: Values, direction: Values) -> Values:
    """The nearest rotations to matrices (3, 3, ...) among those whose first row is a direction (3, ...)."""
    one = beside(direction)
    two = np.cross(direction, one, axis=0)
    a, b = ([(row * e).sum(0) for e in (one, two)] for row in matrices[1:])
    along, across = a[0] + b[1], a[1] - b[0]
    size = np.hypot(along, across)
    along, across = (np.where(size > 0, v / np.where(size > 0, size, 1), d) for v, d in ((along, 1.0), (across, 0.0)))
    return np.stack([direction, along * one + across * two, along * two - across * one])


def filled(matrices: Values, instead: Values) -> Values:
    """The nearest matrices of the determinant 1 to matrices (3, 3, ...), by Newton's steps onto that surface; of what
    is folded or nearly flat, others."""
    size = np.sqrt((matrices**2).sum((0, 1)))
    flat = ~(determinant(matrices) > 1e-3 * size**3)
    found = np.where(flat, instead, matrices)
    for _ in range(6):
        slope = cofactors(found)
        found = found + (1 - determinant(found)) / (slope**2).sum((0, 1)) * slope
    return np.where(determinant(found) > 0.5, found, instead)


def _sum(wanted: Wanted, phi: Values, target: Values, size: Values | float) -> float:
    """What is minimised: over the four edges of each cell along each axis; `size` is the square of the targets'."""
    total = wanted.weights * size
    for axis in range(3):
        slope = along(phi, axis, wanted.spacing[axis])
        square, mean = to_cells(slope**2, axis), to_cells(slope, axis)
        here = wanted.period**2 * square - 2 * wanted.period * target[:, axis] * mean
        total = total + wanted.weights * here.sum(0)
    return float(total.sum())


def _equations(wanted: Wanted) -> list[Poisson]:
    """One for the three components of the phase, or one for each where their periods differ."""
    same = np.ptp(wanted.period, axis=0).max() == 0
    return [poisson(wanted.weights * w**2, wanted.spacing) for w in (wanted.period[:1] if same else wanted.period)]


def _fitted(wanted: Wanted, equations: Sequence[Poisson], target: Values, start: Values, precision: float) -> Values:
    gradients = [np.broadcast_to(target[:, a], wanted.period.shape) / wanted.period for a in range(3)]
    if len(equations) == 1:
        return solve(equations[0], pull(equations[0], gradients), start, precision)[0]
    return np.concatenate(
        [solve(e, pull(e, [g[c : c + 1] for g in gradients]), start[c : c + 1], precision)[0]
         for c, e in enumerate(equations)]
    )  # fmt: skip


def _unfolded(wanted: Wanted, phi: Values, new: Values) -> Values:
    """As far from `phi`, which has no folds, towards `new` as there are none: less far about the cells that would fold,
    and if that does not do, less far everywhere."""
    part = np.ones(phi.shape[1:])
    for _ in range(OF_VOLUMES if wanted.volume else HALVINGS):
        tried = phi + part * (new - phi)
        folded = wanted.within & _folds(tried, wanted.spacing)
        if not folded.any():
            return tried
        part = np.minimum(part, np.where(_nodes_about(folded), part / 2, part))
    part = np.ones(())
    for _ in range(HALVINGS):
        part = part / 2
        tried = phi + part * (new - phi)
        if first_fold(tried, wanted) is None:
            return tried
    return phi


def _smoothed(wanted: Wanted, phi: Values) -> Values:
    """A phase made smooth about the cells that fold or are nearly flat, and about more of them as long as some do.

    A few at the rim of a part are no reason to change the others. Each of these nodes is made the mean of those beside
    it, again and again; the ends of the grid are kept.
    """
    nodes = np.zeros(phi.shape[1:], np.bool_)
    volume = wanted.period.prod(0)
    for _ in range(ROUNDS):
        folded = wanted.within & _folds(phi, wanted.spacing, NEARLY / volume)
        if not folded.any():
            break
        nodes |= _nodes_about(folded)
        nodes[[0, -1]] = nodes[:, [0, -1]] = nodes[:, :, [0, -1]] = False
        for _ in range(SWEEPS):
            mean = sum(np.roll(phi, by, axis) for axis in (1, 2, 3) for by in (1, -1)) / 6
            phi = np.where(nodes, mean, phi)
    return phi


def _nodes_about(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The nodes of cells, and those of the cells beside them."""
    wide = np.pad(cells, 2)
    for axis in range(3):
        wide = np.moveaxis(wide, axis, 0)
        wide = np.moveaxis(wide[:-3] | wide[1:-2] | wide[2:-1] | wide[3:], 0, axis)
    return wide
