"""Which share of a part's volume lies below a value, and the value that a share stays below: of fields that are linear
in each tetrahedron, exactly."""

from __future__ import annotations

import numpy as np

from porelang.fea.problem import Floats, Ints

#: Halvings of the range of values: the last is below what float64 tells apart.
_HALVINGS = 60


def share_below(values: Floats, level: float) -> Floats:
    """The shares (m,) of tetrahedra in which what is linear between values (m, 4) at their corners is below a level.

    A plane cuts a tetrahedron into a smaller one and the rest, or into two wedges, each of three tetrahedra whose
    volumes are products of where the plane cuts edges.

    >>> share_below(np.array([[0.0, 1.0, 1.0, 1.0], [0.0, 0.0, 1.0, 1.0]]), 0.5)
    array([0.125, 0.5  ])
    """
    v0, v1, v2, v3 = np.sort(values, axis=1).T
    with np.errstate(all="ignore"):
        below = (level - v0) ** 3 / ((v1 - v0) * (v2 - v0) * (v3 - v0))
        above = 1 - (v3 - level) ** 3 / ((v3 - v0) * (v3 - v1) * (v3 - v2))
        a, b, c, d = ((level - p) / (q - p) for p, q in ((v0, v2), (v0, v3), (v1, v2), (v1, v3)))
        wedge = a * b + a * (1 - b) * d + (1 - a) * c * d
    return np.select([level <= v0, level < v1, level < v2, level < v3], [np.zeros_like(v0), below, wedge, above], 1.0)


def percentile(values: Floats, corners: Ints, volumes: Floats, share: float) -> float:
    """The value that `share` per cent of the volume stay below, of values (n,) that are linear between the corners
    (m, 4) of tetrahedra with volumes (m,)."""
    at, volume = values[corners], volumes
    wanted = share / 100 * float(volume.sum())
    low, high = float(at.min()), float(at.max())
    known = 0.0  # the volume of those that lie below `low` as a whole
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        if not low < middle < high:
            break
        if known + float(share_below(at, middle) @ volume) < wanted:
            low = middle
        else:
            high = middle
        under = at.max(axis=1) <= low
        known += float(volume[under].sum())
        open_ = ~under & (at.min(axis=1) < high)
        at, volume = at[open_], volume[open_]
    return (low + high) / 2
