"""Cells over a frame, each with the bars that may be nearest somewhere in it: how a shader finds the nearest bar.

A shader that walks the tree keeps all of its lanes waiting for the one that walks furthest. Where bars lie close, a
cell about as large as the space between them has a dozen bars to try, one after the other. Cells with too many are left
to the tree, as is everything outside. What is tried holds every bar that the walk could end at: both give the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.data import Segments
from porelang.ops.derived import derived
from porelang.ops.segment_copies import held
from porelang.ops.segment_tree import EPSILON, limits_of, tree, walked
from porelang.parallel import parallel_for, workers

Ints = NDArray[np.int32]
#: Cells for each bar, at least and at most in all; the bars that a cell may list.
PER_BAR, LEAST_CELLS, MOST_CELLS, MOST_BARS = 3.0, 1 << 12, 1 << 21, 40
#: Frames of fewer bars are walked as quickly.
FEWEST = 4
#: How far the box of a frame is widened, in its longest side: what is drawn lies near its surface.
ROOM = 0.02
AT_ONCE = 1 << 13


@dataclass(frozen=True, eq=False)
class Cells:
    """Cubes of `size` mm from `lo`, `shape` of them along each axis; the places in the tree of the bars of cell k are
    `places[starts[k] : starts[k + 1]]`, none where the tree is to be walked."""

    lo: NDArray[np.float64]
    size: float
    shape: tuple[int, int, int]
    starts: Ints
    places: Ints


def cells(bars: Segments) -> Cells | None:
    """The cells of a frame, or of the period in which its places are sought, made once; None where it has too few bars
    for it to pay."""
    return derived(bars, "cells", lambda: _make(bars)) if len(held(bars)) >= FEWEST else None


def _make(bars: Segments) -> Cells:
    from porelang.ops import segment_ranges as loops

    near = held(bars)
    limits, made = limits_of(near), tree(near, np.float64)
    half = None if bars.period is None else np.array(bars.period) / 2
    lo, hi = (limits.lo, limits.hi) if half is None else (-half, half)
    room = ROOM * float((hi - lo).max()) + 1e-9
    lo, hi = lo - room, hi + room
    wanted = min(max(PER_BAR * len(near), LEAST_CELLS), MOST_CELLS / 2)
    size = float(np.prod(hi - lo) / wanted) ** (1 / 3)
    counts = np.maximum(1, np.ceil((hi - lo) / size).astype(int))
    while np.prod(counts) > MOST_CELLS:
        size *= 1.1
        counts = np.maximum(1, np.ceil((hi - lo) / size).astype(int))
    shape = (int(counts[0]), int(counts[1]), int(counts[2]))
    total = int(np.prod(counts))
    listed, number = np.empty((total, MOST_BARS), np.int32), np.empty(total, np.int32)
    # a place is counted to a cell by float32: it may lie a little outside
    reach = size * (0.5 + 1e-3) + 8 * EPSILON * float(np.abs(np.concatenate([lo, hi])).max())
    slack = 4.04 * EPSILON * (limits.coordinate + 8 * (float(np.linalg.norm(hi - lo)) + limits.radius + limits.length))

    def fill(first: int) -> None:
        last = min(first + AT_ONCE, total)
        centre = lo + (np.stack(np.unravel_index(np.arange(first, last), shape), 1) + 0.5) * size
        x, y, z = centre.T
        (index,) = walked(near, x, y, z, ("index",))
        at = limits.places[np.asarray(index, np.int64)]
        loops.candidates(made, np.ascontiguousarray(centre), reach, at, slack, listed[first:last], number[first:last])

    parallel_for(fill, range(0, total, AT_ONCE), workers())
    number[number > MOST_BARS] = 0
    starts = np.concatenate([[0], np.cumsum(number)]).astype(np.int32)
    return Cells(lo, size, shape, starts, listed[np.arange(MOST_BARS) < number[:, None]])


def lists(bars: Segments, dtype: np.dtype[Any]) -> Any:
    """The cells of bars as the compiled loops take them (`segment_loops.Lists`)."""
    return derived(bars, ("lists", dtype.str), lambda: _lists(bars, dtype))


def _lists(bars: Segments, dtype: np.dtype[Any]) -> Any:
    from porelang.ops import segment_loops as loops

    found = cells(bars)
    if found is None:
        return loops.Lists(
            np.zeros(3, dtype), np.zeros(1, dtype), (0, 0, 0), np.empty(0, np.int32), np.empty(0, np.int32)
        )
    rate = np.array([1.0 / found.size], dtype)
    return loops.Lists(found.lo.astype(dtype), rate, found.shape, found.starts, found.places)


def header(found: Cells | None, at: int) -> tuple[list[Any], list[Any]]:
    """What a shader is told of cells: whole numbers (where they begin, the shape) and floats (lo, 1 / size)."""
    if found is None:
        return [0, 0, 0, 0], [0.0, 0.0, 0.0, 0.0]
    return [at, *found.shape], [*found.lo, 1.0 / found.size]
