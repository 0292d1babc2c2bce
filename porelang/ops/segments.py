"""The nearest of many bars: the distance from its surface, and what else is known of it, from one walk of a tree.

The nearest bar is the one of the least distance to its axis minus its radius; where several tie, that of the lowest
number. A coordinate that is not a number gives NaN everywhere; infinitely far away the distance is infinite and all
else NaN.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from functools import reduce
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from porelang.data import Segments
from porelang.interval import Array, Interval, Mask
from porelang.ops.derived import derived
from porelang.ops.points import Points, points

Values = NDArray[Any]
#: What one walk finds: the distance from the surface (negative inside), its gradient (the unit vector from the foot on
#: the axis to the point, 0 on the axis), the unit direction of the bar, where along it the foot is (0..1), and the
#: bar's radius, length and number.
RESULTS = ("distance", "nx", "ny", "nz", "dx", "dy", "dz", "along", "radius", "length", "index")
SORTED = 1024  # a list of fewer points is walked as it comes


def nearest(
    bars: Segments,
    x: Any,
    y: Any,
    z: Any,
    wanted: Sequence[str] = RESULTS,
    out: Sequence[Values] | None = None,
) -> tuple[Values, ...]:
    """The wanted results (in the order of RESULTS) at coordinates in mm that broadcast, in their type.

    `out` holds an array for each of them. Errors: ValueError where there is no bar, or `out` does not fit.
    """
    from porelang.ops import segment_loops as loops

    at = points(x, y, z)
    mask = sum(1 << RESULTS.index(name) for name in set(wanted))
    found = np.empty((len(set(wanted)), int(np.prod(at.shape))), at.dtype)
    loops.nearest(tree(bars, at.dtype), mask, at.x, at.y, at.z, _order(bars, at), found, at.loops)
    results = tuple(row.reshape(at.shape) for row in found)
    if out is None:
        return results
    for place, values in zip(out, results, strict=True):
        if place.shape != at.shape or place.dtype != at.dtype:
            raise ValueError(f"out is {place.dtype} {place.shape}, the result {at.dtype} {at.shape}")
        place[...] = values
    return tuple(out)


def _order(bars: Segments, at: Points) -> NDArray[np.int64]:
    """An order in which the points of a list lie near each other; empty where they do so as they come.

    A walk that begins with its neighbour's bar, in the same part of the tree, takes 2/3 of the time of another.
    """
    from porelang.ops import segment_loops as loops

    if at.loops[2] < SORTED or at.loops[:2] != (1, 1):
        return np.empty(0, np.int64)
    limits = _limits(bars)
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


# ---- bounds ----------------------------------------------------------------------------------------------------------
#: Of float32: bars that are as near as each other but for its rounding may each be found nearest.
EPSILON = 2.0**-23
#: Beyond this the square of a distance may be no number of float32.
FARTHEST = 1e18


class _Limits(NamedTuple):
    """What is true of all bars: ranges of the results, the largest coordinate, length and radius, and their box."""

    ranges: Array
    coordinate: float
    length: float
    radius: float
    lo: Array
    hi: Array
    places: NDArray[np.int64]  # of each bar in the tree


def enclose_nearest(
    bars: Segments, x: Interval, y: Interval, z: Interval, wanted: Sequence[str] = RESULTS
) -> tuple[Interval, ...]:
    """Ranges that hold the exact results over boxes, in the order of RESULTS, of every bar that rounding may favour."""
    ranges, _, _, shape = _over(bars, x, y, z, wanted != ("distance",))
    none = np.broadcast_to(x.empty | y.empty | z.empty, shape)
    nan = np.broadcast_to(x.nan | y.nan | z.nan, shape)
    far = np.broadcast_to(reduce(np.maximum, (_size(r) for r in (x, y, z))) > FARTHEST, shape)
    results = []
    for k, name in enumerate(RESULTS):
        if name in wanted:
            lo, hi = np.where(none, np.inf, ranges[..., k, 0]), np.where(none, -np.inf, ranges[..., k, 1])
            results.append(Interval(lo, hi, nan if k == 0 else nan | far))
    return tuple(results)


def jumps_nearest(
    bars: Segments, x: Interval, y: Interval, z: Interval, wanted: Sequence[str] = RESULTS
) -> tuple[Mask, ...]:
    """Over which boxes each wanted result may jump: where several bars may be nearest; the gradient also on an axis."""
    if tuple(wanted) == ("distance",):  # it never does
        return (np.zeros(np.broadcast(x.lo, y.lo, z.lo).shape, np.bool_),)
    _, several, touches, shape = _over(bars, x, y, z, True)
    jumps = dict.fromkeys(RESULTS, several) | dict.fromkeys(("nx", "ny", "nz"), several | touches)
    jumps["distance"] = np.zeros(shape, np.bool_)
    return tuple(jumps[name] for name in wanted)


def rounding_nearest(
    bars: Segments, x: Interval, y: Interval, z: Interval, wanted: Sequence[str] = RESULTS
) -> tuple[Array, ...]:
    """How far evaluation may be from the exact results, in units of the type's epsilon e; infinite where anything goes.

    Let C be the largest coordinate, w the vector from a bar's start to the point, q that from its foot, l its length;
    |w| is at most the distance plus the largest radius and length: W. Rounding the ends moves the bar by 0.87 e C, the
    radius by e/2 r. The foot's place along the bar is off by 3.5 e |w| / l (two roundings of each vector, three of the
    dot product, two of 1 / l^2), that is by 3.5 e |w| in mm; q by e |w| more, the root by 2 e |q|, the difference by
    half an e: in all e (C + 8 W). Where along (0..1) the foot is moves by that over l, and seven times as much with
    2 |q| / l more, for the bar turns; q moves with the foot, and the unit vector by twice as much over |q|.
    """
    limits = _limits(bars)
    ranges, _, _, _ = _over(bars, x, y, z, tuple(wanted) != ("distance",))
    far = np.maximum(np.abs(ranges[..., 0, 0]), np.abs(ranges[..., 0, 1]))
    radius, length = ranges[..., 8, :], ranges[..., 9, :]
    with np.errstate(all="ignore"):
        own = np.where(far < FARTHEST, 1.01 * (limits.coordinate + 8 * (far + limits.radius + limits.length)), np.inf)
        if tuple(wanted) == ("distance",):
            return (own,)
        most = np.maximum(ranges[..., 0, 1] + radius[..., 1], 0.0)
        least = np.maximum(ranges[..., 0, 0] + radius[..., 0], 0.0)
        along = own / length[..., 0] * (8 + 2 * most / length[..., 0])
        along = np.where(EPSILON * own / length[..., 0] < 0.02, along, np.inf)  # else it is more than a small change
        turn = np.where(least > 0, 2 * (own + along * length[..., 1]) / least + 3, np.inf)
        turn, along = (np.where(np.isnan(v), np.inf, v) for v in (turn, along))
        turn = np.where(EPSILON * turn < 0.1, 1.1 * turn, np.inf)
    one = np.ones_like(own)
    found = (own, turn, turn, turn, one, one, one, along + 1, 0.5 * radius[..., 1], 0.5 * length[..., 1], 0 * one)
    return tuple(found[RESULTS.index(name)] for name in wanted)


def narrow_distance(w: Interval, bars: Segments, x: Interval, y: Interval, z: Interval) -> tuple[Interval, ...]:
    """Where the coordinates lie if the distance lies in `w`: in the box of the bars, as far around it."""
    limits = _limits(bars)
    return tuple(
        Interval(limits.lo[a] - w.hi, limits.hi[a] + w.hi, np.zeros(np.shape(w.hi), np.bool_)) for a in range(3)
    )


def _limits(bars: Segments) -> _Limits:
    return derived(bars, "limits", lambda: _make_limits(bars))


def _make_limits(bars: Segments) -> _Limits:
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
    return _Limits(ranges, float(np.abs(ends).max()), float(frames[:, 3].max()), float(radii.max()), lo, hi, places)


def _size(r: Interval) -> Array:
    return np.where(r.empty, 0.0, np.maximum(np.abs(r.lo), np.abs(r.hi)))


_Over = tuple[Array, Mask, Mask, tuple[int, ...]]
_LAST = threading.local()


def _over(bars: Segments, x: Interval, y: Interval, z: Interval, all_results: bool) -> _Over:
    """Ranges (..., results, 2) over boxes, where several bars may be nearest, and where an axis may be touched.

    What an enclosure asks of the same boxes three times (ranges, jumps, rounding) is walked for once.
    """
    asked = (bars, x, y, z)
    last, found, whole = getattr(_LAST, "walk", ((), None, False))
    if found is not None and (whole or not all_results) and all(a is b for a, b in zip(asked, last, strict=True)):
        return found  # type: ignore[no-any-return]  # kept below
    made = _walked(*asked, all_results)
    _LAST.walk = (asked, made, all_results)
    return made


def _walked(bars: Segments, x: Interval, y: Interval, z: Interval, all_results: bool) -> _Over:
    from porelang.ops import segment_ranges as loops

    limits = _limits(bars)
    lo, hi = (np.stack(np.broadcast_arrays(*ends)) for ends in ((x.lo, y.lo, z.lo), (x.hi, y.hi, z.hi)))
    shape = lo.shape[1:]
    lo, hi = lo.reshape(3, -1), hi.reshape(3, -1)
    with np.errstate(all="ignore"):
        centre = lo / 2 + hi / 2
        good = np.isfinite(centre).all(0) & (np.abs(centre) < 1e150).all(0)
        cx, cy, cz = np.where(good, centre, np.nan)
        distance, index = nearest(bars, cx, cy, cz, ("distance", "index"))
        places = np.where(good, limits.places[np.where(good, index, 0).astype(np.int64)], -1)
        # two distances, each rounded
        reach = np.abs(distance) + limits.radius + limits.length + np.sqrt(((hi - lo) ** 2).sum(0)) / 2
        slack = np.where(good, 2.02 * EPSILON * (limits.coordinate + 8 * reach), 0.0)
        count = lo.shape[1]
        found = loops.Found(np.empty((count, len(RESULTS), 2)), np.zeros(count, np.bool_), np.zeros(count, np.bool_))
        loops.enclose(tree(bars, np.float64), loops.Boxes(lo, hi, places), limits.ranges, all_results, slack, found)
        own = 2.0**-48 * (limits.coordinate + limits.radius + np.abs(lo).max(0) + np.abs(hi).max(0))
        own = np.where(np.isfinite(own), own, 2.0**-48 * limits.coordinate)
        found.ranges[:, 0, 0] -= own  # the roundings of float64
        found.ranges[:, 0, 1] += own
        found.ranges[:, 1:4] += np.array([-1e-14, 1e-14])
        found.ranges[:, 7] += np.stack([-own, own], 1) / limits.ranges[9, 0]
    return (
        found.ranges.reshape(*shape, len(RESULTS), 2),
        found.several.reshape(shape),
        found.touches.reshape(shape),
        shape,
    )
