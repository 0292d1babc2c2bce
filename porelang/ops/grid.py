"""Lookup in sampled fields: trilinear and tricubic interpolation with their derivatives.

A payload is (component, i, j, k): the orders of the derivative along x, y and z, 0 or 1 for the trilinear form and 0
to 3 for the cubic. Outside the grid the value of the nearest place on its border continues, and a derivative along an
axis is 0 beyond that axis's ends. A coordinate that is not a number gives NaN; infinite ones lie outside.

In the working type T: u = (x - o) * s, with o the origin and s = 1 / spacing rounded to T; u is clamped to 0..n-1;
i = min(floor(u), n-2) and f = u - i; then a + (b - a) * f along z, y and x in this order, or (b - a) * s for an order
of 1. The shaders do the same, bit for bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.data import SampledField
from porelang.ops.derived import derived
from porelang.ops.points import Points, points, room, target

Values = NDArray[Any]
Payload = tuple[int, int, int, int]
#: Of float32: what a shader computes lies this much from the exact result, for every backend's sake.
EPSILON = 2.0**-23


def lookup(grid: SampledField, x: Any, y: Any, z: Any, payload: Payload, out: Values | None = None) -> Values:
    """Trilinear interpolation at coordinates in mm that broadcast, in their type."""
    from porelang.ops import grid_loops as loops

    at = points(x, y, z)
    lattice = _lattice(grid, at.dtype)
    return _filled(at, out, lambda to: loops.linear(lattice, payload[0], payload[1:], at.x, at.y, at.z, to, at.loops))


def lookup_cubic(grid: SampledField, x: Any, y: Any, z: Any, payload: Payload, out: Values | None = None) -> Values:
    """Tricubic Catmull-Rom interpolation at coordinates in mm that broadcast, in their type; its gradient is smooth."""
    from porelang.ops import grid_loops as loops

    at = points(x, y, z)
    lattice, constants = _lattice(grid, at.dtype), np.array([0.5, 1, 2, 3], at.dtype)
    component, orders = payload[0], payload[1:]
    return _filled(
        at, out, lambda to: loops.cubic(lattice, constants, component, orders, at.x, at.y, at.z, to, at.loops)
    )


def covers(grid: SampledField, x: Any, y: Any, z: Any, out: Values | None = None) -> Values:
    """Whether points lie within the box of the nodes, its faces included; never where a coordinate is not a number."""
    from porelang.ops import grid_loops as loops

    at = points(x, y, z)
    lattice = _lattice(grid, at.dtype)
    return _filled(at, out, lambda to: loops.covers(lattice, at.x, at.y, at.z, to, at.loops), np.bool_)


def _filled(at: Points, out: Values | None, loop: Any, dtype: Any = None) -> Values:
    result = room(at, out, dtype)
    to, copy = target(at, result)
    loop(to)
    if copy:
        result[...] = to.memory.reshape(result.shape)
    return result


def _lattice(grid: SampledField, dtype: np.dtype[Any]) -> Any:
    """The grid in a working type, as the loops take it."""
    return derived(grid, ("lattice", dtype.str), lambda: _make_lattice(grid, dtype))


def _make_lattice(grid: SampledField, dtype: np.dtype[Any]) -> Any:
    from porelang.ops.grid_loops import Lattice

    with np.errstate(over="ignore"):
        kept = grid.values if grid.values.dtype == np.float32 else grid.values.astype(dtype, copy=False)
    values = kept.reshape(-1).view()
    values.flags.writeable = False
    nx, ny, nz = grid.shape
    origin, rate = np.array(grid.origin, dtype), (1.0 / np.array(grid.spacing)).astype(dtype)
    return Lattice(values, (nx, ny, nz, grid.components), origin, rate, np.array([nx - 1, ny - 1, nz - 1], dtype))
