"""The bounding box of a part: the smallest box outside of which the field is proven positive."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.interval import interval
from porelang.ir import Node, order
from porelang.passes.enclose import EXACT, enclose, fixed

#: Parts are looked for within this distance of the origin, in mm, along each axis.
UNIVERSE = 1e5


Points = NDArray[np.float64]
#: Whether any material is possible in each of n boxes, given by their corners (n, 3).
Solid = Callable[[Points, Points], NDArray[np.bool_]]


@dataclass(frozen=True, slots=True)
class Box:
    """An axis-aligned box, in mm."""

    lo: tuple[float, float, float]
    hi: tuple[float, float, float]

    @property
    def size(self) -> tuple[float, float, float]:
        return (self.hi[0] - self.lo[0], self.hi[1] - self.lo[1], self.hi[2] - self.lo[2])

    @property
    def volume(self) -> float:
        return float(np.prod(self.size))


def part_box(root: Node, params: Mapping[str, float]) -> Box | None:
    """The box that holds all of `root <= 0` within the universe, or None if that is proven empty.

    Ends that touch +-UNIVERSE mean that the part has no end there. The box is tight to about 1e-4 of its size for
    shapes along the axes, and to a few percent for rotated ones.
    """
    ranges = fixed(params)
    cost = len(order([root]))

    def maybe_solid(lo: Points, hi: Points) -> NDArray[np.bool_]:
        r = enclose([root], [interval(lo[:, i], hi[:, i]) for i in range(3)], ranges, EXACT)[0].range
        return np.broadcast_to((r.lo <= 0) | r.nan, len(lo))

    lo, hi = np.full(3, -UNIVERSE), np.full(3, UNIVERSE)
    finest = 32 if cost < 300 else 16 if cost < 3000 else 8
    cells = 8
    for _ in range(60):
        cell_lo, cell_hi = _split(lo, hi, (cells, cells, cells))
        keep = maybe_solid(cell_lo, cell_hi)
        if not keep.any():
            return None
        new_lo, new_hi = cell_lo[keep].min(axis=0), cell_hi[keep].max(axis=0)
        shrunk = np.prod(new_hi - new_lo) < 0.9 * np.prod(hi - lo)
        lo, hi = new_lo, new_hi
        if not shrunk:
            if cells >= finest:
                break
            cells *= 2
    steps = 22 if cost < 300 else 14 if cost < 1000 else 7 if cost < 5000 else 3
    for axis in range(3):
        for side in (-1, 1):
            _shave(lo, hi, axis, side, steps, maybe_solid)
            _snap(lo, hi, axis, side, maybe_solid)
    return Box((float(lo[0]), float(lo[1]), float(lo[2])), (float(hi[0]), float(hi[1]), float(hi[2])))


def unbounded_axes(box: Box) -> str:
    """The axes along which a box reaches the end of the universe, as text."""
    return ", ".join(
        name for name, a, b in zip("xyz", box.lo, box.hi, strict=True) if a <= -UNIVERSE or b >= UNIVERSE
    )


def _split(
    lo: Points, hi: Points, counts: tuple[int, int, int]
) -> tuple[Points, Points]:
    """The corners of the cells of a box."""
    cuts = [np.linspace(lo[i], hi[i], counts[i] + 1) for i in range(3)]
    low = np.stack(np.meshgrid(*(c[:-1] for c in cuts), indexing="ij"), axis=-1).reshape(-1, 3)
    high = np.stack(np.meshgrid(*(c[1:] for c in cuts), indexing="ij"), axis=-1).reshape(-1, 3)
    return low, high


def _shave(
    lo: Points, hi: Points, axis: int, side: int, steps: int, maybe_solid: Solid
) -> None:
    """Move one face of the box inward as far as bisection proves the layer before it void."""
    width = hi[axis] - lo[axis]
    proven, failed = 0.0, width
    for _ in range(steps):
        depth = (proven + failed) / 2
        layer_lo, layer_hi = lo.copy(), hi.copy()
        if side > 0:
            layer_lo[axis] = hi[axis] - depth
        else:
            layer_hi[axis] = lo[axis] + depth
        if maybe_solid(*_split(layer_lo, layer_hi, _sheet(axis))).any():
            failed = depth
        else:
            proven = depth
    if side > 0:
        hi[axis] -= proven
    else:
        lo[axis] += proven


def _snap(lo: Points, hi: Points, axis: int, side: int, maybe_solid: Solid) -> None:
    """Move one face to a rounder number, if nothing lies beyond that: a radius of 75 mm should end at 75."""
    end = hi if side > 0 else lo
    width = hi[axis] - lo[axis]
    if not width > 0:
        return
    digits = 4 - int(np.floor(np.log10(width)))
    rounder = round(float(end[axis]), digits)
    if (rounder - end[axis]) * side >= 0:
        return
    layer_lo, layer_hi = lo.copy(), hi.copy()
    if side > 0:
        layer_lo[axis] = np.nextafter(rounder, np.inf)
    else:
        layer_hi[axis] = np.nextafter(rounder, -np.inf)
    if not maybe_solid(*_split(layer_lo, layer_hi, _sheet(axis))).any():
        end[axis] = rounder


def _sheet(axis: int) -> tuple[int, int, int]:
    """How a layer across `axis` is cut into cells."""
    return (1 if axis == 0 else 16, 1 if axis == 1 else 16, 1 if axis == 2 else 16)
