"""Data as shaders read them: one buffer of 32-bit words, whole numbers and float32, of the same values as NumPy's.

A sampled field: nx, ny, nz, components; origin, 1 / spacing, end (3 floats each); 3 words unused; then the values from
word 16 on, as in the array. Segments: the numbers of groups and leaves, `top`; the `scale` of `segment_loops.Tree` (3
floats); the first word of the period (0: there is none) and one unused; the first word of the cells (0: there are none)
and their number along each axis; their lowest corner and 1 / size (4 floats); then from word 16 on the tree's boxes (56
words a group), bars (64 a leaf), frames (4 a place), ids (1 a place), the `starts` and `places` of the cells
(`segment_cells.Cells`), the period (3 floats), 1 / period (3 floats), and of each bar which of the cell it is
(`segment_copies.Copies`).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.data import Data, SampledField
from porelang.ops.derived import derived
from porelang.ops.segment_cells import cells, header
from porelang.ops.segment_copies import copies

Words = NDArray[np.uint32]


def words(data: Data) -> Words:
    """The words of a data slot, made once. Errors: ValueError where there is no bar."""
    return derived(data, "words", lambda: _field(data) if isinstance(data, SampledField) else _segments(data))


def _field(grid: SampledField) -> Words:
    places = np.array([grid.origin, 1.0 / np.array(grid.spacing), grid.end])
    return _joined([*grid.shape, grid.components], places, np.zeros(3), grid.values)


def _segments(bars: Any) -> Words:
    from porelang.ops.segments import tree

    made, found = tree(bars, np.float32), cells(bars)
    first = 16 + sum(part.size for part in (made.boxes, made.bars, made.frames, made.ids))
    where, place = header(found, first)
    # a group's box has 7 rows of 8: the words of a group are 56
    more: list[NDArray[Any]] = [] if found is None else [found.starts, found.places]
    repeats = 0
    if bars.period is not None:
        repeats = first + sum(part.size for part in more)
        period = np.array(bars.period)
        more += [period, 1.0 / period, copies(bars).of]
    head = [len(made.boxes), len(made.bars), made.top]
    whole, again = np.array(where, np.int32), np.array([repeats, 0], np.int32)
    return _joined(head, made.scale, again, whole, np.array(place), made.boxes, made.bars, made.frames, made.ids, *more)


def _joined(whole: list[int], *parts: NDArray[Any]) -> Words:
    """Whole numbers, then arrays one after the other, floats in single precision."""
    with np.errstate(over="ignore"):
        flat: list[NDArray[Any]] = [np.array(whole, np.int32)]
        flat += [np.ascontiguousarray(p, np.int32 if p.dtype.kind == "i" else np.float32).reshape(-1) for p in parts]
    made = np.concatenate([p.view(np.uint32) for p in flat])
    made.flags.writeable = False
    return made
