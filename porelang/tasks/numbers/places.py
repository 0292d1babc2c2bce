"""Where a formula of one number takes a value: every place in a range, proven by enclosures.

Cells of the range in which the formula is proven to keep off the value go. One in which it is proven to rise or to fall
throughout, by the sign of its slope, takes the value once at most. All others are halved down to what float64 can tell
apart. Neighbouring cells that are left are one place (R. Moore, Interval Analysis, 1966).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.enclose import F64, Enclosure, enclose
from porelang.formula import Formula
from porelang.interval import Interval
from porelang.ir import Node
from porelang.rewrites.gradient import derivative_by
from porelang.rewrites.simplify import tidy

#: The narrowest range that is looked at, relative to the whole.
NARROW = 1e-12
_FIRST, _MOST = 64, 4096  # cells to begin with, and at once
_POINTS = 33
_ROUNDS = 12
#: What misses its target by this share of all that it is in the range touches it.
_NEAR = 2.0**-40
Values = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Place:
    """A range `low..high` that holds places where a value is taken, if there are any.

    `below` and `above` are the signs of what lies before and behind it: -1, 1, or 0 where it is at an end of the range
    or too near to tell. `met` is where the formula is the value to rounding, if such a point was found; `one` if it
    rises or falls throughout, `jumps` if it may jump there.
    """

    low: float
    high: float
    before: int
    behind: int
    met: float | None
    one: bool
    jumps: bool

    @property
    def certain(self) -> bool:
        """Whether the value is taken here, or jumped over."""
        return self.before * self.behind < 0 or self.met is not None

    @property
    def at(self) -> float:
        """Where it is, to be shown."""
        return (self.low + self.high) / 2 if self.met is None else self.met


class Line:
    """A formula less its target along a slot. Its other slots may be bound to ranges: what is found holds for all."""

    def __init__(self, formula: Formula, slot: Node, target: float):
        difference = formula.root - target
        (slope,) = tidy([derivative_by(difference, slot)])
        self.slot = slot
        self.formula = formula.with_roots(difference)
        self.sloped = formula.with_roots(difference, slope)

    def _at(self, formula: Formula, low: Values, high: Values) -> list[Enclosure]:
        known = Interval(low, high, np.zeros(low.shape, np.bool_))
        found = enclose(formula.bind({self.slot: known}), (), F64)
        return [Enclosure(_spread(e.range, low.shape), np.broadcast_to(e.jumps, low.shape)) for e in found]

    def signs(self, points: Values) -> NDArray[np.int8]:
        """The sign at points: 0 where it cannot be told from the value, or is not a number."""
        (found,) = self._at(self.formula, points, points)
        sure = ~found.range.nan
        return np.where(sure & (found.range.lo > 0), 1, np.where(sure & (found.range.hi < 0), -1, 0)).astype(np.int8)

    def met(self, points: Values, near: float = 0.0) -> Mask:
        """Where the value is taken as far as can be told, or is missed by no more than `near`."""
        r = self._at(self.formula, points, points)[0].range
        return np.asarray(~r.nan & (r.lo <= near) & (r.hi >= -near) & np.isfinite(r.hi - r.lo))

    def met_at(self, points: Values) -> Values:
        """The formula at points, less the target; NaN where it is no finite number."""
        r = self._at(self.formula, points, points)[0].range
        with np.errstate(all="ignore"):
            middle = (r.lo + r.hi) / 2
        return np.asarray(np.where(np.isfinite(middle) & ~r.nan, middle, np.nan))

    def cells(self, low: Values, high: Values) -> tuple[Mask, Values, Mask]:
        """Of cells: in which the value may be taken, the direction in which the formula goes (1 up, -1 down, 0 level,
        NaN where nothing is proven), and in which it may jump."""
        value, slope = self._at(self.sloped, low, high)
        middle = (low + high) / 2
        centre = self._at(self.formula, middle, middle)[0].range
        rises, falls = slope.range.lo >= 0, slope.range.hi <= 0
        sure = ~value.jumps & ~slope.range.nan & ~slope.range.empty & ~value.range.nan
        with np.errstate(all="ignore"):
            reach = np.maximum(np.abs(slope.range.lo), np.abs(slope.range.hi)) * (high - low) / 2 * (1 + 1e-12)
            near = sure & np.isfinite(reach) & ~centre.nan
            least = np.where(near, np.maximum(value.range.lo, centre.lo - reach), value.range.lo)
            most = np.where(near, np.minimum(value.range.hi, centre.hi + reach), value.range.hi)
        way = np.where(sure & rises & falls, 0.0, np.where(sure & rises, 1.0, np.where(sure & falls, -1.0, np.nan)))
        return (least <= 0) & (most >= 0), way, np.asarray(value.jumps)


def _spread(r: Interval, shape: tuple[int, ...]) -> Interval:
    return Interval(np.broadcast_to(r.lo, shape), np.broadcast_to(r.hi, shape), np.broadcast_to(r.nan, shape))


def places(line: Line, low: float, high: float) -> list[Place]:
    """All places in `low..high` where a formula takes its target, or may: elsewhere it is proven to be off it."""
    edges = np.linspace(low, high, _FIRST + 1)
    lows, highs = edges[:-1], edges[1:]
    kept: list[tuple[Values, Values, Values, Mask]] = []
    while len(lows):
        maybe, way, jumps = line.cells(lows, highs)
        middle = (lows + highs) / 2
        last = (highs - lows <= NARROW * (high - low)) | (middle <= lows) | (middle >= highs)
        last |= 2 * np.count_nonzero(maybe & np.isnan(way) & ~last) > _MOST
        done = maybe & (~np.isnan(way) | last)
        kept.append((lows[done], highs[done], way[done], jumps[done]))
        open_ = maybe & ~done
        lows, highs = np.concatenate([lows[open_], middle[open_]]), np.concatenate([middle[open_], highs[open_]])
    lows, highs, way = (np.concatenate([k[i] for k in kept]) for i in range(3))
    jumps = np.concatenate([k[3] for k in kept])
    before, behind = line.signs(lows), line.signs(highs)
    left = np.isnan(way) | (before == 0) | (before != behind)  # one way between two equal signs: never there
    order = np.argsort(lows[left])
    lows, highs, way, jumps = lows[left][order], highs[left][order], way[left][order], jumps[left][order]
    if not len(lows):
        return []
    seen = values_met(line, low, high)
    near = _NEAR * float(np.ptp(seen)) if len(seen) else 0.0
    cuts = np.nonzero(lows[1:] != highs[:-1])[0] + 1
    found = []
    for a, b, w, j in zip(*(np.split(each, cuts) for each in (lows, highs, way, jumps)), strict=True):
        one = bool(np.all(w >= 0) or np.all(w <= 0))
        found.append(_closer(line, float(a[0]), float(b[-1]), one, bool(j.any()), near))
    return found


def _closer(line: Line, low: float, high: float, one: bool, jumps: bool, near: float) -> Place:
    """A place with what is met there; one that is crossed once at most is drawn in to where the sign is not known."""
    if one:
        low, high = _edge(line, low, high), _edge(line, high, low)
    points = np.linspace(low, high, _POINTS)
    taken = np.nonzero(line.met(points, 0.0 if one or jumps else near))[0]
    met = float(points[taken[len(taken) // 2]]) if len(taken) else None
    before, behind = (int(s) for s in line.signs(np.array([low, high])))
    return Place(low, high, before, behind, met, one, jumps)


def _edge(line: Line, start: float, end: float) -> float:
    """The last point on the way from `start` to `end` that is surely off the value, as `start` is."""
    for _ in range(_ROUNDS):
        points = np.linspace(start, end, _POINTS)
        signs = line.signs(points)
        other = np.nonzero(signs != signs[0])[0]
        if not signs[0] or not len(other):
            break
        start, end = float(points[other[0] - 1]), float(points[other[0]])
    return start


def level(line: Line, place: Place) -> bool:
    """Whether the value is taken throughout the middle half of a place, as far as samples tell."""
    quarter = (place.high - place.low) / 4
    points = np.linspace(place.low + quarter, place.high - quarter, _POINTS)
    return bool(line.met(points).all())


def values_met(line: Line, low: float, high: float) -> Values:
    """The formula at points of a range, less the target, where it is a finite number."""
    found = line.met_at(np.linspace(low, high, 2 * _POINTS - 1))
    return found[~np.isnan(found)]
