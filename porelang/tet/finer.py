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

TIMES = 2  # that cubes are halved at most
TURNS = 4  # as halved cubes may show what larger ones did not
MANY = 0.25  # of the cubes at a surface: where more miss it the size is too large for the part, not for some places


@dataclass(frozen=True, slots=True)
class Grading:
    """Cubes of a frame, at most 2^coarsest of the finest large, but those that are `parted` further. `least` (mm) are
    the finest that were asked for."""

    frame: Frame
    coarsest: int
    least: float
    parted: Parted = ()

    def cells(self, sizes: Sizes, decided: Decided, whole: bool) -> Cells:
        """The cubes that a part may reach, or all of the frame if the `whole` is wanted."""
        if not self.coarsest:
            return uniform(self.frame, decided, whole)

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
