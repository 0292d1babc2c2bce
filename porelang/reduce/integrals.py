"""Volumes, porosities and means by stratified sampling of the cells that enclosures leave undecided.

Cells that are provably inside or outside count exactly. Every other cell is cut into strata with two random points in
each: the estimate has no bias, no aliasing with the period of a lattice, and the difference of the two points of each
stratum tells its variance, which falls as N^(-4/3) for a solid with a smooth surface. Errors are three standard
deviations.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.backends.numpy import NumpyField
from porelang.diagnostics import fail
from porelang.ir import Node, node
from porelang.passes.bounds import Points, box_test
from porelang.passes.box import Box, part_box, unbounded_axes
from porelang.passes.enclose import EXACT

#: Three standard deviations of a porosity, or of a volume relative to that of its region, unless asked otherwise.
ACCURACY = 5e-4
_CELLS = 24  # along the longest side of the box
_PILOT = 2  # strata along a cell's side, to begin with
_MOST = 200_000_000  # samples


@dataclass(frozen=True, slots=True)
class Reduced:
    """A number found from fields, and its error: the true value lies within `value +- error`."""

    value: float
    error: float


@dataclass(frozen=True, slots=True)
class Region:
    """The cells of a box, of equal size: corners of those decided to be inside, and of those undecided."""

    box: Box
    size: NDArray[np.float64]
    inside: Points
    undecided: Points

    @property
    def cell(self) -> float:
        return float(np.prod(self.size))


def region(root: Node, params: Mapping[str, float], what: str = "the region") -> Region:
    """Where a solid is. Errors: E091 where it has no end, E092 where it is empty."""
    box = part_box(root, params)
    if box is None:
        raise fail("E092", f"{what} of this number holds no material", hint="solid is negative: check its sign")
    if axes := unbounded_axes(box):
        raise fail(
            "E091",
            f"{what} of this number has no end along {axes}",
            hint="intersect it with a shape: `... & cylinder(75, 300)`",
        )
    size = np.array(box.size)
    counts = np.maximum(1, np.ceil(_CELLS * size / size.max())).astype(int)
    step = size / counts
    index = np.stack(np.meshgrid(*(np.arange(c) for c in counts), indexing="ij"), -1).reshape(-1, 3)
    low = np.array(box.lo) + index * step
    least, most = box_test(root, params, EXACT)(low, low + step)
    return Region(box, step, low[most < 0], low[(least <= 0) & (most >= 0)])


def volume(root: Node, params: Mapping[str, float], accuracy: float = ACCURACY) -> Reduced:
    """The volume of a solid in mm^3."""
    where = region(root, params, "the solid")
    share = _share(root, where, params, accuracy * _whole(where))
    return share


def _whole(where: Region) -> float:
    """The volume in sight: what the accuracy is relative to."""
    return where.cell * (len(where.inside) + len(where.undecided))


def _share(root: Node, where: Region, params: Mapping[str, float], goal: float) -> Reduced:
    """The volume of a solid in its cells, to within `goal` mm^3."""
    certain = where.cell * len(where.inside)
    if not len(where.undecided):
        return Reduced(certain, 0.0)
    field = NumpyField(root, params, "f32")
    m = _PILOT
    while True:
        a, b = (_inside(field, p) for p in _pairs(where.undecided, where.size, m))
        weight = where.cell / m**3 / 2
        value = certain + weight * float(np.count_nonzero(a) + np.count_nonzero(b))
        error = 3 * weight * math.sqrt(max(float(np.count_nonzero(a != b)), 9.0))
        finer = _finer(m, error, goal, len(where.undecided))
        if finer is None:
            return Reduced(value, error)
        m = finer


def _inside(field: NumpyField, points: Points) -> NDArray[np.bool_]:
    return np.asarray(field.at(points) <= 0)


def _finer(m: int, error: float, goal: float, cells: int) -> int | None:
    """How finely to cut the cells next (the error falls as the square of it), or None where it is fine enough."""
    if error <= goal:
        return None
    most = int((_MOST / 2 / cells) ** (1 / 3))
    wanted = max(m + 1, math.ceil(1.1 * m * math.sqrt(error / goal)))
    return None if m >= most else min(wanted, most)


def _pairs(low: Points, size: NDArray[np.float64], m: int) -> tuple[Points, Points]:
    """Two independent random points in each of the m^3 strata of every cell; the same in every run."""
    random = np.random.default_rng(20230611 + m)
    index = np.stack(np.meshgrid(*(np.arange(m),) * 3, indexing="ij"), -1).reshape(1, -1, 3)
    count = (len(low), m**3, 3)
    step = size / m
    base = low[:, None, :] + index * step
    first = (base + random.random(count) * step).reshape(-1, 3)
    second = (base + random.random(count) * step).reshape(-1, 3)
    return first, second


def porosity(root: Node, within: Node, params: Mapping[str, float], accuracy: float = ACCURACY) -> Reduced:
    """1 - volume(root & within) / volume(within)."""
    where = region(within, params, "the region `within`")
    envelope = _share(within, where, params, 0.3 * accuracy * _whole(where))
    if envelope.value <= 0:
        raise fail("E092", "the region `within` of this porosity holds no material")
    part = node("max", root, within)
    cells = np.concatenate([where.inside, where.undecided])
    least, most = box_test(part, params, EXACT)(cells, cells + where.size)
    parted = Region(where.box, where.size, cells[most < 0], cells[(least <= 0) & (most >= 0)])
    solid = _share(part, parted, params, 0.7 * accuracy * envelope.value)
    share = solid.value / envelope.value
    error = (solid.error + share * envelope.error) / envelope.value
    return Reduced(1 - share, error)


def mean(root: Node, within: Node, params: Mapping[str, float], accuracy: float = 1e-4) -> Reduced:
    """The mean of a field within a solid; the accuracy is relative to the field's standard deviation there."""
    where = region(within, params, "the region `within`")
    m = _PILOT
    while True:
        a, b = _values(root, within, where, params, m)
        everything = np.concatenate([a[np.isfinite(a)], b[np.isfinite(b)]])
        middle = float(np.mean(everything))
        rest = [np.where(np.isfinite(v), v - middle, 0.0) for v in (a, b)]
        error = 3 * math.sqrt(float(np.sum((rest[0] - rest[1]) ** 2))) / len(everything)
        finer = _finer(m, error, accuracy * float(np.std(everything)), len(where.inside) + len(where.undecided))
        if finer is None:
            return Reduced(middle, error)
        m = finer


def _values(
    root: Node, within: Node, where: Region, params: Mapping[str, float], m: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Values of a field at the two random points of each stratum; infinite where the point is outside the solid."""
    cells = np.concatenate([where.inside, where.undecided])
    fence, field = NumpyField(within, params, "f32"), NumpyField(root, params, "f32")
    out: list[NDArray[np.float64]] = []
    for points in _pairs(cells, where.size, m):
        values = field.at(points).astype(np.float64)
        inside = _inside(fence, points)
        if np.isnan(values[inside]).any():
            raise fail(
                "E093", "the field of this number is not a number in places", hint="`pore mesh` names the first place"
            )
        out.append(np.where(inside, values, np.inf))
    if not any(np.isfinite(v).any() for v in out):
        raise fail(
            "E092",
            "the region `within` of this number holds no material that can be sampled",
            hint="it is far thinner than it is wide",
        )
    return out[0], out[1]


def offset_for(
    root: Node, phi: float, within: Node, params: Mapping[str, float], accuracy: float = ACCURACY
) -> Reduced:
    """The offset d for which {root <= d} fills 1 - phi of a solid: a quantile of the field's values there.

    The error is that of the offset; the porosity it gives is within `accuracy` (three standard deviations) of phi.
    """
    where = region(within, params, "the region `within`")
    m = _PILOT
    while True:
        a, b = _values(root, within, where, params, m)
        values = np.concatenate([a[np.isfinite(a)], b[np.isfinite(b)]])
        d = float(np.quantile(values, 1 - phi))
        rest = [np.where(np.isfinite(v), (v <= d) - (1 - phi), 0.0) for v in (a, b)]
        error = 3 * math.sqrt(max(float(np.sum((rest[0] - rest[1]) ** 2)), 9.0)) / len(values)
        finer = _finer(m, error, accuracy, len(where.inside) + len(where.undecided))
        if finer is None:
            low, high = (float(np.quantile(values, min(max(1 - phi + s * error, 0.0), 1.0))) for s in (-1, 1))
            flat = float(np.mean(values == d))
            if flat > 2 * accuracy:
                raise fail(
                    "E094",
                    f"a porosity of {phi:g} cannot be reached: the field is {d:g} in {flat:.1%} of the region",
                    hint="offset a field that varies everywhere",
                )
            return Reduced(d, max(high - d, d - low))
        m = finer


__all__ = ["ACCURACY", "Reduced", "Region", "mean", "offset_for", "porosity", "region", "volume"]
