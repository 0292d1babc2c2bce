"""Where lines along an axis meet a solid's surface, within its undecided cells: crossings proven, not seen.

A piece of a line holds one crossing if the field changes its sign there and is proven not to fall, or not to rise,
throughout; none if it is proven to keep its sign. Any other piece is cut just before and after a crossing, or halved,
until it is shorter than `SHORTEST`, so that walls far thinner than any grid are met. What is open then and has the same
sign at both ends is taken for a touch, which counts nothing. Where halving proves next to nothing, so that more than
`_MOST` times as many are open as there were pieces, they are counted as they are; those that may be touches are told.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.bounds import LONGEST, Points, slopes
from porelang.analysis.enclose import boxes, enclose
from porelang.analysis.linear import SHORT, has_rules, linear
from porelang.backends.numpy import NumpyField
from porelang.formula import Formula
from porelang.interval import Interval
from porelang.ir import Node
from porelang.parallel import parallel_for, workers
from porelang.progress import tell
from porelang.tasks.numbers.brackets import last_inside
from porelang.tasks.numbers.nearby import in_groups
from porelang.tasks.numbers.region import Region, seed

SHORTEST = 1e-6  # mm, or `_HALVINGS` halvings of the lines through a part that is tiny itself
_HALVINGS = 10
_BEFORE_A_CUT = 2  # halvings of a piece that changes its sign, before it is cut at a crossing, where slopes are proven
_CLOSER = 3  # halvings more, where linear forms prove slopes (of a lattice's true distance from a tenth of a mm on)
_WORTH = 0.05  # of the pieces that are left: slopes that prove less are not asked for again
_MOST = 8  # open parts of a piece, on average
_AT_ONCE = 8192
_PIECES = 1 << 15
Values = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Crossings:
    """Points (n, 3) where pieces of lines meet the surface, the piece each lies on, whether the line leaves there, and
    whether the field may jump there, so that its slope says nothing of the surface.

    `ends_inside` says of each piece whether its far end lies in the solid. `open_` counts the parts of pieces, each of
    `open_length` mm, that may hold a wall for all that is proven; `early` if halving ended before they were short.
    `work` is how many operations were enclosed by linear forms.
    """

    points: Points
    piece: Indices
    leaves: NDArray[np.bool_]
    jumps: NDArray[np.bool_]
    ends_inside: NDArray[np.bool_]
    open_: int
    open_length: float
    early: bool
    work: int = 0


class Rods:
    """A solid's field and slopes, ready for lines."""

    def __init__(self, solid: Formula):
        self.solid = solid
        self.slopes = slopes(solid.root)
        self.sloped = solid.with_roots(solid.root, *self.slopes)
        self.along = [solid.with_roots(solid.root, s) for s in self.slopes]
        ruled = all(has_rules(f.tape) and len(f.tape) <= LONGEST for f in self.along)
        self.ruled = ruled and len(self.solid.tape) > SHORT
        self.field = NumpyField(solid, "f64", 1)
        self.slope = NumpyField(solid.with_roots(*self.slopes), "f64", 1)

    def rising(self, low: Points, size: Values) -> NDArray[np.bool_]:
        """Whether the field is proven never to fall, or never to rise, along each axis in each cell, (n, 3)."""
        out = np.zeros((len(low), 3), np.bool_)
        for some in _batches(np.arange(len(low))):
            value, *slope = enclose(self.sloped, boxes(low[some], low[some] + size))
            for i, s in enumerate(slope):
                out[some, i] = _one_way(s.range) & ~value.jumps
        return out

    def cross(self, low: Points, length: float, axis: int, sure: NDArray[np.bool_], shortest: float) -> Crossings:
        """Where pieces of lines from `low`, `length` mm along an axis, meet the surface; `sure` where the field is
        proven to go one way along the piece, `shortest` how short parts of which nothing is proven get (mm)."""
        high = low.copy()
        high[:, axis] += length
        at_low, at_high = self.field.at(low) < 0, self.field.at(high) < 0
        ends_inside = at_high
        line = np.arange(len(low))
        found: list[tuple[Points, NDArray[np.bool_], Indices, NDArray[np.bool_]]] = []

        def meet(some: NDArray[np.bool_], jumps: NDArray[np.bool_]) -> None:
            at = last_inside(self.field, low[some], high[some], at_low[some])
            found.append((at, at_low[some], line[some], jumps))

        once = (at_low != at_high) & sure
        meet(once, np.zeros(np.count_nonzero(once), np.bool_))
        low, high, line = low[~sure], high[~sure], line[~sure]
        at_low, at_high = at_low[~sure], at_high[~sure]
        unproven, early = 0, False
        most = max(_MOST * len(at_low), _AT_ONCE)
        halvings = max(_HALVINGS, math.ceil(math.log2(length / shortest)))
        slopes, closely, work = True, False, 0
        for halving in range(halvings + 1):
            if not len(low):
                break
            changes = at_low != at_high
            if closely:  # a slope is worth it where there is a crossing
                one_way, none, jumps = self._closely(low, high, axis, changes)
                work += len(low) * len(self.solid.tape)
            else:
                # slopes of which the first halvings prove nothing are hardly proven by more: they are longer formulas
                one_way, none, jumps = self._proven(low, high, axis, slopes)
                slopes = halving < _HALVINGS and bool(np.count_nonzero(one_way) >= _WORTH * np.count_nonzero(~none))
                closely = self.ruled and not slopes
            last = halving == halvings or len(low) > most
            once = changes & (one_way | last)
            meet(once, jumps[once])
            open_ = ~none & ~one_way & (not last)
            if last:
                unproven = int(np.count_nonzero(~none & ~one_way & ~changes))
                length /= 2**halving
                early = halving < halvings
            ripe = halving >= _BEFORE_A_CUT + _CLOSER * closely or not (slopes or closely)
            cut = np.flatnonzero(open_ & changes) if ripe else line[:0]
            at, before, after = self._apart(low[cut], high[cut], at_low[cut], axis, length / 2 ** (halvings + 1))
            held = ((self.field.at(before) < 0) == at_low[cut]) & ((self.field.at(after) < 0) == at_high[cut])
            cut, at, before, after = cut[held], at[held], before[held], after[held]
            if len(cut):
                jumps = np.broadcast_to(enclose(self.solid, boxes(before, after))[0].jumps, len(cut))
                found.append((at, at_low[cut], line[cut], jumps))
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
        met, inside, line, jumps = (np.concatenate([f[k] for f in found]) for k in range(4))
        return Crossings(met, line, inside, jumps, ends_inside, unproven, length, early, work)

    def _apart(
        self, low: Points, high: Points, inside: NDArray[np.bool_], axis: int, short: float
    ) -> tuple[Points, Points, Points]:
        """A crossing of each piece, and points just before and after it: where two faces meet, a distance has a kink,
        and its slope no sign, however often it is halved; but to either side of the crossing it is proven at once."""
        met = last_inside(self.field, low, high, inside)
        before, after = met.copy(), met.copy()
        before[:, axis] = np.maximum(low[:, axis], met[:, axis] - short)
        after[:, axis] = np.minimum(high[:, axis], met[:, axis] + short)
        return met, before, after

    def _proven(
        self, low: Points, high: Points, axis: int, slopes: bool
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
        """Which pieces are crossed once at most, which not at all, and in which the field may jump."""
        one_way, none, jumps = np.zeros((3, len(low)), np.bool_)

        for some in _batches(np.arange(len(low))):
            value = enclose(self.solid, boxes(low[some], high[some]))[0]
            none[some] = ((value.range.lo >= 0) | (value.range.hi < 0)) & ~value.range.nan
            jumps[some] = value.jumps
        for some in _batches(np.flatnonzero(~none)) if slopes else ():
            value, slope = enclose(self.along[axis], boxes(low[some], high[some]))
            one_way[some] = _one_way(slope.range) & ~value.jumps
        return one_way, none, jumps

    def _closely(
        self, low: Points, high: Points, axis: int, changes: NDArray[np.bool_]
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
        """What `_proven` tells, by linear forms: slopes are looked at where the field changes its sign alone."""
        one_way, none, jumps = self._proven(low, high, axis, False)
        for some in _batches(np.flatnonzero(~none & ~changes)):
            value = linear(self.solid, boxes(low[some], high[some]))[0]
            none[some] = ((value.range.lo >= 0) | (value.range.hi < 0)) & ~value.range.nan
        for some in _batches(np.flatnonzero(~none & changes)):
            value, slope = linear(self.along[axis], boxes(low[some], high[some]))
            one_way[some] = _one_way(slope.range) & ~value.jumps
        return one_way, none, jumps

    def normals(self, points: Points) -> Points:
        """The unit normals of the surface at its points; not a number where the field has no slope there."""
        slope = self.slope.at(points)
        with np.errstate(all="ignore"):
            slope = slope / np.abs(slope).max(axis=1)[:, None]  # what is steep or flat beyond measure can be squared
            return np.asarray(slope / np.linalg.norm(slope, axis=1)[:, None])


@dataclass(frozen=True, slots=True)
class Field:
    """The field of a solid in the undecided cells of a region: groups of cells by their rows, each with the field near
    them, and where that is `sure` to go one way along each axis, (n, 3)."""

    where: Region
    groups: tuple[tuple[Indices, Rods], ...]
    sure: NDArray[np.bool_]

    @classmethod
    def of(cls, solid: Formula, where: Region) -> Field:
        sure = np.zeros((len(where.undecided), 3), np.bool_)
        alike: dict[Node, tuple[Formula, list[Indices]]] = {}
        for rows, local in in_groups(solid, where.undecided, where.size):
            alike.setdefault(local.root, (local, []))[1].append(rows)
        groups = [(np.concatenate(rows), Rods(local)) for local, rows in alike.values()]

        def look(group: tuple[Indices, Rods]) -> None:
            rows, rods = group
            sure[rows] = rods.rising(where.undecided[rows], where.size)

        parallel_for(look, groups, workers())
        return cls(where, tuple(groups), sure)


@dataclass(frozen=True, slots=True)
class Met:
    """Sums over all lines along an axis: of what was counted of each, and the crossings left out, with the variance of
    both together. `most` is the most that was counted of a line, `doubtful` what was counted though it may be wrong.

    `touches` counts the parts of lines of which nothing was proven when halving ended early, `touched` sums the lengths
    of all of which nothing was proven; both stand for areas as the others do. `work` is how many operations were
    enclosed by linear forms.
    """

    total: float
    variance: float
    uncounted: float
    touches: float
    touched: float
    most: float
    doubtful: float
    work: int


@dataclass(frozen=True, slots=True)
class Counted:
    """What a batch of pieces adds: to each piece, and to the piece of each crossing (NaN where that is not known); and
    how much of it is doubtful."""

    pieces: Values
    crossings: Values
    doubtful: float = 0.0


#: What is counted of the pieces from some points, with random numbers of their own.
Count = Callable[[Rods, Crossings, Points, np.random.Generator], Counted]


def along(field: Field, axis: int, m: int, count: Count, shortest: float = SHORTEST) -> Met:
    """What random lines along an axis meet, in mm^2 times what is counted of each line; two lines in each of m^2 strata
    of every column of cells.

    A line runs through all cells of its column: a surface that leaves one cell for the next is met all the same.
    """
    where = field.where
    low, size = where.undecided, where.size
    across = [i for i in range(3) if i != axis]
    index = np.rint((low[:, across] - np.array(where.box.lo)[across]) / size[across]).astype(int)
    columns, column = np.unique(index, axis=0, return_inverse=True)
    strata = np.stack(np.meshgrid(np.arange(m), np.arange(m), indexing="ij"), -1).reshape(-1, 1, 2)
    random = np.random.default_rng(seed(3 * m + axis)).random((len(columns), m * m, 2, 2))
    at = np.array(where.box.lo)[across] + (columns[:, None, None, :] + (strata + random) / m) * size[across]
    at = at.reshape(len(columns), -1, 2)
    lines = at.shape[1]
    each = max(1, _PIECES // lines)
    parts = [(rows[i : i + each], rods) for rows, rods in field.groups for i in range(0, len(rows), each)]
    done: list[tuple[Crossings, Counted] | None] = [None] * len(parts)
    ended: list[int] = []

    def meet(k: int) -> None:
        rows, rods = parts[k]
        starts = np.repeat(low[rows], lines, axis=0)
        starts[:, across] = at[column[rows]].reshape(-1, 2)
        met = rods.cross(starts, float(size[axis]), axis, np.repeat(field.sure[rows, axis], lines), shortest)
        done[k] = met, count(rods, met, starts, np.random.default_rng((seed(3 * m + axis), k)))
        ended.append(k)
        tell(len(ended), len(parts))

    parallel_for(meet, range(len(parts)), workers())
    sums, varied, uncounted, touches, touched, doubtful = *np.zeros((2, len(columns) * lines)), 0, 0, 0.0, 0.0
    work = 0
    for (rows, _), found in zip(parts, done, strict=True):
        assert found is not None
        met, counted = found
        unknown = np.isnan(counted.crossings)
        uncounted += int(np.count_nonzero(unknown))
        touches += met.open_ * met.early
        touched += met.open_ * met.open_length
        doubtful += counted.doubtful
        work += met.work
        line = (column[rows, None] * lines + np.arange(lines)).reshape(-1)
        sums += np.bincount(line, counted.pieces, len(sums))
        sums += np.bincount(line[met.piece], np.where(unknown, 0.0, counted.crossings), len(sums))
        varied += np.bincount(line[met.piece], unknown, len(sums))
    stands_for = float(np.prod(size[across])) / (2 * m * m)
    pairs = (sums + varied).reshape(-1, 2)
    squares = float(((pairs[:, 0] - pairs[:, 1]) ** 2).sum())
    total, without, open_, length, wrong = (
        stands_for * n for n in (float(sums.sum()), uncounted, touches, touched, doubtful)
    )
    return Met(total, stands_for**2 * squares, without, open_, length, float(sums.max(initial=0.0)), wrong, work)


def _one_way(r: Interval) -> NDArray[np.bool_]:
    """Where no two numbers of a range have different signs: what never falls changes sides once, if it is level too."""
    return np.asarray(((r.lo >= 0) | (r.hi <= 0)) & ~r.nan & ~r.empty)


def _batches(rows: Indices) -> Iterator[Indices]:
    for start in range(0, len(rows), _AT_ONCE):
        yield rows[start : start + _AT_ONCE]
