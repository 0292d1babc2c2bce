"""Vertices where the surface crosses the edges of the grid, in float64.

Marching cubes puts each vertex on an edge of the grid, by linear interpolation. Moved along that edge to the root of
the field it stays in the cells that its triangles span, so whatever the field does the mesh folds no more than it did;
moved along the gradient it may land on the other side of a thin wedge.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.layers import Layers

Floats = NDArray[np.float64]
STEPS = 60


def crossings(points: Floats, layers: Layers, field: Callable[[Floats], Floats]) -> tuple[Floats, NDArray[np.bool_]]:
    """The points (n, 3) moved along their edges of the grid to where `field` is 0, and which have reached it.

    A point stays where it is if the root is nearer to the end of its edge than the layers' hair, or if it is on no edge
    but in a cell or in a cap.
    """
    nodes = [axis.rim[1:-1] for axis in layers.axes]  # without the void layers
    after = [np.searchsorted(n, points[:, k], side="right") for k, n in enumerate(nodes)]
    fixed = np.stack([n[np.maximum(i - 1, 0)] == p for n, i, p in zip(nodes, after, points.T, strict=True)], axis=1)
    some = np.flatnonzero(fixed.sum(axis=1) == 2)
    axis = (~fixed[some]).argmax(axis=1)
    low, high = np.zeros(len(some)), np.zeros(len(some))
    inside = np.zeros(len(some), np.bool_)
    for k, n in enumerate(nodes):
        on = np.flatnonzero(axis == k)
        i = after[k][some[on]]
        inside[on] = (i > 0) & (i < len(n))
        i = np.clip(i, 1, len(n) - 1)
        low[on], high[on] = n[i - 1] + layers.hair, n[i] - layers.hair
    inside &= low < high
    some, axis, low, high = some[inside], axis[inside], low[inside], high[inside]

    def at(where: Floats, which: NDArray[np.int64]) -> Floats:
        place = points[some[which]]
        place[np.arange(len(place)), axis[which]] = where
        return field(place)

    everything = np.arange(len(some))
    below, above = at(low, everything), at(high, everything)
    best = points[some, axis]
    reached = np.zeros(len(some), np.bool_)
    todo = np.flatnonzero((below < 0) != (above < 0))
    below, above = below[todo], above[todo]
    best[todo], _ = between(
        lambda where, which: at(where, todo[which]), low[todo], high[todo], below, above, 1e-13 * np.abs(above - below)
    )
    reached[todo] = True
    moved = points.copy()
    moved[some, axis] = best
    sure = np.zeros(len(points), np.bool_)
    sure[some] = reached
    return moved, sure


def between(
    field: Callable[[Floats, NDArray[np.int64]], Floats],
    low: Floats,
    high: Floats,
    below: Floats,
    above: Floats,
    near: Floats,
    steps: int = STEPS,
) -> tuple[Floats, NDArray[np.bool_]]:
    """Where functions of one number are 0 between `low` and `high`, where they are `below` and `above`, of two signs.

    `field(where, which)` are the values of some of them. A value of at most `near` is 0. Gives the places, and which
    have reached it within the `steps`; where a function jumps, the place is that of the jump, as near as steps allow.
    """
    best, reached = (low + high) / 2, np.zeros(len(low), np.bool_)
    todo = np.arange(len(low))
    for turn in range(steps):
        if not len(todo):
            break
        with np.errstate(all="ignore"):
            guess = low - below * (high - low) / (above - below)
        guess = np.where((turn % 3 == 2) | ~((guess > low) & (guess < high)), (low + high) / 2, guess)
        value = field(guess, todo)
        best[todo] = guess
        done = (np.abs(value) <= near) | (high - low <= 1e-14 * (1 + np.abs(high)))
        reached[todo[done]] = True
        left = (value < 0) == (below < 0)  # the end that stays counts half next time (the Illinois method)
        above = np.where(left, above / 2, value)
        below = np.where(left, value, below / 2)
        low, high = np.where(left, guess, low), np.where(left, high, guess)
        todo, near = todo[~done], near[~done]
        low, high, below, above = low[~done], high[~done], below[~done], above[~done]
    return best, reached
