"""Which cubes fill a frame: as large as is asked, smaller where they are parted; and regions of some of them.

The frame stays where it is as cubes are parted, so that all others stay as they are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from porelang.tet.frame import Frame
from porelang.tet.octree import TESTED, Cells, Decided, Parted, graded, uniform
from porelang.tet.sizes import Sizes

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

ROUNDED = 1e-6  # cubes: a region ends before the next
GRID = 192  # places along each axis, at most, of what is near
TIMES = 2  # that cubes are halved at most


class Region:
    """What lies within `far` of their edges of some cubes: known on a grid, as boxes are asked in millions."""

    def __init__(self, cells: Cells, frame: Frame, far: float) -> None:
        counts = np.minimum(frame.counts, GRID)
        self.lo, self.step = frame.lo, (frame.hi - frame.lo) / counts
        marked = np.zeros(counts, np.bool_)
        low, high = cells.boxes(frame)
        more = (far - ROUNDED) * (high - low)
        first, last = self._places(low - more, high + more, counts)
        for (i, j, k), (u, v, w) in zip(first.tolist(), last.tolist(), strict=True):
            marked[i : u + 1, j : v + 1, k : w + 1] = True
        self.sums = np.zeros(counts + 1, np.int32)
        self.sums[1:, 1:, 1:] = marked.cumsum(0, np.int32).cumsum(1).cumsum(2)

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
        if not self.coarsest and region is None:
            return uniform(self.frame, decided, whole)

        def at(points: Floats) -> Floats:
            return np.maximum(sizes.at(points), self.least)

        least = self.coarsest + TESTED if sizes.even and sizes.surface == np.inf else 1
        if region is not None:
            decided, whole, least = _within(region), False, 1
        sized, surface = max(sizes.even, self.least) if sizes.even else at, max(sizes.surface, self.least)
        cells = graded(self.frame, decided, sized, surface, self.coarsest, whole, self.parted, least)
        return cells if region is None else cells.taken(region.meets(*cells.boxes(self.frame)))

    def large(self, cells: Cells) -> Flags:
        """Which of its cubes may be parted."""
        edges = float(self.frame.edges.min()) * (1 << cells.level.astype(np.int64))
        return np.asarray(edges > self.least / 2**TIMES * (1 + 1e-9))

    def parting(self, cells: Cells) -> Grading:
        """The same with some more of its cubes parted."""
        frame, up = self.frame, int((cells.level == 0).any())
        if up:
            frame = replace(frame, edges=frame.edges / 2, counts=frame.counts * 2)
        more = tuple((int(n) + up, cells.index[cells.level == n]) for n in np.unique(cells.level))
        before = tuple((n + up, cubes) for n, cubes in self.parted)
        return Grading(frame, self.coarsest + up, self.least, (*before, *more))


def _within(region: Region) -> Decided:
    """What is known of boxes where all beyond a region counts as void: it is not looked at."""
    return lambda lo, hi: np.where(region.meets(lo, hi), np.int8(0), np.int8(-1))
