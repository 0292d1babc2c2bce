"""Volumes, porosities and means by stratified sampling of the cells that enclosures leave undecided.

Cells that are provably inside or outside count exactly. Every other cell is cut into strata with two random points in
each: the estimate has no bias, no aliasing with the period of a lattice, and the difference of the two points of each
stratum tells its variance, which falls as N^(-4/3) for a solid with a smooth surface. Errors are three standard
deviations.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.bounds import Points, box_test
from porelang.analysis.enclose import EXACT
from porelang.backends.numpy import NumpyField
from porelang.data import Reduced
from porelang.diagnostics import fail
from porelang.formula import Formula
from porelang.ir import node
from porelang.tasks.numbers.region import (
    Region,
    empty,
    fast_enough,
    finer,
    finer_throughout,
    pairs,
    refuse_undefined,
    region,
    sorted_out,
    undefined,
)
from porelang.tasks.numbers.rods import Count, Counted, Crossings, Field, Indices, Rods, along

#: Three standard deviations of a porosity, or of a volume relative to itself, unless asked otherwise.
ACCURACY = 5e-4
#: The same of a mean, relative to the standard deviation of the field.
MEAN_ACCURACY = 2e-4
_PILOT = 1  # strata along a cell's side, to begin with
_MOST = 30_000_000  # samples; beyond it the error says what was reached
_MOST_PIECES = 2_000_000
_MOST_WORK = 200_000_000  # operations enclosed along lines by linear forms
_CELLS_OF_LINES = 20_000
_SHORTEST = 1e-9  # mm: what is left of lines then is far less than a wall of atoms
MOST_VALUES = 8_000_000  # samples whose values are kept
Values = NDArray[np.float64]


def volume(solid: Formula, accuracy: float = ACCURACY) -> Reduced:
    """The volume of a solid in mm^3."""
    return _share(solid, finer(solid, region(solid, "the solid")), accuracy, 0.0)


def _share(solid: Formula, where: Region, relative: float, goal: float) -> Reduced:
    """The volume of a solid in its cells, to within the greater of `relative` of itself and `goal` mm^3."""
    certain = where.certain + where.cell * len(where.inside)
    if not len(where.undecided):
        return Reduced(certain, 0.0)
    field = NumpyField(solid, fast_enough(solid, where))
    m, by_lines = _PILOT, None
    while True:
        hits = differ = 0
        for first, second in pairs(where.undecided, where.size, m):
            a, b = _inside(field, first), _inside(field, second)
            hits += int(np.count_nonzero(a)) + int(np.count_nonzero(b))
            differ += int(np.count_nonzero(a != b))
        weight = where.cell / m**3 / 2
        value = certain + weight * hits
        error = 3 * weight * math.sqrt(max(differ, 9))
        wanted = max(goal, relative * value)
        more = more_strata(m, error, wanted, len(where.undecided))
        if more is None:
            return by_lines if by_lines is not None and by_lines.error < error else Reduced(value, error)
        finest = m * math.sqrt(error / wanted) if wanted > 0 else math.inf
        if by_lines is None and 2 * len(where.undecided) * finest**3 > _MOST:
            by_lines = _by_lines(solid, where, relative, goal)
            if by_lines.error <= max(goal, relative * by_lines.value):
                return by_lines
            if by_lines.error < 9 * where.cell / finest_strata(len(where.undecided)) ** 3 / 2:
                return by_lines  # as many points as there may be state more, whatever they meet
        m = more


def _inside(field: NumpyField, points: Points) -> NDArray[np.bool_]:
    """Which points lie in a solid: where it is negative. Errors: E093 where it is not a number."""
    values = field.at(points)
    if np.isnan(values).any():
        raise undefined(points, values)
    return np.asarray(values < 0)


def _by_lines(solid: Formula, where: Region, relative: float, goal: float) -> Reduced:
    """The volume from how long lines are inside: of walls that random points hardly ever hit.

    Of each point the share n_i^2 counts for lines along the axis i, n the direction of the field's slope there; the
    three add up to 1. So a wall along a line, which that line hardly ever meets, and then for long, counts nothing for
    it, but for the lines that cross the wall. Where the field jumps at the end of a stretch its slope does not tell how
    the wall runs: all of such a stretch is in the error.
    """
    where = finer(solid, where, _CELLS_OF_LINES)  # so that a rod beside a plate is met too
    certain = where.certain
    field = Field.of(solid, where)
    m = 1
    while True:
        found = [along(field, i, m, _lengths(i, float(where.size[i])), _SHORTEST) for i in range(3)]
        value = certain + sum(f.total for f in found)
        # as if nine more lines had met the most that one has, and had not been seen; where none met anything, all of it
        stand_for = [float(np.prod(where.size)) / float(where.size[i]) / (2 * m * m) for i in range(3)]
        most = max(f.most for f in found) or float(where.size.max())
        error = 3 * math.sqrt(sum(f.variance for f in found) + 9 * (max(stand_for) * most) ** 2)
        error += sum(f.touched + f.doubtful for f in found)
        pieces = 6 * len(where.undecided) * (2 * m) ** 2
        if error <= max(goal, relative * value) or pieces > _MOST_PIECES:
            return Reduced(value, error)
        if sum(f.work for f in found) > _MOST_WORK / 4:
            return Reduced(value, error)
        m *= 2


def _lengths(axis: int, length: float) -> Count:
    """What each piece has inside, counted by the share of its axis at a random point of each stretch; doubtful are the
    stretches that end where the field jumps."""

    def count(rods: Rods, met: Crossings, starts: Points, random: np.random.Generator) -> Counted:
        piece, first, last, jumps = _stretches(met, starts, axis, length)
        at = starts[piece]
        at[:, axis] += first + random.random(len(piece)) * (last - first)
        share = rods.normals(at)[:, axis] ** 2
        share = np.where(np.isnan(share), 1 / 3, share)  # where the field has no slope the axes share alike
        counted = np.bincount(piece, share * (last - first), len(starts)).astype(np.float64)
        return Counted(counted, np.zeros(len(met.points)), float((last - first)[jumps].sum()))

    return count


def _stretches(
    met: Crossings, starts: Points, axis: int, length: float
) -> tuple[Indices, Values, Values, NDArray[np.bool_]]:
    """The stretches of pieces that are inside: the piece of each, where it begins and ends along it, and whether the
    field may jump at an end of it."""
    place = met.points[:, axis] - starts[met.piece, axis]
    order = np.lexsort((place, met.piece))
    piece, place, leaves, jumps = met.piece[order], place[order], met.leaves[order], met.jumps[order]
    follows = np.zeros(len(piece), np.bool_)
    follows[1:] = piece[1:] == piece[:-1]
    before = np.where(follows, np.concatenate([[0.0], place[:-1]]), 0.0)
    at_ends = jumps | (follows & np.concatenate([[False], jumps[:-1]]))
    # the last crossing of each piece, from where a stretch may go to the end: of several the last one stays
    final, jumping = np.zeros(len(starts)), np.zeros(len(starts), np.bool_)
    final[piece], jumping[piece] = place, jumps
    ending = np.nonzero(met.ends_inside)[0]
    return (
        np.concatenate([piece[leaves], ending]),
        np.concatenate([before[leaves], final[ending]]),
        np.concatenate([place[leaves], np.full(len(ending), length)]),
        np.concatenate([at_ends[leaves], jumping[ending]]),
    )


def more_strata(m: int, error: float, goal: float, cells: int, most_samples: int = _MOST) -> int | None:
    """How finely to cut the cells next (the error falls as the square of it), or None where it is fine enough."""
    if error <= goal:
        return None
    most = finest_strata(cells, most_samples)
    wanted = max(m + 1, math.ceil(1.1 * m * math.sqrt(error / goal))) if goal > 0 else most
    return None if m >= most else min(wanted, most)


def finest_strata(cells: int, most_samples: int = _MOST) -> int:
    """How finely cells are cut at most, along a side."""
    return max(1, int((most_samples / 2 / cells) ** (1 / 3)))


def porosity(solid: Formula, within: Formula, accuracy: float = ACCURACY) -> Reduced:
    """1 - volume(solid & within) / volume(within)."""
    where, whole = envelope(within, 0.3 * accuracy)
    if whole.value <= 0:
        raise empty("the region `within`")
    part = solid.with_roots(node("max", solid.root, within.root))
    refuse_undefined(part, where.box)
    seen = sorted_out(part, Region(where.box, where.size, np.empty((0, 3)), where.cells))
    found = _share(part, finer(part, seen), 0.0, 0.7 * accuracy * whole.value)
    share = found.value / whole.value
    error = (found.error + share * whole.error) / whole.value
    return Reduced(min(max(1 - share, 0.0), 1.0), error)  # its two volumes have errors of their own


@dataclass(frozen=True, slots=True)
class _Envelope:
    """A solid and the accuracy of its volume, the same as another of equal formula and bits: 0 and -0 are two."""

    within: Formula
    accuracy: float
    key: tuple[object, ...]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Envelope) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)


def envelope(within: Formula, accuracy: float) -> tuple[Region, Reduced]:
    """Where a solid is, and its volume: a `solve` asks for the same many times."""
    bound = (within.bindings[within.tape.nodes[i]] for i in within.tape.slots)
    read = tuple(v.hex() if isinstance(v, float) else v for v in bound)
    return _remembered(_Envelope(within, accuracy, (within.root, accuracy, read)))


@lru_cache(maxsize=16)
def _remembered(asked: _Envelope) -> tuple[Region, Reduced]:
    where = region(asked.within, "the region `within`")
    return where, _share(asked.within, finer(asked.within, where), asked.accuracy, 0.0)


def mean(field: Formula, within: Formula, accuracy: float = MEAN_ACCURACY) -> Reduced:
    """The mean of a field within a solid; the accuracy is relative to the field's standard deviation there.

    What all of `n` samples missed is less than a share of 9 / n, and there the field may be off the samples of its cell
    by as much as its enclosure over that cell allows: a spike that no sample met is in the error.
    """
    where = finer_throughout(within, region(within, "the region `within`"))
    lows, highs = box_test(field, EXACT)(where.cells, where.cells + where.size)
    bounded = bool(np.isfinite(lows).all() and np.isfinite(highs).all())
    m = _PILOT
    while True:
        values, inside = sampled(field, within, where, m)
        here = values[inside]
        with np.errstate(over="ignore", invalid="ignore"):
            middle, scatter = float(np.mean(here)), float(np.std(here))
        if not math.isfinite(scatter):
            raise fail("E093", "the values of this number are too large to be squared", hint="scale the field down")
        rest = np.where(inside, values - middle, 0.0)
        error = 3 * math.sqrt(float(np.sum((rest[0] - rest[1]) ** 2))) / len(here)
        if bounded:
            error += min(1.0, 9 / len(here)) * _farthest_off(values, inside, lows, highs)
        elif not scatter:  # all samples are alike, and there is no telling what lies between
            error = math.inf
        rounding = 2.0**-50 * float(np.abs(here).max())
        more = more_strata(m, error, accuracy * scatter + rounding, len(where.cells), MOST_VALUES)
        if more is None:
            return Reduced(middle, error + rounding)
        m = more


def _farthest_off(values: Values, inside: NDArray[np.bool_], lows: Values, highs: Values) -> float:
    """How far a field may be, within some cell, from all samples of that cell; over all of a cell without samples."""
    cells = len(lows)
    here = values.reshape(2, cells, -1).transpose(1, 0, 2).reshape(cells, -1)
    counts = inside.reshape(2, cells, -1).transpose(1, 0, 2).reshape(cells, -1)
    least = np.where(counts, here, np.inf).min(axis=1)
    most = np.where(counts, here, -np.inf).max(axis=1)
    none = ~counts.any(axis=1)
    off = np.where(none, highs - lows, np.maximum(highs - most, least - lows))
    return float(off.max())


def sampled(field: Formula, within: Formula, where: Region, m: int) -> tuple[Values, NDArray[np.bool_]]:
    """Values of a field at the two random points of each stratum, (2, n), and which of them lie within the solid.

    In float64: values have no bounds that float32 would be sure to hold. Outside the solid the values are 0.
    Errors: E092 where no point is inside, E093 where a value there is no number.
    """
    fence, looked_at = NumpyField(within, "f64"), NumpyField(field, "f64")
    values: list[list[Values]] = [[], []]
    inside: list[list[NDArray[np.bool_]]] = [[], []]
    for both in pairs(where.cells, where.size, m):
        for k, points in enumerate(both):
            within_it = np.asarray(fence.at(points) < 0)
            found = np.where(within_it, looked_at.at(points), 0.0)
            if not np.isfinite(found).all():
                raise undefined(points, found)
            values[k].append(found)
            inside[k].append(within_it)
    mask = np.stack([np.concatenate(part) for part in inside])
    if not mask.any():
        raise fail(
            "E092",
            "the region `within` of this number holds no material that can be sampled",
            hint="it is far thinner than it is wide",
        )
    return np.stack([np.concatenate(part) for part in values]), mask
