"""The nearest of many bars: the distance from its surface, and what else is known of it, from one walk of a tree.

The nearest bar is the one of the least distance to its axis minus its radius; where several tie, that of the lowest
number. A coordinate that is not a number gives NaN everywhere; infinitely far away the distance is infinite and all
else NaN.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from functools import partial, reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.data import Segments
from porelang.interval import Array, Interval, Mask
from porelang.ops import segment_copies as copies
from porelang.ops import segment_tree
from porelang.ops.derived import derived
from porelang.ops.segment_cells import lists

Values = NDArray[Any]
RESULTS, EPSILON = segment_tree.RESULTS, segment_tree.EPSILON


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
    if bars.period is not None:
        x, y, z = (copies.folded(v, w) for v, w in zip((x, y, z), bars.period, strict=True))
    # of a period cells are few, and their lists short: to try them takes a fraction of a walk
    listed = partial(lists, bars) if bars.period is not None else None
    results = segment_tree.walked(copies.held(bars), x, y, z, tuple(wanted), listed)
    if bars.period is not None and "index" in wanted:  # it is the last
        results[-1] = copies.own_numbers(bars, results[-1])
    if out is None:
        return tuple(results)
    for place, values in zip(out, results, strict=True):
        if place.shape != values.shape or place.dtype != values.dtype:
            raise ValueError(f"out is {place.dtype} {place.shape}, the result {values.dtype} {values.shape}")
        place[...] = values
    return tuple(out)


def tree(bars: Segments, dtype: Any) -> Any:
    """The tree that is walked through, in a working type (`segment_loops.Tree`): over bars, or over their copies."""
    return segment_tree.tree(copies.held(bars), dtype)


def limits_of(bars: Segments) -> segment_tree.Limits:
    """What is true of all bars."""
    return segment_tree.limits_of(bars) if bars.period is None else derived(bars, "limits", lambda: _of_copies(bars))


def _of_copies(bars: Segments) -> segment_tree.Limits:
    near, _, covering = copies.copies(bars)
    found = segment_tree.limits_of(near)
    ranges = found.ranges.copy()
    ranges[0], ranges[10] = (-found.radius, covering), (0.0, len(bars) - 1.0)
    return found._replace(ranges=ranges)


# ---- bounds ----------------------------------------------------------------------------------------------------------
#: Beyond this the square of a distance may be no number of float32.
FARTHEST = 1e18


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
            if bars.period is not None and k == 0:  # so far away a place is moved to none
                hi = np.where(far & ~none, np.inf, hi)
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
    limits = limits_of(bars)
    ranges, _, _, _ = _over(bars, x, y, z, tuple(wanted) != ("distance",))
    far = np.maximum(np.abs(ranges[..., 0, 0]), np.abs(ranges[..., 0, 1]))
    radius, length = ranges[..., 8, :], ranges[..., 9, :]
    with np.errstate(all="ignore"):
        reach = limits.coordinate + 8 * (far + limits.radius + limits.length)
        if bars.period is not None:
            reach = reach + copies.roundings(bars, _size(x), _size(y), _size(z))
        own = np.where((far < FARTHEST) & (reach < FARTHEST), 1.01 * reach, np.inf)
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
    if bars.period is not None:  # they go on without end
        return tuple(Interval(-np.inf * np.ones_like(w.hi), np.inf * np.ones_like(w.hi), w.nan) for _ in range(3))
    limits = limits_of(bars)
    return tuple(
        Interval(limits.lo[a] - w.hi, limits.hi[a] + w.hi, np.zeros(np.shape(w.hi), np.bool_)) for a in range(3)
    )


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

    limits = limits_of(bars)
    lo, hi = (np.stack(np.broadcast_arrays(*ends)) for ends in ((x.lo, y.lo, z.lo), (x.hi, y.hi, z.hi)))
    shape = lo.shape[1:]
    lo, hi = lo.reshape(3, -1), hi.reshape(3, -1)
    far, wide = np.abs(lo).max(0) + np.abs(hi).max(0), None
    moved = np.zeros(lo.shape[1])
    if bars.period is not None:
        moved = copies.roundings(bars, *np.maximum(np.abs(lo), np.abs(hi)))
        lo, hi, wide = copies.folded_boxes(bars, lo, hi)
    with np.errstate(all="ignore"):
        centre = lo / 2 + hi / 2
        good = np.isfinite(centre).all(0) & (np.abs(centre) < 1e150).all(0)
        cx, cy, cz = np.where(good, centre, np.nan)
        distance, index = nearest(copies.held(bars), cx, cy, cz, ("distance", "index"))
        places = np.where(good, limits.places[np.where(good, index, 0).astype(np.int64)], -1)
        # two distances, each rounded
        reach = np.abs(distance) + limits.radius + limits.length + np.sqrt(((hi - lo) ** 2).sum(0)) / 2
        slack = np.where(good, 2.02 * EPSILON * (limits.coordinate + 8 * reach + moved), 0.0)
        count = lo.shape[1]
        found = loops.Found(np.empty((count, len(RESULTS), 2)), np.zeros(count, np.bool_), np.zeros(count, np.bool_))
        loops.enclose(tree(bars, np.float64), loops.Boxes(lo, hi, places), limits.ranges, all_results, slack, found)
        own = 2.0**-48 * (limits.coordinate + limits.radius + far)
        own = np.where(np.isfinite(own), own, 2.0**-48 * limits.coordinate)
        if wide is not None:
            found.ranges[:, 10] = copies.own_numbers(bars, found.ranges[:, 10])
            found.ranges[wide] = limits.ranges
            found.several[wide], found.touches[wide] = True, True
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
