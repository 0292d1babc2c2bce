"""What is proven of a field in each cell of a box, so that a ray takes the longest steps that miss nothing.

Cells are halved where they may hold surface; in those that are left the slopes are enclosed, which bounds the gradient.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.bounds import box_test, slopes, steepest
from porelang.analysis.box import Box
from porelang.analysis.enclose import boxes, enclose
from porelang.formula import Formula
from porelang.parallel import parallel_for, workers

Points = NDArray[np.float64]
VOID, SOLID, STEEP = 0.0, -1.0, 1e30
#: Cells along the longest side at first, and at most.
COARSEST, FINEST = 8, 64
#: Enclosures of single operations that one picture may cost: about 2 seconds.
BUDGET = 60_000_000
AT_ONCE = 4096


@dataclass(frozen=True, slots=True)
class Cells:
    """For each cell of a box: VOID, SOLID, a bound on |grad f| per mm, or STEEP where the field may jump."""

    box: Box
    values: NDArray[np.float32]

    @property
    def counts(self) -> tuple[int, int, int]:
        nx, ny, nz = self.values.shape
        return nx, ny, nz

    @property
    def empty(self) -> bool:
        """Whether it is proven that nothing solid lies in the box."""
        return not self.values.any()


def bound_cells(part: Formula, box: Box, budget: int = BUDGET) -> Cells:
    """The cells of a box, as fine as a budget of enclosures allows for the length of the program."""
    part = part.taken
    sloped = part.with_roots(part.root, *slopes(part.root))
    test = box_test(part)
    longest = max(box.size)
    counts = tuple(max(1, round(COARSEST * s / longest)) for s in box.size)
    values = np.full(counts, np.nan, np.float32)
    cost, spent = len(part.tape), 0
    while True:
        left = np.argwhere(np.isnan(values))
        if not len(left):
            return Cells(box, values)
        found = np.empty(len(left), np.float32)

        lows, highs = _corners(box, values.shape, left)

        def look(some: slice, lows: Points = lows, highs: Points = highs, found: NDArray[np.float32] = found) -> None:
            low, high = test(lows[some], highs[some])
            found[some] = np.where(low > 0, VOID, np.where(high < 0, SOLID, np.nan))

        parallel_for(look, _pieces(len(left)), workers())
        values[tuple(left.T)] = found
        spent += cost * len(left)
        undecided = 8 * int(np.isnan(found).sum())
        if 2 * max(values.shape) > FINEST or spent + 3 * cost * undecided > budget:
            break
        for axis in range(3):
            values = np.repeat(values, 2, axis=axis)
    left = np.argwhere(np.isnan(values))
    steep = np.empty(len(left), np.float32)

    def bound(some: slice) -> None:
        steep[some] = _steepest(sloped, *_corners(box, values.shape, left[some]))

    parallel_for(bound, _pieces(len(left)), workers())
    values[tuple(left.T)] = steep
    return Cells(box, values)


def _pieces(count: int) -> list[slice]:
    return [slice(start, start + AT_ONCE) for start in range(0, count, AT_ONCE)]


def _corners(box: Box, counts: tuple[int, ...], which: NDArray[np.intp]) -> tuple[Points, Points]:
    """Lower and upper corners (n, 3) of cells, a little further apart than they are: rays round."""
    edge = np.array(box.size) / counts
    lo = np.array(box.lo) + which * edge
    slack = 1e-5 * edge + 4e-7 * np.maximum(np.abs(box.lo), np.abs(box.hi))
    return lo - slack, lo + edge + slack


def _steepest(sloped: Formula, lo: Points, hi: Points) -> NDArray[np.float64]:
    """A bound on the gradient of the first root, whose slopes are the others, over boxes; STEEP where it may jump."""
    value, *slope = enclose(sloped, boxes(lo, hi))
    # a margin for what float32 rounds; 0 would mean that the cell is void
    return np.clip(1.001 * steepest(value, slope), 1e-20, STEEP)
