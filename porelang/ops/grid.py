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
from porelang.interval import Array, Interval, Mask, truth
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
    origin, end, rate = (np.array(v, dtype) for v in (grid.origin, grid.end, 1.0 / np.array(grid.spacing)))
    return Lattice(values, (nx, ny, nz, grid.components), origin, rate, np.array([nx - 1, ny - 1, nz - 1], dtype), end)


# ---- bounds ----------------------------------------------------------------------------------------------------------
#: Catmull-Rom as a combination of nodes (order 0) or of their differences (orders 1 to 3): the sum of the weights, and
#: the largest sum of their magnitudes in a cell. Order 0 has (-1, 9, 9, -1)/16 in the middle of a cell; order 1 has
#: (-1, 10, -1)/8 there; order 2 (-2, 3, -1) and order 3 (3, -6, 3) at a node. Lines continued at the border have less.
_CUBIC = ((1.0, 1.25), (1.0, 1.5), (0.0, 6.0), (0.0, 12.0))
_FROM, _TO = slice(None, -1), slice(1, None)
_UNKNOWN = np.empty((0, 0, 0, 2))


def enclose(grid: SampledField, x: Interval, y: Interval, z: Interval, payload: Payload, cubic: bool) -> Interval:
    """Ranges that hold the exact interpolant over boxes; exact in the trilinear form over a part of a few cells.

    Where the result may jump, both sides of the jump are held, as far as rounding in float32 may shift it.
    """
    from porelang.ops import grid_ranges as loops

    component, orders = payload[0], payload[1:]
    differences = (min(orders[0], 1), min(orders[1], 1), min(orders[2], 1))
    nodes = loops.Nodes(
        _lattice(grid, np.dtype(np.float64)).values, (*grid.shape, grid.components), component, (0, 0, 0)
    )
    blocks = nodes._replace(differences=differences)
    made = derived(grid, ("pyramid", component, differences), lambda: loops.pyramid(blocks))
    boxes = [_cells(grid, a, r, orders[a] > 0) for a, r in enumerate((x, y, z))]
    lo, hi = (np.ascontiguousarray(np.broadcast_arrays(*ends)) for ends in zip(*boxes, strict=True))
    shape = lo.shape[1:]
    rate = 1.0 / np.array(grid.spacing)
    total, size = 1.0, 1.0
    for order, r in zip(orders, rate.tolist(), strict=True):
        sum_, sum_of_sizes = _CUBIC[order] if cubic else (1.0, 1.0)
        total, size = total * sum_ * r**order, size * sum_of_sizes * r**order

    def over(lo: Array, hi: Array, pieces: Array) -> Array:
        ranges = np.empty((lo.shape[1], 2))
        factors = np.array([total, size])
        loops.enclose(nodes, blocks, made, cubic, np.array(orders, np.int64), rate, lo, hi, factors, pieces, ranges)
        return ranges

    def in_pieces() -> Array:
        edges = [np.arange(n + 1) * (top - 1) // n for top in grid.shape for n in [min(top - 1, loops.PIECES)]]
        ends = (np.meshgrid(*(e[part].astype(float) for e in edges), indexing="ij") for part in (_FROM, _TO))
        low, high = (np.stack([e.reshape(-1) for e in end]) for end in ends)
        return over(low, high, _UNKNOWN).reshape(*(len(e) - 1 for e in edges), 2)

    whole = cubic and not any(orders)
    pieces = derived(grid, ("pieces", component), in_pieces) if whole else _UNKNOWN
    out = over(lo.reshape(3, -1), hi.reshape(3, -1), pieces)
    none = np.broadcast_to(x.empty | y.empty | z.empty, shape)
    least, most = out[:, 0].reshape(shape), out[:, 1].reshape(shape)
    nan = np.broadcast_to(x.nan | y.nan | z.nan, shape)
    return Interval(np.where(none, np.inf, least), np.where(none, -np.inf, most), nan)


def narrow(w: Interval, grid: SampledField, payload: Payload) -> tuple[Interval | None, ...]:
    """Where the coordinates lie if trilinear interpolation gives what lies in `w`.

    Along an axis the interpolant is a mean of what it is in the planes of nodes before and behind, so that it lies
    between the lines that join their least and their largest values. Of a signed distance, that at a node before a face
    of the shape's box is no less than the distance to that face, and behind it no less than minus that: the lines give
    that face.
    """
    component, orders = payload[0], payload[1:]
    if any(orders):
        return (None, None, None)
    out = []
    for axis, (least, most) in enumerate(derived(grid, ("planes", component), lambda: _planes(grid, component))):
        origin, spacing = grid.origin[axis], grid.spacing[axis]
        (a, b), (c, d) = _under(least, w.hi), _under(-most, -w.lo)
        slack = 2.0**-46 * (abs(origin) / spacing + len(least))
        lo, hi = np.maximum(a, c) - slack, np.minimum(b, d) + slack
        out.append(Interval(origin + spacing * lo, origin + spacing * hi, np.zeros(np.shape(lo), np.bool_)))
    return tuple(out)


def _planes(grid: SampledField, component: int) -> list[tuple[Array, Array]]:
    """The least and the largest value in each plane of nodes across each axis."""
    values = grid.values[..., component]
    others = ((1, 2), (0, 2), (0, 1))
    return [(values.min(axis=o).astype(np.float64), values.max(axis=o).astype(np.float64)) for o in others]


def _under(line: Array, most: Array) -> tuple[Array, Array]:
    """From where to where, in cells, a line through values (n,) is no more than `most`: without an end where it is not
    so at its own, inf and -inf where it never is."""
    under = line.reshape(-1, *(1,) * np.ndim(most)) <= most
    ends = []
    for values, below in ((line, under), (line[::-1], under[::-1])):
        node = below.argmax(axis=0)
        before, there = values[node - 1], values[node]
        with np.errstate(invalid="ignore", divide="ignore"):
            crossing = node - 1 + (before - most) / (before - there)
        end = np.where(node > 0, np.minimum(crossing, node), -np.inf)
        ends.append(np.where(below.any(axis=0), end, np.inf))
    return ends[0], len(line) - 1 - ends[1]


def jumps(grid: SampledField, x: Interval, y: Interval, z: Interval, payload: Payload, cubic: bool) -> Mask:
    """Over which boxes the result may jump: at nodes where the order is too high to be continuous, else at the ends."""
    mask = np.zeros(np.broadcast_shapes(x.lo.shape, y.lo.shape, z.lo.shape), np.bool_)
    for axis, (order, r) in enumerate(zip(payload[1:], (x, y, z), strict=True)):
        if order == 0:
            continue
        lo, hi = _cells(grid, axis, r, True)
        top = grid.shape[axis] - 1
        if not (cubic and order == 1):
            mask = mask | (np.floor(np.minimum(hi, top)) >= np.ceil(np.maximum(lo, 0)))
        else:
            mask = mask | ((lo <= 0) & (hi >= 0)) | ((lo <= top) & (hi >= top))
    return mask


def enclose_covers(grid: SampledField, x: Interval, y: Interval, z: Interval) -> Interval:
    """Whether boxes lie within that of the nodes, as far as rounding in float32 tells."""
    inside, meets = np.ones((), np.bool_), np.ones((), np.bool_)
    for r, first, last in zip((x, y, z), grid.origin, grid.end, strict=True):
        before, beyond = EPSILON * abs(first), EPSILON * abs(last)
        inside = inside & (r.lo >= first + before) & (r.hi <= last - beyond) & ~r.nan & ~r.empty
        meets = meets & (r.hi >= first - before) & (r.lo <= last + beyond) & ~r.empty
    return truth(np.asarray(~inside), np.asarray(meets))


def rounding(grid: SampledField, x: Interval, y: Interval, z: Interval, payload: Payload, cubic: bool) -> Array:
    """How far evaluation may be from exact interpolation, in units of the type's epsilon.

    Let e be epsilon, M the largest value and D the largest difference of neighbours, both of what is interpolated
    along an axis (of all the grid), o the origin, h the spacing. Rounding a value costs e/2 M. Rounding o, the rate
    1/h, their difference and product moves u by e (|o|/h + 3 |u|) / 2, where |u| is at most the last node's number,
    for beyond it u is clamped. f = u - i is exact. a + (b - a) f moves by what moves a and b, by e/2 |b - a| twice
    and by e/2 M. (b - a) / h moves by twice what moves a and b, and by 3/2 e D / h. Catmull-Rom: see the constants.
    """
    component, orders = payload[0], payload[1:]
    rate = (1.0 / np.array(grid.spacing)).tolist()
    error: Array = np.asarray(0.5 * _largest(grid, component, (0, 0, 0)))
    # what has been interpolated so far: the differences along the axes done, and by how much they are scaled
    done, scale = [0, 0, 0], 1.0
    for axis in (2, 1, 0):
        order = orders[axis]
        r = (x, y, z)[axis]
        far = np.maximum(np.abs(r.lo - grid.origin[axis]), np.abs(r.hi - grid.origin[axis])) * rate[axis]
        shift = 0.5 * abs(grid.origin[axis]) * rate[axis] + 1.5 * np.minimum(far, grid.shape[axis] - 1)
        size = scale * _largest(grid, component, (done[0], done[1], done[2]))
        done[axis] = 1
        difference = scale * _largest(grid, component, (done[0], done[1], done[2]))
        done[axis] = min(order, 1)
        power = rate[axis] ** order
        if cubic:
            passed, sums, own, slope = _CUBIC_ROUNDING[order]
            error = power * (passed * error + own * difference + slope * difference * shift)
            error = error + (0.625 * size if order == 0 else 0.0)
            scale *= sums * power
        elif order == 0:
            error = error + 0.5 * size + difference * (1.0 + shift)
        else:
            error = power * (2.0 * error + 1.5 * difference)
            scale *= power
    # a sum of weighted values that float32 may not hold on the way
    if cubic and 4 * _largest(grid, component, (0, 0, 0)) * scale > _LARGEST_SINGLE:
        error = np.full_like(error, np.inf)
    # second-order terms; and numbers that a shader may take for 0
    return np.asarray(np.where(np.isnan(error), np.inf, 1.01 * error + 1e-30))


_LARGEST_SINGLE = float(np.finfo(np.float32).max)


#: For each order of a cubic: what an error of the nodes is multiplied by (the sum of the weights' magnitudes), what a
#: magnitude is (`_CUBIC`), the arithmetic's own error in units of e D (the weights of node i-1, i+1, i+2 have at most
#: 2, 5, 2 times 4 e of error and meet differences of D, D, 2 D), and the largest next derivative in units of D.
_CUBIC_ROUNDING = ((1.25, 1.25, 20.0, 1.5), (3.0, 1.5, 60.0, 6.0), (12.0, 6.0, 160.0, 12.0), (24.0, 12.0, 160.0, 0.0))


def _largest(grid: SampledField, component: int, differences: tuple[int, int, int]) -> float:
    from porelang.ops import grid_ranges as loops

    nodes = _nodes(grid, component, differences)
    return derived(grid, ("largest", component, differences), lambda: float(loops.largest(nodes)))


def _nodes(grid: SampledField, component: int, differences: tuple[int, int, int]) -> Any:
    from porelang.ops.grid_ranges import Nodes

    values = _lattice(grid, np.dtype(np.float64)).values
    return Nodes(values, (*grid.shape, grid.components), component, differences)


def _cells(grid: SampledField, axis: int, r: Interval, single: bool) -> tuple[Array, Array]:
    """A coordinate's range counted in cells, widened by the rounding of float64, or of float32 (`single`)."""
    origin, rate = grid.origin[axis], 1.0 / grid.spacing[axis]
    lo, hi = (r.lo - origin) * rate, (r.hi - origin) * rate
    epsilon = EPSILON if single else 2.0**-52
    top = grid.shape[axis]
    shift = [2 * epsilon * (abs(origin) * rate + 2 * np.minimum(np.abs(v), top)) for v in (lo, hi)]
    return np.asarray(lo - shift[0]), np.asarray(hi + shift[1])
