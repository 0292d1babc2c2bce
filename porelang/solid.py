"""A part as its meshers ask it: signs at points and on axes, slopes, what boxes may hold; in float64."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.bounds import BoxTest, box_test, slopes
from porelang.analysis.enclose import EXACT
from porelang.backends.numpy import NumpyField
from porelang.data import Triple
from porelang.formula import Formula

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
_BISECTIONS = 40
GUESSES = 40  # points along a side, to tell at a glance what volume there is
AT_ONCE = 4096  # boxes that are enclosed in one call


class Solid:
    """The solid of a formula, cut flat at a box (mm)."""

    def __init__(self, formula: Formula, cut: tuple[Triple, Triple]) -> None:
        self.formula = formula
        self.lo, self.hi = np.array(cut[0]), np.array(cut[1])

    @cached_property
    def _field(self) -> NumpyField:
        return NumpyField(self.formula, "f64")

    @cached_property
    def _sloped(self) -> NumpyField:
        return NumpyField(self.formula.with_roots(self.formula.root, *slopes(self.formula.root)), "f64")

    @cached_property
    def enclosed(self) -> BoxTest:
        """The least and greatest value of the field in boxes (n, 3) .. (n, 3)."""
        return box_test(self.formula, EXACT)

    def decided(self, lo: Floats, hi: Floats) -> NDArray[np.int8]:
        """What an enclosure says of boxes (n, 3) .. (n, 3): 1 all solid, -1 all void, 0 not known."""
        inside = ((lo >= self.lo) & (hi <= self.hi)).all(axis=1)
        outside = ((hi < self.lo) | (lo > self.hi)).any(axis=1)
        low, high = np.empty(len(lo)), np.empty(len(lo))
        for i in range(0, len(lo), AT_ONCE):
            low[i : i + AT_ONCE], high[i : i + AT_ONCE] = self.enclosed(lo[i : i + AT_ONCE], hi[i : i + AT_ONCE])
        return np.where(outside | (low > 0), -1, np.where(inside & (high < 0), 1, 0)).astype(np.int8)

    @cached_property
    def guess(self) -> tuple[float, float]:
        """The volume (mm3), by points, one by chance in every cell of the box; and what three sigmas of that are."""
        size = self.hi - self.lo
        cells = np.stack(np.meshgrid(*[np.arange(GUESSES)] * 3, indexing="ij"), -1).reshape(-1, 3)
        points = self.lo + (cells + np.random.default_rng(0).random(cells.shape)) * size / GUESSES
        share, whole = float(self.holds(points).mean()), float(np.prod(size))
        return share * whole, 3 * whole * (share * (1 - share) / len(cells)) ** 0.5

    def within(self, points: Floats) -> Flags:
        """Which points (n, 3) lie in the box."""
        return np.asarray(((points >= self.lo) & (points <= self.hi)).all(axis=1))

    def holds(self, points: Floats) -> Flags:
        """Which points (n, 3) are solid."""
        return np.asarray(self._field.at(points) < 0) & self.within(points)

    def lacks(self, points: Floats) -> Flags:
        """Which points (n, 3) of the box are void."""
        return np.asarray(self._field.at(points) > 0) & self.within(points)

    def value(self, points: Floats) -> Floats:
        """The field (n,) at points (n, 3), without the cut."""
        return np.asarray(self._field.at(points))

    def on(self, axes: Sequence[Floats]) -> Flags:
        """Which nodes of three axes are solid."""
        return self.values_on(axes) < 0

    def values_on(self, axes: Sequence[Floats]) -> Floats:
        """The field on the nodes of three axes; infinite beyond the cut."""
        values: Floats = np.asarray(self._field.on_grid(axes).all())
        for n, axis in enumerate(axes):
            np.moveaxis(values, n, 0)[(axis < self.lo[n]) | (axis > self.hi[n])] = np.inf
        return values

    def slope(self, points: Floats) -> tuple[Floats, Floats]:
        """The field (n,) at points (n, 3), without the cut, and its gradient (n, 3)."""
        found = np.asarray(self._sloped.at(points))
        return found[:, 0], found[:, 1:]

    def walls(self, points: Floats, reach: float, steps: int, void: bool = False) -> tuple[Floats, Floats, Floats]:
        """The walls that points on or near the surface stand on: how thick (mm, across the surface; NaN where there is
        none within `reach`), the cosine between the outward directions on its two sides, and the places on the other.

        The other side is looked for at `steps` distances that grow by the same factor, from a millionth of the reach
        on, so that a wall is missed only behind one that is thinner by more than that factor. Of the `void` they are
        the gaps that points stand on, bounded by the part on both sides.
        """
        value, slope = self.slope(points)
        with np.errstate(all="ignore"):
            steep = np.linalg.norm(slope, axis=1)
            out = slope / steep[:, None]
            start = points - (value / steep)[:, None] * out
        out, inner = (-out, self.lacks) if void else (out, self.holds)
        rows = np.flatnonzero(np.isfinite(start).all(axis=1))
        thick, facing = np.full(len(points), np.nan), np.full(len(points), np.nan)
        far = np.full((len(points), 3), np.nan)
        last = np.full(len(rows), 1e-6 * reach)
        seen = inner(start[rows] - last[:, None] * out[rows])
        rows, last = rows[seen], last[seen]
        for distance in reach * np.geomspace(1e-6, 1.0, steps)[1:]:
            inside = inner(start[rows] - distance * out[rows])
            left = rows[~inside]
            thick[left], far[left, 0] = distance, last[~inside]
            rows, last = rows[inside], np.full(int(inside.sum()), distance)
        found = np.flatnonzero(np.isfinite(thick))
        near, high = far[found, 0].copy(), thick[found].copy()
        for _ in range(_BISECTIONS if len(found) else 0):
            middle = (near + high) / 2
            inside = inner(start[found] - middle[:, None] * out[found])
            near, high = np.where(inside, middle, near), np.where(inside, high, middle)
        thick[found] = high
        far[found] = start[found] - high[:, None] * out[found]
        with np.errstate(all="ignore"):
            _, other = self.slope(far[found])
            facing[found] = np.einsum("ij,ij->i", other, out[found]) / np.linalg.norm(other, axis=1)
        if void:  # what ends at the cut has one side
            facing[found] *= -1
            ended = found[~self.holds(far[found] - 1e-6 * reach * out[found])]
            thick[ended], facing[ended] = np.nan, np.nan
        return thick, facing, far


def onto(solid: Solid, points: Floats, steps: int, most: float) -> Floats:
    """Points after some Newton steps of at most `most` mm towards the surface; NaN where there is no slope."""
    at = points.copy()
    for _ in range(steps):
        value, slope = solid.slope(at)
        with np.errstate(all="ignore"):
            step = -(value / np.einsum("ij,ij->i", slope, slope))[:, None] * slope
            length = np.linalg.norm(step, axis=1)
            at += step * np.minimum(1.0, most / np.maximum(length, 1e-300))[:, None]
    return at
