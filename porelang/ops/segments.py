"""The nearest of many bars: the distance from its surface, and what else is known of it, from one walk of a tree.

The nearest bar is the one of the least distance to its axis minus its radius; where several tie, that of the lowest
number. A coordinate that is not a number gives NaN everywhere; infinitely far away the distance is infinite and all
else NaN.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.data import Segments
from porelang.ops.derived import derived
from porelang.ops.points import points

Values = NDArray[Any]
#: What one walk finds: the distance from the surface (negative inside), its gradient (the unit vector from the foot on
#: the axis to the point, 0 on the axis), the unit direction of the bar, where along it the foot is (0..1), and the
#: bar's radius, length and number.
RESULTS = ("distance", "nx", "ny", "nz", "dx", "dy", "dz", "along", "radius", "length", "index")


def nearest(
    bars: Segments,
    x: Any,
    y: Any,
    z: Any,
    wanted: Sequence[str] = RESULTS,
    out: Sequence[Values] | None = None,
) -> tuple[Values, ...]:
    """The wanted results (in the order of RESULTS) at coordinates in mm that broadcast, in their type.

    `out` holds an array for each of them. Errors: ValueError where there is no bar, or `out` does not fit.
    """
    from porelang.ops import segment_loops as loops

    at = points(x, y, z)
    mask = sum(1 << RESULTS.index(name) for name in set(wanted))
    found = np.empty((len(set(wanted)), int(np.prod(at.shape))), at.dtype)
    loops.nearest(tree(bars, at.dtype), mask, at.x, at.y, at.z, found, at.loops)
    results = tuple(row.reshape(at.shape) for row in found)
    if out is None:
        return results
    for place, values in zip(out, results, strict=True):
        if place.shape != at.shape or place.dtype != at.dtype:
            raise ValueError(f"out is {place.dtype} {place.shape}, the result {at.dtype} {at.shape}")
        place[...] = values
    return tuple(out)


def tree(bars: Segments, dtype: Any) -> Any:
    """The tree over bars in a working type (`segment_loops.Tree`). Errors: ValueError where there is no bar."""
    kind = np.dtype(dtype)
    return derived(bars, ("tree", kind.str), lambda: _make_tree(bars, kind))


def _make_tree(bars: Segments, dtype: np.dtype[Any]) -> Any:
    from porelang.ops import segment_loops as loops

    count, wide = len(bars), loops.WIDE
    if count == 0:
        raise ValueError("there is no bar")
    depth = max(0, (-(-count // wide) - 1).bit_length())
    leaves, levels = 1 << depth, -(-depth // 3)
    top = 1 << (depth - 3 * (levels - 1)) if levels else 0
    order, starts = derived(bars, "order", lambda: loops.arrange((bars.starts + bars.ends) / 2, depth))
    leaf = np.repeat(np.arange(leaves), np.diff(starts))
    place = leaf * wide + np.arange(count) - starts[leaf]
    packed, frames = np.zeros((leaves * wide, 8), dtype), np.zeros((leaves * wide, 4), dtype)
    ids = np.full(leaves * wide, np.iinfo(np.int32).max, np.int32)
    packed[:, 6] = -np.inf
    ids[place] = order
    with np.errstate(over="ignore", divide="ignore"):
        mine = np.column_stack([bars.starts, bars.ends, bars.radii])[order].astype(dtype)
        # of the rounded bar; one that rounding has shrunk to a point is met at its start
        square = ((mine[:, 3:6].astype(np.float64) - mine[:, 0:3]) ** 2).sum(axis=1)
        inverse = np.where(square > 0, 1.0 / square, 0.0).astype(dtype)
        packed[place, :7], packed[place, 7] = mine, np.where(np.isfinite(inverse), inverse, 0.0)
        axis = (bars.ends - bars.starts)[order]
        length = np.sqrt((axis**2).sum(axis=1))
        frames[place] = np.column_stack([axis / length[:, None], length])
    lanes = np.ascontiguousarray(packed.reshape(leaves, wide, 8).transpose(0, 2, 1))
    boxes = np.empty(((1 + top * (8 ** (levels - 1) - 1) // 7) if levels else 0, 7, wide), dtype)
    boxes[:, :3], boxes[:, 3:] = np.inf, -np.inf
    loops.bound(boxes, lanes, top)
    scale = np.array([np.abs(mine).max(), 16 * np.finfo(dtype).eps, np.finfo(dtype).max], dtype)
    return loops.Tree(boxes, lanes, frames, ids, scale, top)
