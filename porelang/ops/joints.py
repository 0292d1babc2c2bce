"""Bars that are joined smoothly: fillets where they meet, and the distance from each where no other is near.

Let d be the distances from the surfaces of the bars near a place. The joint f is where the sum of (1 - (d - f) / k)^3
over the bars with d < f + k is 1: a smooth union that does not depend on their order, knows nothing of bars farther
away, and is the distance itself where one bar is alone (sums of exponentials reach some 24 k far, and swell all of it).
Its gradient is a mean of theirs, so that f rises by 1 mm in each mm at most. Between two planes at right angles the
fillet leaves them k before the corner, and is tightest in the middle, with the radius 2^(-5/6) k. Where N bars are
equally near, f is k (1 - N^(-1/3)) less than their distance, and less than k in all.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.data import Segments
from porelang.interval import Array, Interval, Mask
from porelang.ops import segment_copies as copies
from porelang.ops.segments import EPSILON, FARTHEST, enclose_nearest, limits_of, tree

Values = NDArray[Any]
#: The joint, its gradient, its derivative by k; the derivatives of the gradient by place and by k; and of the one by k.
RESULTS = ("distance", "nx", "ny", "nz", "dk", "hxx", "hxy", "hxz", "hyy", "hyz", "hzz", "gx", "gy", "gz", "kk")
#: By this k is longer than the radius of a fillet.
WIDER = 2.0 ** (5 / 6)
#: k of bars that repeat is at most this part of their least period; a little farther go the copies that are kept.
WIDEST, REACH = 0.5, 0.6
_HESSIAN = ("hxx", "hxy", "hxz", "hyy", "hyz", "hzz")


def joined(
    bars: Segments, x: Any, y: Any, z: Any, k: Any, wanted: Sequence[str] = RESULTS, out: Any = None
) -> tuple[Values, ...]:
    """The wanted results (in the order of RESULTS) at coordinates and with k, in mm, that broadcast, in their type.

    Of bars that repeat k is at most their `reach`. Errors: ValueError where there is no bar.
    """
    from porelang.ops import joint_loops as loops

    arrays = [np.asarray(v) for v in (x, y, z, k)]
    dtype = np.result_type(*(a.dtype for a in arrays))
    dtype = dtype if dtype in (np.float32, np.float64) else np.dtype(np.float64)
    arrays = [a.astype(dtype, copy=False) for a in arrays]
    if bars.period is not None:
        arrays[:3] = [copies.folded(v, w) for v, w in zip(arrays[:3], bars.period, strict=True)]
    shape = np.broadcast_shapes(*(a.shape for a in arrays))
    px, py, pz, wide = (np.ascontiguousarray(np.broadcast_to(a, shape)).reshape(-1) for a in arrays)
    found = np.empty((1 if tuple(wanted) == RESULTS[:1] else len(RESULTS), px.size), dtype)
    with np.errstate(all="ignore"):
        loops.joined(tree(bars, dtype), px, py, pz, wide, found)
    results = tuple(found[RESULTS.index(name)].reshape(shape) for name in RESULTS if name in wanted)
    if out is None:
        return results
    for place, values in zip(out, results, strict=True):
        place[...] = values
    return tuple(out)


# ---- bounds ----------------------------------------------------------------------------------------------------------


def enclose_joined(
    bars: Segments, x: Interval, y: Interval, z: Interval, k: Interval, wanted: Sequence[str] = RESULTS
) -> tuple[Interval, ...]:
    """Ranges that hold the exact results over boxes, in the order of RESULTS.

    f and its gradient change along a way by no more than its length times what their derivatives are at most: of f it
    is 1, of the gradient 1 / q + 8 N^(2/3) / k, where N bars at most count and q is their least distance to an axis:
    the weights u <= 1 with sum u^3 = 1 have sum u^2 >= 1 and sum u <= N^(2/3), and units differ by 2 at most. The
    derivatives of the gradient change by what the same counts give: `third`.
    """
    over = _Over(bars, x, y, z, k)
    (m,) = enclose_nearest(bars, x, y, z, ("distance",))
    out = []
    for name in RESULTS:
        if name not in wanted:
            continue
        lo, hi = over.range(name)
        if name == "distance":
            most = np.maximum(k.hi, 0.0) * (1 - np.minimum(over.count, 64.0) ** (-1 / 3))
            lo, hi = np.fmax(lo, m.lo - most - over.own), np.fmin(hi, m.hi)
        none = m.empty | k.empty
        nan = m.nan | k.nan | (over.far if name != "distance" else False)
        lo, hi = np.where(none, np.inf, lo), np.where(none, -np.inf, hi)
        out.append(Interval(lo, hi, np.broadcast_to(nan, lo.shape)))
    return tuple(out)


def jumps_joined(
    bars: Segments, x: Interval, y: Interval, z: Interval, k: Interval, wanted: Sequence[str] = RESULTS
) -> tuple[Mask, ...]:
    """Over which boxes each wanted result may jump: never the joint; its gradient on an axis, where more bars are near
    than count, or k may be 0; the derivatives of that also at the plane at an end of a bar."""
    over = _Over(bars, x, y, z, k)
    found = dict.fromkeys(RESULTS, over.breaks) | dict.fromkeys(_HESSIAN, over.breaks | over.ends)
    found["distance"] = np.zeros(over.breaks.shape, np.bool_)
    return tuple(found[name] for name in wanted)


def rounding_joined(
    bars: Segments, x: Interval, y: Interval, z: Interval, k: Interval, wanted: Sequence[str] = RESULTS
) -> tuple[Array, ...]:
    """How far evaluation may be from the exact results, in units of the type's epsilon e; infinite where anything goes.

    A distance is off by e (C + 8 W) (`segments.rounding_nearest`), and so is a mean of such. The sum of N cubes is off
    by 6 e N, which moves s by a third of that at most, for the sum of squares is 1 or more; k, and what is divided by
    it, by e more. So u is off by du = 2 / k times that of f, and 8 e; the gradient by that of a unit vector and
    4 N du, its derivatives by what their formulas make of these, twice over.
    """
    return _Over(bars, x, y, z, k).rounding(wanted)


def narrow_joined(
    w: Interval, bars: Segments, x: Interval, y: Interval, z: Interval, k: Interval
) -> tuple[Interval | None, ...]:
    """Where the coordinates lie if the joint lies in `w`: in the box of the bars, as far around it and k more."""
    limits = limits_of(bars)
    reach = np.maximum(w.hi, 0.0) + np.maximum(k.hi, 0.0) if bars.period is None else np.inf * np.ones_like(w.hi)
    nothing = np.zeros(np.shape(reach), np.bool_)
    boxes = [Interval(limits.lo[a] - reach, limits.hi[a] + reach, nothing) for a in range(3)]
    return (*boxes, None)


class _Over:
    """What is known of the joint over boxes: its results in their middles, and by how much they may change."""

    def __init__(self, bars: Segments, x: Interval, y: Interval, z: Interval, k: Interval) -> None:
        from porelang.ops import joint_loops as loops

        limits = limits_of(bars)
        shape = np.broadcast_shapes(*(r.lo.shape for r in (x, y, z, k)))
        lo, hi = (np.stack([np.broadcast_to(v, shape) for v in ends]) for ends in (
            (x.lo, y.lo, z.lo, k.lo), (x.hi, y.hi, z.hi, k.hi)))  # fmt: skip
        with np.errstate(all="ignore"):
            middle = lo / 2 + hi / 2
            size = np.maximum(np.abs(lo[:3]), np.abs(hi[:3])).max(0)
            good = np.isfinite(middle).all(0) & (size < FARTHEST) & (lo <= hi).all(0)
            middle = np.where(good, middle, 0.0)
            self.half = np.where(good, np.sqrt(((hi - lo)[:3] ** 2).sum(0)) / 2, np.inf)
            self.sway = np.where(good, (hi - lo)[3] / 2, np.inf)
            moved = np.zeros(shape)
            if bars.period is not None:
                moved = copies.roundings(bars, *np.maximum(np.abs(lo[:3]), np.abs(hi[:3])))
            self.found = dict(zip(RESULTS, joined(bars, *middle), strict=True))
            f = self.found["distance"]
            self.far = np.broadcast_to(~good, shape)
            places = [middle[a] for a in range(3)]
            if bars.period is not None:
                places = [copies.folded(v, w) for v, w in zip(places, bars.period, strict=True)]
            off = limits.coordinate + 8 * (np.abs(f) + self.half + limits.radius + limits.length) + moved
            self.of_bars = np.where(good & (off < FARTHEST), 1.01 * off, np.inf)
            # of one that rounding may bring so near too
            reach = np.maximum(hi[3], 0.0) + 2 * self.half + 8 * EPSILON * self.of_bars
            reach = np.where(good, reach, -1.0)
            known = np.empty((4, f.size))
            made = tree(bars, np.float64)
            px, py, pz = (np.ascontiguousarray(p).reshape(-1) for p in places)
            loops.around(made, px, py, pz, reach.reshape(-1), known)
            self.count, axis, plane, short = (row.reshape(shape) for row in known)
            if bars.period is not None:  # copies that far away are not all kept
                lost = reach > bars.reach
                self.count = np.where(lost, np.inf, self.count)
            self.count = np.maximum(self.count, 1.0)
            self.k = np.maximum(lo[3], 0.0)
            self.axis = axis - self.half
            many = np.minimum(self.count, float(loops.MOST))
            self.many, self.short = many, short
            # the roundings of float64, and 4 e where float32 may be on another side
            self.own = 2.0**-46 * (limits.coordinate + limits.radius + size + np.abs(hi[3]) * many)
            self.own = np.where(good, self.own, np.inf)
            self.most_k = np.maximum(hi[3], 0.0)
            slack = 4 * EPSILON * self.of_bars
            self.breaks = (self.count > loops.MOST) | ~(self.axis > slack) | ~(self.k > 0) | ~good
            self.ends = ~(plane - self.half > slack)

    def range(self, name: str) -> tuple[Array, Array]:
        """The range of a result."""
        value, h, sway = self.found[name], self.half, self.sway
        with np.errstate(all="ignore"):
            if name == "distance":
                room = h + sway + self.own
                return (np.where(np.isfinite(room), value - room, -np.inf),
                        np.where(np.isfinite(room), value + room, np.inf))  # fmt: skip
            of = self.many ** (2 / 3) / self.k  # N^(2/3) / k
            bend, drift, turn = 1 / self.axis + 8 * of, 4 * of, 7 * of
            if name in ("nx", "ny", "nz", "dk"):
                room = (h * bend + sway * drift) if name != "dk" else (h * drift + sway * turn)
                room = room + 1e-12 * (1 + self.many * bend * self.own * 1e12)
                room = np.where(self.breaks | ~np.isfinite(room), np.inf, room)
                below, above = (-1.0, 1.0) if name != "dk" else (-1.0, 0.0)
                known = np.isfinite(room)
                return (np.fmax(np.where(known, value - room, below), below),
                        np.fmin(np.where(known, value + room, above), above))  # fmt: skip
            most = bend if name in _HESSIAN else turn if name == "kk" else drift
            many = self.many ** (5 / 3)
            third = 3 / self.axis**2 + 60 * many * (1 / self.axis + 1 / self.k) / self.k + 200 * many / self.k**2
            room = (h + sway + 64 * self.own) * third + 1e-10 * (1 + most)
            broken = self.breaks | (self.ends if name in _HESSIAN else False)
            most = np.where(self.breaks | ~np.isfinite(most), np.inf, most)
            room = np.where(broken | ~np.isfinite(room), np.inf, room)
            return np.fmax(value - room, -most), np.fmin(value + room, most)

    def rounding(self, wanted: Sequence[str]) -> tuple[Array, ...]:
        """The bound of each wanted result's rounding."""
        n, k, q = self.many, self.k, self.axis
        with np.errstate(all="ignore"):
            others = n - 1  # of a bar alone the weights are 1, whatever u is
            f = self.of_bars + 4 * self.most_k * n
            du = 2 * f / k + 8
            unit = self.of_bars * (18 / q + 4 / self.short) + 3  # the foot moves, and the unit vector with it
            g = 1.1 * (unit + np.minimum(4 * others, 8.0 * n ** (2 / 3)) * du) + 3
            of_k = np.minimum(4 * others, 8.0 * n ** (2 / 3)) * du + 8
            apart = np.where(others > 0, unit + g, 8.0)
            share = n ** (2 / 3)  # of sums of u
            bend = (2 * unit + self.of_bars / q + 4) / q + 2 * others * du * (1 / q + 8 * share / k)
            bend = bend + 2 / k * (others * 4 * du + share * 4 * apart + 8 * others)
            drift = 2 / k * (others * 4 * du + share * (2 * apart + 2 * of_k + 8)) + 8 * share * others * du / k
            kk = 8 / k * (others * 4 * du + share * (2 * of_k + 8)) + 14 * share * others * du / k
            bend, drift, kk = 1.2 * bend, 1.2 * drift, 1.2 * kk
            small = (EPSILON * np.maximum(g, np.maximum(n * du, unit)) < 0.1) & ~self.breaks
            small &= EPSILON * self.of_bars / self.short < 0.02
            found: dict[str, Array] = {"distance": f, "nx": g, "ny": g, "nz": g, "dk": of_k, "kk": kk}
            found |= dict.fromkeys(_HESSIAN, bend) | dict.fromkeys(("gx", "gy", "gz"), drift)
        return tuple(
            np.where(np.isfinite(v) & (small | (name == "distance")), v, np.inf)
            for name, v in ((name, found[name]) for name in wanted)
        )
