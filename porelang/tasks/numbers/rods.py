"""Where lines along an axis meet a solid's surface, within its undecided cells: crossings proven, not seen.

A piece of a line holds one crossing if the field changes its sign there and is proven to rise or fall throughout; none
if it is proven to keep its sign. Any other piece is cut just before and after a crossing, or halved, until it is
shorter than `SHORTEST`, so that walls far thinner than any grid are met. What is open then and has the same sign at
both ends is taken for a touch, which counts nothing. Where halving proves next to nothing, so that more than `_MOST`
times as many are open as there were pieces, they are counted as they are; those that may be touches are told.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.bounds import Points, slopes
from porelang.analysis.enclose import boxes, enclose
from porelang.backends.numpy import NumpyField
from porelang.formula import Formula
from porelang.interval import Interval
from porelang.parallel import parallel_for, workers
from porelang.progress import tell
from porelang.tasks.numbers.region import Region, seed

SHORTEST = 1e-6  # mm, or `_HALVINGS` halvings of the lines through a part that is tiny itself
_HALVINGS = 10
_BISECTIONS = 45  # of a piece: to the rounding of its coordinates
_CLOSE = 2.0**-40
_BEFORE_A_CUT = 2  # halvings of a piece that changes its sign, before it is cut at a crossing, where slopes are proven
_WORTH = 0.05  # of the pieces that are left: slopes that prove less are not asked for again
_MOST = 8  # open parts of a piece, on average
_AT_ONCE = 8192
_PIECES = 1 << 17
Values = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Crossings:
    """Points (n, 3) where pieces of lines meet the surface, the piece each lies on, whether the line leaves there, and
    whether the field may jump there, so that its slope says nothing of the surface.

    `ends_inside` says of each piece whether its far end lies in the solid. `open_` counts the parts of pieces, each of
    `open_length` mm, that may hold a wall for all that is proven; `early` if halving ended before they were short.
    """

    points: Points
    piece: Indices
    leaves: NDArray[np.bool_]
    jumps: NDArray[np.bool_]
    ends_inside: NDArray[np.bool_]
    open_: int
    open_length: float
    early: bool


class Rods:
    """A solid's field and slopes, ready for lines."""

    def __init__(self, solid: Formula):
        self.solid = solid
        self.slopes = slopes(solid.root)
        self.sloped = solid.with_roots(solid.root, *self.slopes)
        self.along = [solid.with_roots(solid.root, s) for s in self.slopes]
        self.field = NumpyField(solid, "f64")
        self.slope = NumpyField(solid.with_roots(*self.slopes), "f64")

    def rising(self, low: Points, size: Values) -> NDArray[np.bool_]:
        """Whether the field is proven to rise or to fall along each axis throughout each cell, (n, 3)."""
        out = np.zeros((len(low), 3), np.bool_)

        def look(some: Indices) -> None:
            value, *slope = enclose(self.sloped, boxes(low[some], low[some] + size))
            for i, s in enumerate(slope):
                out[some, i] = _signed(s.range) & ~value.jumps

        _threaded(look, np.arange(len(low)))
        return out

    def cross(self, low: Points, length: float, axis: int, sure: NDArray[np.bool_], shortest: float) -> Crossings:
        """Where pieces of lines from `low`, `length` mm along an axis, meet the surface; `sure` where the field is
        proven to rise or to fall along the piece, `shortest` how short parts of which nothing is proven get (mm)."""
        high = low.copy()
        high[:, axis] += length
        at_low, at_high = self.field.at(low) < 0, self.field.at(high) < 0
        ends_inside = at_high
        line = np.arange(len(low))
        found: list[tuple[Points, Points, NDArray[np.bool_], Indices, NDArray[np.bool_]]] = []
        once = (at_low != at_high) & sure
        found.append((low[once], high[once], at_low[once], line[once], np.zeros(np.count_nonzero(once), np.bool_)))
        low, high, line = low[~sure], high[~sure], line[~sure]
        at_low, at_high = at_low[~sure], at_high[~sure]
        unproven, early = 0, False
        most = max(_MOST * len(at_low), _AT_ONCE)
        halvings = max(_HALVINGS, math.ceil(math.log2(length / shortest)))
        slopes = True
        for halving in range(halvings + 1):
            if not len(low):
                break
            # slopes of which the first halvings prove nothing are hardly proven by more, and are the longer formulas
            one_way, none, jumps = self._proven(low, high, axis, slopes)
            slopes = halving < _HALVINGS and bool(np.count_nonzero(one_way) >= _WORTH * np.count_nonzero(~none))
            last = halving == halvings or len(low) > most
            changes = at_low != at_high
            once = changes & (one_way | last)
            found.append((low[once], high[once], at_low[once], line[once], jumps[once]))
            open_ = ~none & ~one_way & (not last)
            if last:
                unproven = int(np.count_nonzero(~none & ~one_way & ~changes))
                length /= 2**halving
                early = halving < halvings
            cut = np.flatnonzero(open_ & changes) if halving >= _BEFORE_A_CUT or not slopes else line[:0]
            before, after = self._apart(low[cut], high[cut], at_low[cut], axis, length / 2 ** (halvings + 1))
            held = ((self.field.at(before) < 0) == at_low[cut]) & ((self.field.at(after) < 0) == at_high[cut])
            cut, before, after = cut[held], before[held], after[held]
            if len(cut):
                jumps = np.broadcast_to(enclose(self.solid, boxes(before, after))[0].jumps, len(cut))
                found.append((before, after, at_low[cut], line[cut], jumps))
                open_[cut] = False
            # of what is cut both sides go on, each of one sign, to be halved with the others
            low, high, line, at_low, at_high = (
                np.concatenate(parts)
                for parts in (
                    (low[open_], low[cut], after),
                    (high[open_], before, high[cut]),
                    (line[open_], line[cut], line[cut]),
                    (at_low[open_], at_low[cut], at_high[cut]),
                    (at_high[open_], at_low[cut], at_high[cut]),
                )
            )
            middle = (low + high) / 2
            at_middle = self.field.at(middle) < 0
            low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
            at_low, at_high = np.concatenate([at_low, at_middle]), np.concatenate([at_middle, at_high])
            line = np.concatenate([line, line])
        low, high, inside, line, jumps = (np.concatenate([f[k] for f in found]) for k in range(5))
        met = self._met(low, high, inside)
        return Crossings(met, line, inside, jumps, ends_inside, unproven, length, early)

    def _apart(
        self, low: Points, high: Points, inside: NDArray[np.bool_], axis: int, short: float
    ) -> tuple[Points, Points]:
        """Points just before and after a crossing of each piece: on a box a distance has a kink, and its slope no sign,
        however often it is halved; but to either side of the crossing its sign is proven at once."""
        met = self._met(low, high, inside)
        before, after = met.copy(), met.copy()
        before[:, axis] = np.maximum(low[:, axis], met[:, axis] - short)
        after[:, axis] = np.minimum(high[:, axis], met[:, axis] + short)
        return before, after

    def _proven(
        self, low: Points, high: Points, axis: int, slopes: bool
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
        """Which pieces are crossed once at most, which not at all, and in which the field may jump."""
        one_way, none, jumps = np.zeros((3, len(low)), np.bool_)

        def kept_sign(some: Indices) -> None:
            value = enclose(self.solid, boxes(low[some], high[some]))[0]
            none[some] = ((value.range.lo >= 0) | (value.range.hi < 0)) & ~value.range.nan
            jumps[some] = value.jumps

        def kept_slope(some: Indices) -> None:
            value, slope = enclose(self.along[axis], boxes(low[some], high[some]))
            one_way[some] = _signed(slope.range) & ~value.jumps

        _threaded(kept_sign, np.arange(len(low)))
        if slopes:
            _threaded(kept_slope, np.nonzero(~none)[0])
        return one_way, none, jumps

    def _met(self, low: Points, high: Points, inside: NDArray[np.bool_]) -> Points:
        """The crossing of each piece, by the Illinois form of the secant method; by halving where that does not help:
        the last point inside, for beyond it the field may be level.

        A wall may be a billionth of a piece thick, and all lines may see it at the same place: what is left of a piece
        would be an error that no spread shows.
        """
        out = (low + high) / 2
        rows = np.arange(len(low))
        axis_low, axis_high = np.zeros(len(low)), np.ones(len(low))  # along each piece
        values_low, values_high = self.field.at(low), self.field.at(high)
        side = np.zeros(len(low), np.int8)
        for round_ in range(_BISECTIONS):
            if not len(rows):
                break
            a, b, f, g = axis_low, axis_high, values_low, values_high
            with np.errstate(all="ignore"):
                t = (a * g - b * f) / (g - f)
            if round_ % 3 == 2:
                t = (a + b) / 2
            t = np.where((t > a) & (t < b), t, (a + b) / 2)
            start, end = low[rows], high[rows]
            at = start + t[:, None] * (end - start)
            value = self.field.at(at)
            same = (value < 0) == inside[rows]
            again = same & (side == 1), ~same & (side == -1)
            axis_low, values_low = np.where(same, t, a), np.where(same, value, np.where(again[1], f / 2, f))
            axis_high, values_high = np.where(same, b, t), np.where(same, np.where(again[0], g / 2, g), value)
            side = np.where(same, 1, -1).astype(np.int8)
            inner = np.where(inside[rows], axis_low, axis_high)
            out[rows] = start + inner[:, None] * (end - start)
            left = axis_high - axis_low > _CLOSE
            rows, side = rows[left], side[left]
            axis_low, axis_high = axis_low[left], axis_high[left]
            values_low, values_high = values_low[left], values_high[left]
        return out

    def normals(self, points: Points) -> Points:
        """The unit normals of the surface at its points; not a number where the field has no slope there."""
        slope = self.slope.at(points)
        with np.errstate(all="ignore"):
            slope = slope / np.abs(slope).max(axis=1)[:, None]  # what is steep or flat beyond measure can be squared
            return np.asarray(slope / np.linalg.norm(slope, axis=1)[:, None])


@dataclass(frozen=True, slots=True)
class Met:
    """Sums over all lines along an axis: of what was counted of each, and the crossings left out, with the variance of
    both together. `most` is the most that was counted of a line.

    `touches` counts the parts of lines of which nothing was proven when halving ended early, `touched` sums the lengths
    of all of which nothing was proven; both stand for areas as the others do.
    """

    total: float
    variance: float
    uncounted: float
    touches: float
    touched: float
    most: float


#: What a batch of pieces adds: to each piece, and to the piece of each crossing; NaN where that is not known.
Count = Callable[[Crossings, Points], tuple[Values, Values]]


def along(
    rods: Rods, where: Region, sure: NDArray[np.bool_], axis: int, m: int, count: Count, shortest: float = SHORTEST
) -> Met:
    """What random lines along an axis meet, in mm^2 times what is counted of each line; two lines in each of m^2 strata
    of every column of cells.

    A line runs through all cells of its column: a surface that leaves one cell for the next is met all the same.
    """
    low, size = where.undecided, where.size
    across = [i for i in range(3) if i != axis]
    index = np.rint((low[:, across] - np.array(where.box.lo)[across]) / size[across]).astype(int)
    columns, column = np.unique(index, axis=0, return_inverse=True)
    strata = np.stack(np.meshgrid(np.arange(m), np.arange(m), indexing="ij"), -1).reshape(-1, 1, 2)
    random = np.random.default_rng(seed(3 * m + axis)).random((len(columns), m * m, 2, 2))
    at = np.array(where.box.lo)[across] + (columns[:, None, None, :] + (strata + random) / m) * size[across]
    at = at.reshape(len(columns), -1, 2)
    lines = at.shape[1]
    sums, varied, uncounted, touches, touched = *np.zeros((2, len(columns) * lines)), 0, 0, 0.0
    each = max(1, _PIECES // lines)
    for start in range(0, len(low), each):
        tell(start, len(low))
        part = slice(start, start + each)
        starts = np.repeat(low[part], lines, axis=0)
        starts[:, across] = at[column[part]].reshape(-1, 2)
        met = rods.cross(starts, float(size[axis]), axis, np.repeat(sure[part, axis], lines), shortest)
        of_piece, of_crossing = count(met, starts)
        unknown = np.isnan(of_crossing)
        uncounted += int(np.count_nonzero(unknown))
        touches += met.open_ * met.early
        touched += met.open_ * met.open_length
        line = (column[part, None] * lines + np.arange(lines)).reshape(-1)
        sums += np.bincount(line, of_piece, len(sums))
        sums += np.bincount(line[met.piece], np.where(unknown, 0.0, of_crossing), len(sums))
        varied += np.bincount(line[met.piece], unknown, len(sums))
    stands_for = float(np.prod(size[across])) / (2 * m * m)
    pairs = (sums + varied).reshape(-1, 2)
    squares = float(((pairs[:, 0] - pairs[:, 1]) ** 2).sum())
    total, without, open_, length = (stands_for * n for n in (float(sums.sum()), uncounted, touches, touched))
    return Met(total, stands_for**2 * squares, without, open_, length, float(sums.max(initial=0.0)))


def _signed(r: Interval) -> NDArray[np.bool_]:
    """Where all of a range lies on one side of 0."""
    return np.asarray(((r.lo > 0) | (r.hi < 0)) & ~r.nan & ~r.empty)


def _threaded(work: Callable[[Indices], None], rows: Indices) -> None:
    """Work on rows in batches, on this process's threads."""
    parallel_for(work, [rows[start : start + _AT_ONCE] for start in range(0, len(rows), _AT_ONCE)], workers(None))
