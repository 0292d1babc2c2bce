"""Bars of a cell that is repeated without end: which copies of them count near the cell, and how places come to it.

A place is moved by whole periods into the cell about the origin. There the nearest bar is one of those that are kept:
all that may be nearest in the cell or up to a quarter of a period beyond it, so that a box about any place of the cell,
as wide as that, is bounded without a break at the cell's faces; and those up to the bars' `reach` farther away.
"""

from __future__ import annotations

from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from porelang.data import Segments
from porelang.interval import Array, Mask
from porelang.ops.derived import derived
from porelang.ops.segment_tree import limits_of, tree, walked

Values = NDArray[Any]
#: How far beyond the cell the copies go on, in periods.
MARGIN = 0.25
#: Bars are one where they differ by less than this, in periods.
_SAME = 2.0**-20
#: Cubes in the least period in which bars are looked for, places along each side of the cell from which its widest
#: void is found, and the bars that a cube may have before all of them are kept.
_CUBES, _PLACES, _MOST = 4, 16, 1024


class Copies(NamedTuple):
    """The bars that count near the cell, without a period, and of each which bar of the cell it is (n,), in the order
    of these: what ties is found as in the cell. No place is farther from a surface than `covering`."""

    bars: Segments
    of: NDArray[np.int32]
    covering: float


def copies(bars: Segments) -> Copies:
    """The copies of periodic bars, made once. Errors: ValueError where there is no bar."""
    return derived(bars, "copies", lambda: _make(bars))


def held(bars: Segments) -> Segments:
    """The bars that are walked through: those themselves, or the copies that count."""
    return bars if bars.period is None else copies(bars).bars


def folded(v: Any, period: float) -> Values:
    """Coordinates moved by whole periods to within half a period of 0, in their type; what is infinite stays so."""
    at = np.asarray(v)
    kind = at.dtype.type if at.dtype in (np.float32, np.float64) else np.float64
    at = at.astype(kind, copy=False)
    with np.errstate(all="ignore"):
        moved = at - np.rint(at * kind(1 / period)) * kind(period)
    return np.where(np.isnan(moved), at, moved)


def folded_boxes(bars: Segments, lo: Array, hi: Array) -> tuple[Array, Array, Mask]:
    """Boxes (3, n) moved by whole periods to about the cell, and which are wider than the copies go on."""
    period = np.array(bars.period)[:, None]
    with np.errstate(all="ignore"):
        moved = np.rint((lo / 2 + hi / 2) / period) * period
        wide = np.any(~((hi - lo) / 2 <= MARGIN * period), axis=0)
        moved = np.where(np.isfinite(moved), moved, 0.0)
    return lo - moved, hi - moved, wide


def own_numbers(bars: Segments, index: Values) -> Values:
    """The numbers of copies as those of the bars of the cell, in their type; NaN stays NaN."""
    known = np.isfinite(index)
    return np.where(known, copies(bars).of[np.where(known, index, 0).astype(np.int64)], index).astype(index.dtype)


def roundings(bars: Segments, *sizes: Array) -> Array:
    """What folding coordinates of such magnitudes may do to a place, in mm and units of the type's epsilon.

    The period is rounded by e/2 of itself, and so is its multiple, at most |x| + w/2; what is left is exact but where
    it is the period that rounding has made longer: together e (|x| + w) along an axis.
    """
    assert bars.period is not None
    total: Array = np.asarray(sum(bars.period))
    for size in sizes:
        total = total + size
    return total


def _make(bars: Segments) -> Copies:
    from porelang.ops import segment_ranges as loops

    if len(bars) == 0:
        raise ValueError("there is no bar")
    period = np.array(bars.period)
    own = _different(bars, period)
    starts, ends, radii = bars.starts[own], bars.ends[own], bars.radii[own]
    moved = np.rint((starts + ends) / 2 / period) * period
    starts, ends = starts - moved, ends - moved
    # no place is farther from a bar's middle than half a diagonal: who is farther than that from all is never nearest
    farthest = np.linalg.norm(period) / 2 + np.ptp(radii) + bars.reach
    most = np.floor(((0.5 + MARGIN) * period + farthest + np.abs(ends - starts).max(0) / 2) / period + 0.5).astype(int)
    shifts = np.array(list(product(*(range(-m, m + 1) for m in most)))) * period
    numbers = np.repeat(own, len(shifts))
    every = np.tile(shifts, (len(own), 1))
    starts, ends = np.repeat(starts, len(shifts), axis=0) + every, np.repeat(ends, len(shifts), axis=0) + every
    all_ = Segments(starts, ends, np.repeat(radii, len(shifts)))
    size = period.min() / _CUBES
    parts = [(np.arange(n) + 0.5) * size - n * size / 2 for n in np.ceil((1 + 2 * MARGIN) * period / size).astype(int)]
    centres = np.stack(np.meshgrid(*parts, indexing="ij"), -1).reshape(-1, 3)
    (index,) = walked(all_, centres[:, 0], centres[:, 1], centres[:, 2], ("index",))
    limits, width = limits_of(all_), min(len(all_), _MOST)
    listed, number = np.empty((len(centres), width), np.int32), np.empty(len(centres), np.int32)
    slack = bars.reach + 1e-9 * (limits.coordinate + limits.radius)
    places = limits.places[index.astype(np.int64)]
    loops.candidates(tree(all_, np.float64), centres, size * 0.5001, places, slack, listed, number)
    kept = np.arange(len(all_))
    if (number <= width).all():
        kept = np.unique(tree(all_, np.float64).ids[listed[np.arange(width) < number[:, None]]])
    near = Segments(starts[kept], ends[kept], all_.radii[kept])
    x, y, z = np.meshgrid(*(((np.arange(_PLACES) + 0.5) / _PLACES - 0.5) * w for w in period), indexing="ij")
    (distance,) = walked(near, x, y, z, ("distance",))
    covering = float(distance.max() + np.linalg.norm(period) / _PLACES / 2)
    return Copies(near, numbers[kept].astype(np.int32), covering)


def _different(bars: Segments, period: Array) -> NDArray[np.int64]:
    """The bars of a cell without those that lie where one before lies, or a copy of it."""
    way, middle = (bars.ends - bars.starts) / period, (bars.starts + bars.ends) / 2 / period
    first = np.argmax(np.abs(way) > _SAME, axis=1)
    way = way * np.sign(way[np.arange(len(way)), first])[:, None]
    radius = bars.radii / max(float(bars.radii.max()), 1e-300)
    # steps that are no simple part of a period: what is one is not parted by its rounding
    counted = np.floor(np.column_stack([middle % 1.0, way, radius]) / _SAME + 0.3178)
    counted[:, :3] %= 1 / _SAME
    return np.sort(np.unique(counted, axis=0, return_index=True)[1])
