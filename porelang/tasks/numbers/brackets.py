"""Where pieces of lines change sides, to the rounding of their coordinates: the last points inside.

Chandrupatla's method: a step of inverse quadratic interpolation where the last three values say that it is safe, else
halving; no step is shorter than what is left at the end, so that one more closes a piece from its other side.

T. R. Chandrupatla, A new hybrid quadratic/bisection algorithm for finding the zero of a nonlinear function without
using derivatives, Advances in Engineering Software 28 (1997).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.bounds import Points
from porelang.backends.numpy import NumpyField

_CLOSE = 2.0**-40  # of a piece
_ROUNDS = 60
_HALVED = 12  # rounds, from which on every third halves: no field takes more than `_ROUNDS`


def last_inside(field: NumpyField, low: Points, high: Points, inside: NDArray[np.bool_]) -> Points:
    """The crossing of each piece from `low` to `high` (n, 3), one end of which is inside, the low one if `inside`: the
    last point inside, for beyond it the field may be level.

    A wall may be a billionth of a piece thick, and all lines may see it at the same place: what is left of a piece
    would be an error that no spread shows.
    """
    out = np.where(inside[:, None], low, high)
    if not len(low):
        return out
    rows = np.arange(len(low))
    start, along = low, high - low
    new, far = np.zeros(len(low)), np.ones(len(low))  # the newest place along each piece, and one on the other side
    f_new, f_far = field.at(low), field.at(high)
    in_new = inside
    step = np.full(len(low), 0.5)
    for round_ in range(_ROUNDS):
        if not len(rows):
            break
        at = new + step * (far - new)
        value = field.at(start + at[:, None] * along)
        in_at = value < 0
        same = in_at == in_new
        old, f_old = np.where(same, new, far), np.where(same, f_new, f_far)
        far, f_far = np.where(same, far, new), np.where(same, f_far, f_new)
        new, f_new, in_new = at, value, in_at
        width = np.abs(far - new)
        open_ = width > _CLOSE
        done = ~open_ if round_ + 1 < _ROUNDS else np.ones(len(rows), np.bool_)
        inner = np.where(in_new, new, far)[done]
        out[rows[done]] = start[done] + inner[:, None] * along[done]
        rows, start, along, in_new = rows[open_], start[open_], along[open_], in_new[open_]
        new, far, old, width = new[open_], far[open_], old[open_], width[open_]
        f_new, f_far, f_old = f_new[open_], f_far[open_], f_old[open_]
        step = np.full(len(rows), 0.5)
        if round_ < _HALVED or round_ % 3:
            with np.errstate(all="ignore"):
                ratio, share = (new - far) / (old - far), (f_new - f_far) / (f_old - f_far)
                quick = (share**2 < ratio) & ((1 - share) ** 2 < 1 - ratio)
                guess = f_new / (f_far - f_new) * f_old / (f_far - f_old) + (old - new) / (far - new) * f_new / (
                    f_old - f_new
                ) * f_far / (f_old - f_far)
                least = np.minimum(0.5, 0.5 * _CLOSE / width)
                step = np.where(quick & np.isfinite(guess), np.clip(guess, least, 1 - least), 0.5)
    return out
