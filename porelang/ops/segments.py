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

    count = len(bars)
    if count == 0:
        raise ValueError("there is no bar")
    depth = max(0, (-(-count // loops.LEAF) - 1).bit_length())
    order, starts = derived(bars, "order", lambda: loops.arrange((bars.starts + bars.ends) / 2, depth))
    with np.errstate(over="ignore", divide="ignore"):
        packed = np.empty((count, 8), dtype)
        packed[:, 0:3], packed[:, 3:6], packed[:, 6] = bars.starts[order], bars.ends[order], bars.radii[order]
        # of the rounded bar; one that rounding has shrunk to a point is met at its start
        axis = packed[:, 3:6].astype(np.float64) - packed[:, 0:3]
        square = (axis**2).sum(axis=1)
        packed[:, 7] = np.where(square > 0, 1.0 / square, 0.0)
        packed[:, 7] = np.where(np.isfinite(packed[:, 7]), packed[:, 7], 0.0)
        axis = (bars.ends - bars.starts)[order]
        length = np.sqrt((axis**2).sum(axis=1))
        frames = np.column_stack([axis / length[:, None], length]).astype(dtype)
    nodes = np.zeros((2 << depth, 8), dtype)
    loops.bound(nodes, starts, packed)
    largest = max(float(np.abs(packed[:, :6]).max()), float(packed[:, 6].max()))
    scale = np.array([largest, 16 * np.finfo(dtype).eps], dtype)
    return loops.Tree(nodes, starts, packed, frames, order, scale)
