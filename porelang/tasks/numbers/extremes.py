"""The least and the greatest value of a field within a solid, by branch and bound on enclosures: the gap is proven.

A good value is sought first, by climbing from samples, so that most cells are cut at once. A cell goes when its natural
enclosure, the centred form, or a quadratic with its enclosed curvature shows that it holds nothing greater, or when it
lies inside the solid and the field rises across it. Of a lattice one turn of its phases is searched for what it can
be at all: if that is attained within the solid, nothing is left to do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.bounds import Points, box_test, slopes
from porelang.analysis.box import Box
from porelang.analysis.enclose import EXACT, boxes, enclose
from porelang.analysis.phases import over_phases
from porelang.backends.numpy import NumpyField
from porelang.data import Reduced
from porelang.diagnostics import fail
from porelang.formula import Formula
from porelang.interval import INF, Interval
from porelang.ir import node
from porelang.progress import tell
from porelang.rewrites.simplify import tidy
from porelang.tape import operations
from porelang.tasks.numbers.region import Region, finer_throughout, halves, region, undefined

#: The proven gap, relative to the range of values met.
ACCURACY = 1e-4
_LEVELS = 40
_MOST = 2_000_000  # cells looked at; beyond it the gap says what was given up
_AT_ONCE = 4096
_PROBES = 8
_CLIMBERS, _STEPS, _TRIES = 64, 60, 8
_CURVED = 400  # operations: of longer formulas the second derivatives cost more than smaller cells
Values = NDArray[np.float64]


def minimum(field: Formula, within: Formula) -> Reduced:
    """The least value of a field where `within < 0`, approached at a point; the error is one-sided."""
    found = maximum(field.with_roots(node("neg", field.root)), within)
    return Reduced(-found.value, found.error)


def maximum(field: Formula, within: Formula) -> Reduced:
    """The greatest value of a field where `within < 0`, approached at a point; the error is one-sided.

    Errors: E092 where no point of the solid is found, E093 where the field is not a number there.
    """
    where = finer_throughout(within, region(within, "the region `within`"))
    hill = Hill(field)
    fence = NumpyField(within, "f64")
    best, least = hill.climb(where, fence)
    goal = ACCURACY * max(best - least, 1e-12 * abs(best))
    phases = over_phases(field)
    if phases is not None:
        ceiling = _over_a_turn(phases)
        if ceiling <= best + goal:
            return Reduced(best, max(ceiling - best, 0.0))
    best, top = _search(hill, Fence(within, fence), where, best, goal)
    return Reduced(best, max(top - best, 0.0))


@dataclass(frozen=True, slots=True)
class Fence:
    """A solid within which a field is looked at: its field, and whether boxes reach into it or lie inside."""

    solid: Formula
    field: NumpyField

    def sides(self, low: Points, high: Points) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Which boxes may hold a point of the solid, and which lie strictly inside it."""
        least, most = box_test(self.solid, EXACT)(low, high)
        return least < 0, most < 0


class Hill:
    """A field with its slopes and, if its formula is short, its curvatures: at points, and enclosed over boxes."""

    def __init__(self, field: Formula):
        self.field = field
        steep = slopes(field.root)
        self.slopes = field.with_roots(*steep)
        self.sloped = field.with_roots(field.root, *steep)
        curved = tidy([c for i, s in enumerate(steep) for c in slopes(s)[i:]])
        self.curvatures = field.with_roots(*curved) if operations(curved) <= _CURVED else None
        self.value = NumpyField(field, "f64")
        self.slope = NumpyField(self.slopes, "f64")

    def best_of(self, points: Points, fence: NumpyField | None) -> float:
        """The greatest value among the points within the solid; -inf if none is. Errors: E093."""
        if fence is not None and len(points):
            points = points[fence.at(points) < 0]
        values = self.at(points)
        return float(values.max(initial=-np.inf))

    def at(self, points: Points) -> Values:
        values = np.asarray(self.value.at(points))
        if np.isnan(values).any():
            raise undefined(points, values)
        return values

    def climb(self, where: Region, fence: NumpyField | None) -> tuple[float, float]:
        """The greatest value that climbers reach from the best of many samples, and the least that was sampled.

        A climber tries random steps and one up the slope, and takes the best; its stride grows when it gets on and
        shrinks when not. Errors: E092 where no sample is in the solid, E093.
        """
        random = np.random.default_rng(7)
        cells = where.cells
        probes = (cells[:, None, :] + random.random((len(cells), _PROBES, 3)) * where.size).reshape(-1, 3)
        probes = np.concatenate([probes, cells + where.size / 2])
        if fence is not None:
            probes = probes[fence.at(probes) < 0]
        if not len(probes):
            raise fail(
                "E092",
                "the region `within` of this number holds no point that could be found",
                hint="it is far thinner than it is wide",
            )
        values = self.at(probes)
        least = float(values.min())
        first = np.argsort(-values)[:_CLIMBERS]
        points, values = probes[first], values[first]
        stride = np.full(len(points), 0.5)
        for _ in range(_STEPS):
            slope = self.slope.at(points) * where.size**2
            with np.errstate(all="ignore"):
                up = slope / np.linalg.norm(slope / where.size, axis=1)[:, None]
            up = np.where(np.isfinite(up), up, 0.0)
            steps = random.normal(size=(len(points), _TRIES, 3)) * where.size
            steps[:, 0] = up
            steps[:, 1] = 0.3 * up
            tried = (points[:, None, :] + stride[:, None, None] * steps).reshape(-1, 3)
            heights = np.asarray(self.value.at(tried))
            allowed = ~np.isnan(heights)
            if fence is not None:
                allowed &= fence.at(tried) < 0
            heights = np.where(allowed, heights, -np.inf).reshape(-1, _TRIES)
            choice = heights.argmax(1)
            rows = np.arange(len(points))
            better = heights[rows, choice] > values
            points = np.where(better[:, None], tried.reshape(-1, _TRIES, 3)[rows, choice], points)
            values = np.where(better, heights[rows, choice], values)
            stride = np.where(better, 1.5 * stride, 0.5 * stride)
        return float(values.max()), least

    def highs(self, low: Points, size: Values, enough: float) -> tuple[Values, NDArray[np.bool_]]:
        """The greatest that the field can be in each cell, and whether it may be flat somewhere in it.

        Cells whose natural enclosure is below `enough` are not looked at any closer.
        """
        out = np.full(len(low), INF)
        flat = np.ones(len(low), np.bool_)
        for start in range(0, len(low), _AT_ONCE):
            part = slice(start, start + _AT_ONCE)
            out[part] = _top(enclose(self.field, boxes(low[part], low[part] + size))[0].range, len(low[part]))
        rest = np.nonzero(out > enough)[0]
        for start in range(0, len(rest), _AT_ONCE):
            self._closer(low, size, enough, rest[start : start + _AT_ONCE], out, flat)
        return out, flat

    def _closer(
        self, low: Points, size: Values, enough: float, some: NDArray[np.int64], out: Values, flat: NDArray[np.bool_]
    ) -> None:
        """The bounds `out` of some cells drawn in by derivatives, and `flat` unset where a slope keeps its sign."""
        corner, middle = low[some], low[some] + size / 2
        box = boxes(corner, corner + size)
        value, *slope = enclose(self.sloped, box)
        known = [_opened(s.range, len(some)) for s in slope]
        smooth = np.broadcast_to(~value.jumps, len(some))
        reach = np.sum([np.maximum(np.abs(a), np.abs(b)) * size[i] / 2 for i, (a, b) in enumerate(known)], axis=0)
        centre = np.asarray(self.value.at(middle))
        rounding = 2.0**-44 * (np.abs(centre) + np.where(np.isfinite(reach), reach, 0.0))
        with np.errstate(all="ignore"):
            linear = np.where(smooth & np.isfinite(centre), centre + reach + rounding, INF)
        out[some] = np.minimum(out[some], np.where(np.isnan(linear), INF, linear))
        flat[some] = ~smooth | np.all([(a <= 0) & (b >= 0) for a, b in known], axis=0)
        if self.curvatures is not None:
            left = np.nonzero(smooth & (out[some] > enough) & flat[some])[0]
            if len(left):
                bound = self._quadratic(
                    [_some(b, left) for b in box], middle[left], centre[left] + rounding[left], size
                )
                out[some[left]] = np.minimum(out[some[left]], bound)

    def _quadratic(self, box: list[Interval], middle: Points, centre: Values, size: Values) -> Values:
        """The top of f(c) + g.d + d.Hd / 2 over all d, where every H that the enclosures allow is negative definite.

        With H = M + E, M the middles and |E| at most the radii, d.Hd <= d.Md + |R| d.d, |R| the norm of the radii.
        """
        assert self.curvatures is not None
        entries = [_opened(e.range, len(middle)) for e in enclose(self.curvatures, box)]
        jumps = [e.jumps for e in enclose(self.slopes, box)]
        matrix, radius = np.zeros((2, len(middle), 3, 3))
        with np.errstate(all="ignore"):
            for (i, j), (a, b) in zip([(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)], entries, strict=True):
                matrix[:, i, j] = matrix[:, j, i] = (a + b) / 2
                radius[:, i, j] = radius[:, j, i] = (b - a) / 2
        usable = (
            np.isfinite(matrix).all((1, 2))
            & np.isfinite(radius).all((1, 2))
            & ~np.any([np.broadcast_to(j, len(middle)) for j in jumps], axis=0)
        )
        out = np.full(len(middle), INF)
        if not usable.any():
            return out
        scale = size / size.max()  # cells of unlike sides: distances along each axis are counted in its own
        matrix = matrix[usable] * scale[:, None] * scale
        spread = np.sqrt(((radius[usable] * scale[:, None] * scale) ** 2).sum((1, 2)))
        bends, axes = np.linalg.eigh(matrix)
        bends = bends + spread[:, None] + 1e-12 * np.abs(bends).max(1)[:, None]
        slope = self.slope.at(middle[usable]) * scale
        along = np.einsum("nij,ni->nj", axes, slope)
        with np.errstate(all="ignore"):
            rise = (along**2 / (-2 * bends)).sum(1)
        out[usable] = np.where((bends < 0).all(1) & np.isfinite(rise), centre[usable] + rise * (1 + 1e-9), INF)
        return out


def _some(r: Interval, rows: NDArray[np.int64]) -> Interval:
    """Some of many intervals."""
    return Interval(r.lo[rows], r.hi[rows], r.nan[rows])


def _opened(r: Interval, count: int) -> tuple[Values, Values]:
    """The ends of ranges; without an end where the value may not be a number."""
    unsure = r.nan | r.empty
    return (
        np.broadcast_to(np.where(unsure, -INF, r.lo), count),
        np.broadcast_to(np.where(unsure, INF, r.hi), count),
    )


def _top(r: Interval, count: int) -> Values:
    return _opened(r, count)[1]


def _search(hill: Hill, fence: Fence | None, where: Region, best: float, goal: float) -> tuple[float, float]:
    """The greatest value found and a bound on all values, from the cells of a region halved level by level."""
    low, size = where.cells, where.size
    looked = 0
    for level in range(_LEVELS):
        tell(level, _LEVELS)
        highs, flat = hill.highs(low, size, best + goal)
        looked += len(low)
        keep = highs > best + goal
        if fence is not None and keep.any():
            some = np.nonzero(keep)[0]
            reach, inside = fence.sides(low[some], low[some] + size)
            keep[some] = reach & (flat[some] | ~inside)
        low, highs = low[keep], highs[keep]
        if not len(low):
            return best, best + goal
        best = max(best, hill.best_of(low + size / 2, fence.field if fence is not None else None))
        if looked + 8 * len(low) > _MOST:
            break
        low, size = halves(low, size), size / 2
    return best, max(best + goal, float(highs.max()))


def _over_a_turn(phases: Formula) -> float:
    """A bound on a field of phases, over one turn of each."""
    hill = Hill(phases)
    steps = np.stack(np.meshgrid(*(np.arange(8) / 8,) * 3, indexing="ij"), -1).reshape(-1, 3)
    whole = Region(Box((0.0,) * 3, (1.0,) * 3), np.full(3, 1 / 8), steps, np.empty((0, 3)))
    best, least = hill.climb(whole, None)
    return _search(hill, None, whole, best, ACCURACY / 2 * max(best - least, 1e-12 * abs(best)))[1]
