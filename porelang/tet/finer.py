"""Cubes that are made finer where a mesh misses its part: halved there, and once more if that does not do.

The frame stays where it is, so that all other cubes stay as they are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from porelang.tet.frame import Frame
from porelang.tet.lattice import Lattice
from porelang.tet.octree import Cells, Decided, Parted, graded, uniform
from porelang.tet.sizes import Sizes

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

ROUND, TOO = 3.0, 1.0  # cubes round those that were parted: so far all is meshed anew, and looked at
GRID = 192  # places along each axis, at most, of what is near
TIMES = 2  # that cubes are halved at most
TURNS = 4  # as halved cubes may show what larger ones did not
MANY = 0.25  # of the cubes at a surface: where more miss it the size is too large for the part, not for some places


class Region:
    """What lies within `far` cubes of some of a lattice's cubes: known on a grid, as boxes are asked in millions."""

    def __init__(self, lattice: Lattice, some: Ints, far: float) -> None:
        frame = lattice.frame
        counts = np.minimum(frame.counts, GRID)
        self.lo, self.step = frame.lo, (frame.hi - frame.lo) / counts
        marked = np.zeros(counts, np.bool_)
        side = frame.edges * (1 << lattice.cells.level[some].astype(np.int64))[:, None]
        low = frame.lo + lattice.cells.index[some] * side
        first, last = self._places(low - far * side, low + (1 + far) * side, counts)
        for (i, j, k), (u, v, w) in zip(first.tolist(), last.tolist(), strict=True):
            marked[i : u + 1, j : v + 1, k : w + 1] = True
        self.sums = np.zeros(counts + 1, np.int64)
        self.sums[1:, 1:, 1:] = marked.cumsum(0).cumsum(1).cumsum(2)

    def _places(self, lo: Floats, hi: Floats, counts: Ints) -> tuple[Ints, Ints]:
        first, last = (np.floor((at - self.lo) / self.step).astype(np.int64) for at in (lo, hi))
        return np.clip(first, 0, counts - 1), np.clip(last, 0, counts - 1)

    def meets(self, lo: Floats, hi: Floats) -> Flags:
        """Which boxes (n, 3) .. (n, 3) mm it reaches."""
        first, last = self._places(lo, hi, np.array(self.sums.shape) - 1)
        ends = first, last + 1
        total = np.zeros(len(lo), np.int64)
        for x, y, z in np.ndindex(2, 2, 2):  # of the sums at a box's corners, with signs, what is in it is left
            total += (-1) ** (x + y + z + 1) * self.sums[ends[x][:, 0], ends[y][:, 1], ends[z][:, 2]]
        return total > 0


@dataclass(frozen=True, slots=True)
class Grading:
    """Cubes of a frame, at most 2^coarsest of the finest large, but those that are `parted` further. `least` (mm) are
    the finest that were asked for."""

    frame: Frame
    coarsest: int
    least: float
    parted: Parted = ()

    def cells(self, sizes: Sizes, decided: Decided, whole: bool, region: Region | None = None) -> Cells:
        """The cubes that a part may reach, or all of the frame if the `whole` is wanted; beyond a `region`, where there
        is one, they are as large as they come."""
        if not self.coarsest:
            return uniform(self.frame, decided, whole)
        if region is not None:
            decided, whole = _beyond(region, decided), False

        def at(points: Floats) -> Floats:
            return np.maximum(sizes.at(points), self.least)

        surface = max(sizes.surface, self.least)
        return graded(self.frame, decided, at, surface, self.coarsest, whole, self.parted)

    def large(self, lattice: Lattice, some: Ints) -> Ints:
        """Those of some of a lattice's cubes that may be parted."""
        level = lattice.cells.level[some].astype(np.int64)
        found: Ints = some[float(self.frame.edges.min()) * (1 << level) > self.least / 2**TIMES * (1 + 1e-9)]
        return found

    def parting(self, lattice: Lattice, some: Ints) -> Grading:
        """The same with some more of a lattice's cubes parted."""
        level, index = lattice.cells.level[some].astype(np.int64), lattice.cells.index[some]
        frame, up = self.frame, int((level == 0).any())
        if up:
            frame = replace(frame, edges=frame.edges / 2, counts=frame.counts * 2)
        more = tuple((int(n) + up, index[level == n]) for n in np.unique(level))
        before = tuple((n + up, cubes) for n, cubes in self.parted)
        return Grading(frame, self.coarsest + up, self.least, (*before, *more))


def _beyond(region: Region, decided: Decided) -> Decided:
    """What is known of boxes, with all beyond a region void: it is not looked at."""

    def known(lo: Floats, hi: Floats) -> NDArray[np.int8]:
        found = np.full(len(lo), np.int8(-1))
        some = np.flatnonzero(region.meets(lo, hi))
        found[some] = np.maximum(decided(lo[some], hi[some]), 0)
        return found

    return known
