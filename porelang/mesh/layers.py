"""A grid clipped at a box: the layers of nodes that the contour sees, so that a cap lies exactly on the bound.

Cutting a field by `max(f, distance to the box)` on the nodes bevels every rim by up to a voxel. Instead the nodes
outside the box are replaced, along each axis, by two layers at the bound: one inside it by a hair, with the field
interpolated between the nodes on either side, and one outside that is void. A cap is then flat and on the bound, and
the edges of the box are sharp to that hair.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.diagnostics import fail
from porelang.mesh.grid import Grid, Index, Point, place

Sample = Callable[[Index, Index], NDArray[Any]]
Values = NDArray[np.floating[Any]]

HAIR = 2**-12  # of a voxel: how near a vertex may come to a node, so that no triangle vanishes
FLOAT32 = 2**-20  # of the largest coordinate: eight steps of float32, so that none vanishes in an STL file either
WIDEST_HAIR = 2**-6


@dataclass(frozen=True, slots=True, eq=False)
class Axis:
    """The layers along one axis: void, bound, nodes..., bound, void.

    `at` are their coordinates (mm), `rim` the same with the layers at the bounds put exactly there. Layer `i` holds the
    field at the grid's nodes `node[i]` and `node[i] + 1`, mixed by `weight[i]`; `inside[i]` is the one in the box, and
    `last[i]` the last one that has a weight.
    """

    lo: float
    hi: float
    at: NDArray[np.float64]
    rim: NDArray[np.float64]
    node: NDArray[np.int64]
    weight: NDArray[np.float64]
    inside: NDArray[np.int64]
    last: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.at)


@dataclass(frozen=True, slots=True, eq=False)
class Layers:
    """The layers along x, y and z; `hair` (mm) is the least distance of a vertex from the end of its edge."""

    grid: Grid
    axes: tuple[Axis, Axis, Axis]
    hair: float

    @property
    def shape(self) -> Index:
        x, y, z = (len(a) for a in self.axes)
        return x, y, z

    def nodes(self, lo: Index, hi: Index) -> tuple[Index, Index]:
        """The range of the grid's nodes that the block of layers `lo..hi` is made of."""
        x, y, z = ((int(axis.node[a]), int(axis.last[b - 1]) + 1) for axis, a, b in zip(self.axes, lo, hi, strict=True))
        return (x[0], y[0], z[0]), (x[1], y[1], z[1])

    def point(self, index: Index) -> Point:
        """The place of one node of the layers, mm."""
        x, y, z = (float(axis.rim[i]) for axis, i in zip(self.axes, index, strict=True))
        return x, y, z

    def read(self, sample: Sample, lo: Index, hi: Index) -> tuple[Values, Values]:
        """The field on the block `lo..hi`, and the samples on the grid's nodes that it was made of.

        E110 if the field is not a number somewhere in the box.
        """
        first, last = self.nodes(lo, hi)
        samples = np.asarray(sample(first, last))
        expected = tuple(b - a for a, b in zip(first, last, strict=True))
        if samples.shape != expected:
            raise ValueError(f"the sampler gave an array of shape {samples.shape} for nodes of shape {expected}")
        if samples.dtype not in (np.float32, np.float64):
            samples = samples.astype(np.float64)
        values = samples
        ends: list[tuple[slice | list[int], ...]] = []
        for n, (axis, a, b, start) in enumerate(zip(self.axes, lo, hi, first, strict=True)):
            if a <= 1 or b >= len(axis) - 1:
                values = _mix(values, n, axis, a, b, start)
                ends.append((*[slice(None)] * n, [i - a for i in (0, len(axis) - 1) if a <= i < b]))
        for end in ends:
            values[end] = np.abs(values[end])
        if np.isnan(values.min()):
            x, y, z = (int(i) for i in np.argwhere(np.isnan(values))[0])
            raise fail(
                "E110",
                f"the field is not a number at {place(self.point((x + lo[0], y + lo[1], z + lo[2])))}",
                hint="look for a division by zero, or a square root, logarithm or power of a negative number there",
            )
        return values, samples

    def wider(self, lo: Index, hi: Index, margin: int) -> tuple[Index, Index]:
        """The block `lo..hi` with some layers more on every side, where there are such."""
        x, y, z = ((max(a - margin, 0), min(b + margin, n)) for a, b, n in zip(lo, hi, self.shape, strict=True))
        return (x[0], y[0], z[0]), (x[1], y[1], z[1])

    def inner(self, lo: Index, hi: Index) -> tuple[slice, slice, slice]:
        """The part of the block `lo..hi` without the void layers at the bounds."""
        x, y, z = (
            slice(int(a == 0), b - a - int(b == len(axis))) for axis, a, b in zip(self.axes, lo, hi, strict=True)
        )
        return x, y, z


def clip(grid: Grid, lo: Point, hi: Point) -> Layers:
    """The layers of a grid that covers the box `lo..hi` (mm), cut at the box."""
    reach = max(abs(c) for c in (*lo, *hi))
    hair = min(max(HAIR * grid.spacing, FLOAT32 * reach), WIDEST_HAIR * grid.spacing)
    x, y, z = (_axis(at, a, b, hair) for at, a, b in zip(grid.axes(), lo, hi, strict=True))
    return Layers(grid, (x, y, z), hair)


def _axis(nodes: NDArray[np.float64], lo: float, hi: float, hair: float) -> Axis:
    if not (nodes[0] <= lo < hi <= nodes[-1]):
        raise ValueError(f"the nodes from {nodes[0]} to {nodes[-1]} do not cover the bounds {lo} to {hi}")
    inset = min(8 * hair, (hi - lo) / 4)
    kept = np.flatnonzero((nodes >= lo + 2 * inset) & (nodes <= hi - 2 * inset))
    ends = np.array([lo + inset, hi - inset])
    below = np.clip(np.searchsorted(nodes, ends, side="right") - 1, 0, len(nodes) - 2)
    if kept.size:  # a node that was dropped for lying in the inset must not leave a gap in what a block reads
        below = np.array([kept[0] - 1, kept[-1]])
    weight = np.clip((ends - nodes[below]) / (nodes[below + 1] - nodes[below]), 0.0, 1.0)
    at = np.concatenate([[lo - inset, ends[0]], nodes[kept], [ends[1], hi + inset]])
    rim = np.concatenate([[lo, lo], nodes[kept], [hi, hi]])
    node = np.concatenate([below[[0, 0]], kept, below[[1, 1]]]).astype(np.int64)
    inside = np.concatenate([below[[0, 0]] + 1, kept, below[[1, 1]]]).astype(np.int64)
    weights = np.concatenate([weight[[0, 0]], np.zeros(len(kept)), weight[[1, 1]]])
    return Axis(lo, hi, at, rim, node, weights, inside, node + (weights > 0))


def _mix(values: Values, n: int, axis: Axis, a: int, b: int, start: int) -> Values:
    """The layers `a..b` of an axis from values on nodes that begin with `start`."""
    mixed: Values = np.take(values, axis.node[a:b] - start, axis=n)
    for i in np.flatnonzero(axis.weight[a:b] > 0):
        weight = float(axis.weight[a + i])
        near, far = (values.take(axis.node[a + i] - start + k, axis=n) for k in (0, 1))
        with np.errstate(invalid="ignore", over="ignore"):
            layer = (1 - weight) * near + weight * far
        # A field may end at the bounds: beyond them it need not be a number.
        layer = np.where(np.isfinite(layer), layer, values.take(axis.inside[a + i] - start, axis=n))
        mixed[(slice(None),) * n + (i,)] = layer
    return mixed
