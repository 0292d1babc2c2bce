"""What a field can be over boxes: the natural enclosure, tightened by linear forms or by the centred form.

Where every operation has a rule in `linear`, a linear form is carried through the formula. Else, where the field is
continuous, the centred form is used, after the mean value theorem: over a box with centre c and half-sizes r, f lies
within f(c) +- sum |df/dx_i| r_i, with the derivatives enclosed over the same box. Both win on small boxes; the natural
form wins on large ones and near edges. All of them hold, so the tighter end of each is kept.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.enclose import EXACT, F32, Enclosure, Precision, boxes, enclose, enclose_all
from porelang.analysis.linear import SHORT, has_rules, linear
from porelang.backends.numpy import every_position
from porelang.formula import Formula
from porelang.interval import INF, Interval
from porelang.ir import Node
from porelang.rewrites.gradient import derivatives
from porelang.rewrites.simplify import tidy

Points = NDArray[np.float64]
Values = NDArray[np.float64]
#: Low and high ends over n boxes given by their corners (n, 3).
BoxTest = Callable[[Points, Points], tuple[Values, Values]]
_BATCH = 4096
#: Of more boxes than `_MANY` about `_TRIED` are tried first, where linear forms are carried through a long formula.
_MANY, _TRIED = 1024, 128
#: The share of them that has to be decided.
_WORTH = 0.1
#: Longer graphs are enclosed by the natural form alone: their derivatives would cost more than what they rule out saves
#: (a union of 2000 spheres, 8000 operations: twice the time of the whole mesh).
LONGEST = 2000
#: Points along each side of a box at which rounding is looked at.
_POINTS = 5
#: Slopes that are kept: boxes of one field are looked at many times.
_KEPT = 64


@lru_cache(maxsize=_KEPT)
def slopes(root: Node) -> tuple[Node, Node, Node]:
    """The partial derivatives of a flat root along x, y, z, simplified."""
    dx, dy, dz = tidy(derivatives(root))
    return dx, dy, dz


def box_test(formula: Formula, precision: Precision = F32) -> BoxTest:
    """A function that encloses a formula's root, as computed with `precision`, over boxes; NaN ends never occur.

    Linear and centred forms are those of the exact function. Their slack is the rounding bound at the centre (times 8),
    and what rounding adds to the natural enclosure of the box: at a centre where all is 0, nothing is rounded.
    """
    sloped: list[Formula] = []
    close = len(formula.tape) <= LONGEST
    ruled = close and len(formula.tape) > SHORT and has_rules(formula.tape)

    def natural(lo: Points, hi: Points) -> tuple[Values, Values]:
        r = enclose(formula, boxes(lo, hi), precision)[0].range
        unsure = r.nan | r.empty
        return (
            np.broadcast_to(np.where(unsure, -INF, r.lo), len(lo)).copy(),
            np.broadcast_to(np.where(unsure, INF, r.hi), len(lo)).copy(),
        )

    def rounded_at(middle: Points) -> Interval:
        return enclose(formula, boxes(middle, middle), precision)[0].range

    def tightened(lo: Points, hi: Points, rounded_lo: Values, rounded_hi: Values) -> tuple[Values, Values]:
        """By linear forms, less what rounding adds."""
        value = linear(formula, boxes(lo, hi))[0].range
        low, high = value.lo, value.hi
        if precision.eps:
            at_centre, exact = rounded_at((lo + hi) / 2), enclose(formula, boxes(lo, hi), EXACT)[0].range
            with np.errstate(all="ignore"):
                added = np.maximum(exact.lo - rounded_lo, rounded_hi - exact.hi)
                slack = np.maximum(4 * (at_centre.hi - at_centre.lo), np.where(np.isnan(added), INF, added))
                slack = np.where(at_centre.nan | at_centre.empty, INF, slack)
                low, high = low - slack, high + slack
        unsure = value.nan | value.empty | np.isnan(low) | np.isnan(high)
        return np.where(unsure, -INF, low), np.where(unsure, INF, high)

    def centred(lo: Points, hi: Points, rounded_lo: Values, rounded_hi: Values) -> tuple[Values, Values]:
        if not sloped:
            sloped.append(formula.with_roots(formula.root, *slopes(formula.root)))
        value, *slope = enclose(sloped[0], boxes(lo, hi), EXACT)
        at_centre = rounded_at((lo + hi) / 2)
        reach = np.zeros(len(lo))
        with np.errstate(all="ignore"):
            for i, s in enumerate(slope):
                steep = np.maximum(np.abs(s.range.lo), np.abs(s.range.hi))
                steep = np.where(s.range.nan | s.range.empty, INF, steep)
                reach = reach + np.where(steep == 0, 0.0, steep * (hi[:, i] - lo[:, i]) / 2)
            added = np.maximum(value.range.lo - rounded_lo, rounded_hi - value.range.hi)
            slack = np.maximum(4 * (at_centre.hi - at_centre.lo), np.where(np.isnan(added), 0.0, added))
            slack = slack + reach * 2.0**-50
            usable = ~(value.jumps | at_centre.nan | at_centre.empty) & np.isfinite(reach) & np.isfinite(slack)
            low = np.where(usable, at_centre.lo - reach - slack, -INF)
            high = np.where(usable, at_centre.hi + reach + slack, INF)
        return low, high

    def test(lo: Points, hi: Points) -> tuple[Values, Values]:
        lows, highs = [], []
        for start in range(0, len(lo), _BATCH):
            a, b = lo[start : start + _BATCH], hi[start : start + _BATCH]
            low, high = natural(a, b)
            undecided = np.flatnonzero((low <= 0) & (high >= 0)) if close else np.zeros(0, np.int64)
            # what decides next to nothing of a few, as over boxes that are too large, hardly does of the others
            few = undecided[:: len(undecided) // _TRIED] if ruled and len(undecided) > _MANY else undecided[:0]
            for some in (few, undecided) if len(few) else (undecided,):
                if not len(some):
                    continue
                tight_low, tight_high = (tightened if ruled else centred)(a[some], b[some], low[some], high[some])
                low[some], high[some] = np.maximum(low[some], tight_low), np.minimum(high[some], tight_high)
                if some is few and np.count_nonzero((low[few] > 0) | (high[few] < 0)) < _WORTH * len(few):
                    break
            lows.append(low)
            highs.append(high)
        return np.concatenate(lows), np.concatenate(highs)

    return test


def rounding(formula: Formula, lo: Sequence[float], hi: Sequence[float], precision: Precision = F32) -> float:
    """By how much rounding may move the surface of a formula in a box, in mm: the bound for values over the slope.

    It is looked at where the field is nearest to 0 among a few points; 0 where it has no slope at any of them.
    """
    ends = [a + (b - a) * (np.arange(_POINTS) + 0.5) / _POINTS for a, b in zip(lo, hi, strict=True)]
    points = np.stack(np.meshgrid(*ends, indexing="ij"), axis=-1).reshape(-1, 3)
    places = boxes(points, points)
    value, *slope = (e.range for e in enclose(formula.with_roots(formula.root, *slopes(formula.root)), places))
    near = np.argsort(np.abs(np.broadcast_to(value.lo + value.hi, len(points))))[: len(points) // 4]
    own = np.abs(points) * precision.eps / 2  # of the coordinates
    found = enclose(formula, boxes(points - own, points + own), precision)[0]
    rounded, near = found.range, near[~np.broadcast_to(found.jumps, len(points))[near]]
    with np.errstate(all="ignore"):
        steep = np.sqrt(sum(np.square(np.broadcast_to(s.lo + s.hi, len(points)) / 2) for s in slope))
        off = np.broadcast_to(rounded.hi - rounded.lo, len(points)) / 2 / steep
    off = off[near]
    off = off[np.isfinite(off)]
    return float(np.quantile(off, 0.75)) if len(off) else 0.0  # at a few of the points the slope may be next to none


def overflows(formula: Formula, lo: Sequence[float], hi: Sequence[float], precision: Precision = F32) -> bool:
    """Whether something that a formula computes in a box is a number in float64, and too large for `precision`.

    An enclosure tells that nothing is, or that something may be; where it has no end, points of the box are asked.
    """
    box = boxes(np.array([lo], np.float64), np.array([hi], np.float64))
    high = 0.0
    for found in enclose_all(formula.taken, box).values():
        reach = np.maximum(np.abs(found.range.lo), np.abs(found.range.hi))
        if not bool(np.all(found.range.empty)):
            high = max(high, float(np.max(np.nan_to_num(reach, nan=INF, posinf=INF))))
    if high <= precision.huge or np.isfinite(high):
        return high > precision.huge
    ends = [np.linspace(a, b, _POINTS) for a, b in zip(lo, hi, strict=True)]
    points = np.stack(np.meshgrid(*ends, indexing="ij"), axis=-1).reshape(-1, 3)
    with np.errstate(all="ignore"):
        for value in every_position(formula.taken, points):
            size = np.abs(value) if isinstance(value, np.ndarray | np.floating) and np.isrealobj(value) else np.zeros(1)
            if size.dtype.kind == "f" and ((size > precision.huge) & np.isfinite(size)).any():
                return True
    return False


def steepest(value: Enclosure, slope: Sequence[Enclosure]) -> NDArray[np.float64]:
    """A bound on |grad f| from the enclosures of a field and its slopes; infinite where the field may jump."""
    with np.errstate(all="ignore"):
        total = np.zeros(())
        for s in slope:
            steep = np.maximum(np.abs(s.range.lo), np.abs(s.range.hi))
            total = total + np.where(s.range.nan | s.range.empty, INF, steep) ** 2
        return np.where(value.jumps | value.range.nan, INF, np.sqrt(total))


def lipschitz(formula: Formula, lo: Points, hi: Points) -> NDArray[np.float64]:
    """A bound on |grad f| over boxes (n, 3) .. (n, 3); infinite where the field may jump."""
    value, *slope = enclose(formula.with_roots(formula.root, *slopes(formula.root)), boxes(lo, hi))
    return np.broadcast_to(steepest(value, slope), len(lo))
