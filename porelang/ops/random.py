"""Random numbers of places, the same on every backend and machine: the hash pcg4d of whole numbers.

M. Jarzynski, M. Olano, Hash Functions for GPU Rendering, Journal of Computer Graphics Techniques 9 (3), 2020. Its upper
24 bits make a number from 0 to 1 (less one part in 2^24) that float32 holds exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.interval import Interval, Mask
from porelang.ops.points import FARTHEST, places

Values = NDArray[Any]
RESULTS = ("x", "y", "z", "w")
LARGEST = 1.0 - 2.0**-24


def random(x: Any, y: Any, z: Any, seed: Any, wanted: Sequence[str] = RESULTS) -> tuple[Values, ...]:
    """The wanted results of the cell of size 1 that a place lies in (the whole numbers below its coordinates)."""
    from porelang.ops import random_loops as loops

    at, shape = places(x, y, z, seed)
    out = np.empty((len(RESULTS), at.shape[1]), at.dtype)
    loops.random(at, out)
    return tuple(out[RESULTS.index(name)].reshape(shape)[()] for name in wanted)


def enclose(*asked: Any) -> tuple[Interval, ...]:
    """The numbers themselves over boxes within a cell, 0 to 1 over others."""
    *place, wanted = asked
    one = ~_several(place)
    shape = one.shape
    inside = [np.where(one, np.broadcast_to(r.lo, shape), np.nan) for r in place]
    none: Mask = np.zeros(shape, np.bool_)
    nan: Mask = np.zeros(shape, np.bool_)
    for r in place:
        none = none | r.empty
        nan = nan | r.nan | ~(np.maximum(np.abs(r.lo), np.abs(r.hi)) < FARTHEST)
    out = []
    for values in random(inside[0], inside[1], inside[2], inside[3], wanted):
        known = ~np.isnan(values)
        lo, hi = np.where(known, values, 0.0), np.where(known, values, LARGEST)
        out.append(Interval(np.where(none, np.inf, lo), np.where(none, -np.inf, hi), nan))
    return tuple(out)


def jumps(*asked: Any) -> tuple[Mask, ...]:
    """Over which boxes each result may jump: those that reach into another cell."""
    *place, wanted = asked
    return (_several(place),) * len(wanted)


def _several(place: Sequence[Interval]) -> Mask:
    several: Mask = np.zeros(np.broadcast_shapes(*(np.shape(r.lo) for r in place)), np.bool_)
    with np.errstate(invalid="ignore"):
        for r in place:
            several = several | (np.floor(r.lo) != np.floor(r.hi))
    return several
