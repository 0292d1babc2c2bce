"""The cubic through samples at all points of another grid: one axis after the other, as it is a product of three.

Each value is that of `lookup_cubic` but for rounding; a point takes twelve products instead of sixty-four.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import prod

import numpy as np
from numpy.typing import NDArray

from porelang.data import SampledField
from porelang.ops.grid import lookup_cubic

Values = NDArray[np.float64]


def on_grid(field: SampledField, axes: Sequence[Values], orders: tuple[int, int, int] = (0, 0, 0)) -> Values:
    """All components (k, nx, ny, nz) of the cubic, or of a derivative of it, at the points of a grid."""
    from porelang.tasks.phase.loops import fourfold

    values = np.ascontiguousarray(np.moveaxis(field.values, -1, 0), np.float64)
    for axis in (2, 1, 0):
        nodes, weights = _four(field, axis, axes[axis], orders[axis])
        shape = values.shape
        before, inner = prod(shape[: axis + 1]), prod(shape[axis + 2 :])
        out = np.empty((before, len(nodes), inner))
        fourfold(values.reshape(before, -1, inner), nodes, weights, out)
        values = out.reshape(*shape[: axis + 1], len(nodes), *shape[axis + 2 :])
    return values


def _four(field: SampledField, axis: int, at: Values, order: int) -> tuple[NDArray[np.int64], Values]:
    """The four nodes that the cubic reads at each place along an axis, and what each counts: nothing if not there.

    Of fields that are 1 at every fourth node, each has one of them among the four.
    """
    count, origin, spacing = field.shape[axis], field.origin[axis], field.spacing[axis]
    fourth = (np.arange(count)[:, None] % 4 == np.arange(4))[:, None, None] * np.ones((1, 2, 2, 1))
    line = SampledField.from_array(fourth, (origin, 0.0, 0.0), (spacing, 1.0, 1.0))
    middle = np.full(len(at), 0.5)
    read = np.stack([lookup_cubic(line, at, middle, middle, (c, order, 0, 0)) for c in range(4)], 1)
    cell = np.clip(np.floor((at - origin) / spacing), 0, count - 2).astype(np.int64)
    nodes = cell[:, None] + np.arange(-1, 3)
    there = (nodes >= 0) & (nodes < count)
    return np.where(there, nodes, 0), np.where(there, np.take_along_axis(read, nodes % 4, 1), 0.0)
