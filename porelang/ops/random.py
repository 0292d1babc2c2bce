"""Random numbers of places, the same on every backend and machine: the hash pcg4d of whole numbers.

M. Jarzynski, M. Olano, Hash Functions for GPU Rendering, Journal of Computer Graphics Techniques 9 (3), 2020. Its upper 24
bits make a number of 0 to 1, less one part in 2^24, which float32 holds exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.interval import Array, Interval, Mask
from porelang.ops.points import places

Values = NDArray[Any]
RESULTS = ("x", "y", "z", "w")
#: Beyond this cells are not told apart by float32 any more: there are no random numbers.
FARTHEST = 2.0**23
LARGEST = 1.0 - 2.0**-24


def random(x: Any, y: Any, z: Any, seed: Any, wanted: Sequence[str] = RESULTS) -> tuple[Values, ...]:
    """The wanted results of the cell of size 1 that a place lies in (the whole numbers below its coordinates)."""
    from porelang.ops import random_loops as loops

    at, shape = places(x, y, z, seed)
    out = np.empty((len(RESULTS), at.shape[1]), at.dtype)
    loops.random(at, at.dtype.type(FARTHEST), out)
    return tuple(out[RESULTS.index(name)].reshape(shape)[()] for name in wanted)


def enclose(x: Interval, y: Interval, z: Interval, seed: Interval, wanted: Sequence[str] = RESULTS) -> tuple[Interval, ...]:
    """The numbers themselves over boxes within a cell, 0 to 1 over others."""
    with np.errstate(all="ignore"):
        one = ~jumping(x, y, z, seed)
        inside = [np.where(one, r.lo, np.nan) for r in (x, y, z, seed)]
        found = random(*(v.astype(np.float64) for v in inside), wanted)
    shape = np.shape(found[0])
    none = np.broadcast_to(x.empty | y.empty | z.empty | seed.empty, shape)
    nan = np.broadcast_to(_nowhere(x, y, z, seed), shape)
    out = []
    for values in found:
        known = one & ~np.isnan(values)
        lo, hi = np.where(known, values, 0.0), np.where(known, values, LARGEST)
        out.append(Interval(np.where(none, np.inf, lo), np.where(none, -np.inf, hi), nan))
    return tuple(out)


def jumps(x: Interval, y: Interval, z: Interval, seed: Interval, wanted: Sequence[str] = RESULTS) -> tuple[Mask, ...]:
    """Over which boxes each result may jump: those of several cells."""
    return (jumping(x, y, z, seed),) * len(wanted)


def jumping(*place: Interval) -> Mask:
    """Which boxes reach over the border of a cell."""
    several: Mask = np.zeros(np.broadcast_shapes(*(np.shape(r.lo) for r in place)), np.bool_)
    for r in place:
        several = several | (np.floor(r.lo) != np.floor(r.hi))
    return several


def _nowhere(*place: Interval) -> Mask:
    """Which boxes hold places that no float32 tells apart from their neighbours, or none at all."""
    nowhere: Mask = np.zeros(np.broadcast_shapes(*(np.shape(r.lo) for r in place)), np.bool_)
    for r in place:
        nowhere = nowhere | r.nan | ~(np.maximum(np.abs(r.lo), np.abs(r.hi)) < FARTHEST)
    return nowhere


def rounding(x: Interval, y: Interval, z: Interval, seed: Interval, wanted: Sequence[str] = RESULTS) -> tuple[Array, ...]:
    """Nothing is rounded."""
    return (np.zeros(np.broadcast_shapes(*(np.shape(r.lo) for r in (x, y, z, seed)))),) * len(wanted)
