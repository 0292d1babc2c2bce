"""The tree of bars that do not repeat, what is true of all of them, and its walk for places: what `segments` makes
an operation of."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from porelang.data import Segments
from porelang.interval import Array
from porelang.ops.derived import derived
from porelang.ops.points import Points, points

Values = NDArray[Any]
#: What one walk finds: the distance from the surface (negative inside), its gradient (the unit vector from the foot on
#: the axis to the point, 0 on the axis), the unit direction of the bar, where along it the foot is (0..1), and the
#: bar's radius, length and number.
RESULTS = ("distance", "nx", "ny", "nz", "dx", "dy", "dz", "along", "radius", "length", "index")
#: Of float32: bars that are as near as each other but for its rounding may each be found nearest.
EPSILON = 2.0**-23
SORTED = 1024  # a list of fewer points is walked as it comes


def _no_lists(dtype: np.dtype[Any]) -> tuple[Any, ...]:
    return np.zeros(3, dtype), np.zeros(1, dtype), (0, 0, 0), np.empty(0, np.int32), np.empty(0, np.int32)


def walked(bars: Segments, x: Any, y: Any, z: Any, wanted: tuple[str, ...], lists: Any = None) -> list[Values]:
    """Of the wanted results, in the order of RESULTS, those at coordinates that broadcast, in their type; found by the
    `segment_loops.Lists` that `lists` makes for a type, where they are given."""
    from porelang.ops import segment_loops as loops

    at = points(x, y, z)
    mask = sum(1 << RESULTS.index(name) for name in set(wanted))
    found = np.empty((len(set(wanted)), int(np.prod(at.shape))), at.dtype)
    known = loops.Lists(*_no_lists(at.dtype)) if lists is None else lists(at.dtype)
    loops.nearest(tree(bars, at.dtype), known, mask, at.x, at.y, at.z, _order(bars, at), found, at.loops)
    return [row.reshape(at.shape) for row in found]


def _order(bars: Segments, at: Points) -> NDArray[np.int64]:
    """An order in which the points of a list lie near each other; empty where they do so as they come.

    A walk that begins with its neighbour's bar, in the same part of the tree, takes 2/3 of the time of another.
    """
    from porelang.ops import segment_loops as loops

    if at.loops[2] < SORTED or at.loops[:2] != (1, 1):
        return np.empty(0, np.int64)
    limits = limits_of(bars)
    codes = np.empty(at.loops[2], np.uint16)
    loops.curve(at.x, at.y, at.z, limits.lo, 32 / np.maximum(limits.hi - limits.lo, 1e-30), codes)
    return np.argsort(codes, kind="stable")  # of 16 bits: by radix


def tree(bars: Segments, dtype: Any) -> Any:
    """The tree over bars in a working type (`segment_loops.Tree`). Errors: ValueError where there is no bar."""
    kind = np.dtype(dtype)
    return derived(bars, ("tree", kind.str), lambda: _make_tree(bars, kind))


def _make_tree(bars: Segments, dtype: np.dtype[Any]) -> Any:
    from porelang.ops import segment_loops as loops

    count, wide = len(bars), loops.WIDE
    if count == 0:
        raise ValueError("there is no bar")
    depth = max(0, (-(-count // wide) - 1).bit_length())
    leaves, levels = 1 << depth, -(-depth // 3)
    top = 1 << (depth - 3 * (levels - 1)) if levels else 0
    order, starts = derived(bars, "order", lambda: loops.arrange((bars.starts + bars.ends) / 2, depth))
    leaf = np.repeat(np.arange(leaves), np.diff(starts))
    place = leaf * wide + np.arange(count) - starts[leaf]
    packed, frames = np.zeros((leaves * wide, 8), dtype), np.zeros((leaves * wide, 4), dtype)
    ids = np.full(leaves * wide, np.iinfo(np.int32).max, np.int32)
    packed[:, 6] = -np.inf
    ids[place] = order
    with np.errstate(over="ignore", divide="ignore"):
        mine = np.column_stack([bars.starts, bars.ends, bars.radii])[order].astype(dtype)
        # of the rounded bar; one that rounding has shrunk to a point is met at its start
        square = ((mine[:, 3:6].astype(np.float64) - mine[:, 0:3]) ** 2).sum(axis=1)
        inverse = np.where(square > 0, 1.0 / square, 0.0).astype(dtype)
        packed[place, :7], packed[place, 7] = mine, np.where(np.isfinite(inverse), inverse, 0.0)
        axis = (bars.ends - bars.starts)[order]
        length = np.sqrt((axis**2).sum(axis=1))
        frames[place] = np.column_stack([axis / length[:, None], length])
    lanes = np.ascontiguousarray(packed.reshape(leaves, wide, 8).transpose(0, 2, 1))
    boxes = np.empty(((1 + top * (8 ** (levels - 1) - 1) // 7) if levels else 0, 7, wide), dtype)
    boxes[:, :3], boxes[:, 3:] = np.inf, -np.inf
    loops.bound(boxes, lanes, top)
    scale = np.array([np.abs(mine).max(), 16 * np.finfo(dtype).eps, np.finfo(dtype).max], dtype)
    return loops.Tree(boxes, lanes, frames, ids, scale, top)


class Limits(NamedTuple):
    """What is true of all bars: ranges of the results, the largest coordinate, length and radius, and their box."""

    ranges: Array
    coordinate: float
    length: float
    radius: float
    lo: Array
    hi: Array
    places: NDArray[np.int64]  # of each bar in the tree


def limits_of(bars: Segments) -> Limits:
    """What is true of all bars."""
    return derived(bars, "limits", lambda: _make_limits(bars))


def _make_limits(bars: Segments) -> Limits:
    made = tree(bars, np.float64)
    used = np.flatnonzero(made.ids < len(bars))
    frames, radii = made.frames[used], bars.radii
    ranges = np.empty((len(RESULTS), 2))
    ranges[0], ranges[1:4], ranges[7], ranges[10] = (-np.inf, np.inf), (-1.0, 1.0), (0.0, 1.0), (0.0, len(bars) - 1.0)
    ranges[[4, 5, 6, 9]] = np.column_stack([frames.min(0), frames.max(0)])
    ranges[8] = radii.min(), radii.max()
    ends = np.stack([bars.starts, bars.ends])
    lo, hi = (ends.min(0) - radii[:, None]).min(0), (ends.max(0) + radii[:, None]).max(0)
    places = np.empty(len(bars), np.int64)
    places[made.ids[used]] = used
    return Limits(ranges, float(np.abs(ends).max()), float(frames[:, 3].max()), float(radii.max()), lo, hi, places)
