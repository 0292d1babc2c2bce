"""The loops that bound grid lookup over boxes, compiled: a pyramid of ranges, and polynomials over parts of cells.

Over a part of a few cells the interpolant is a polynomial in each, whose Bernstein coefficients hold it: at degree 1
they are its values at the corners, so that the bound is exact; at degree 3 it is exact to second order in the part's
size. Over more cells a pyramid holds the least and largest of the nodes, or of their differences, in blocks of 2^level.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled

Values = NDArray[Any]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


#: Blocks that are read for one box: 512 take about a microsecond.
MOST_BLOCKS = 512


class Nodes(NamedTuple):
    """The nodes' values, flat, and what is taken of them: a component, and differences (0 or 1) along each axis."""

    values: Values
    shape: tuple[int, int, int, int]
    component: int
    differences: tuple[int, int, int]


class Pyramid(NamedTuple):
    """Ranges (least, largest) of blocks; level L, counted from 1, begins at starts[L] and has sizes[L] blocks."""

    ranges: Floats
    starts: Ints
    sizes: Ints


@compiled
def _difference(of: Nodes, i: int, j: int, k: int) -> float:
    """The (mixed) difference at a node, or its value."""
    _, ny, nz, step = of.shape
    row, plane = nz * step, ny * nz * step
    at = i * plane + j * row + k * step + of.component
    total = 0.0
    for a in range(of.differences[0] + 1):
        for b in range(of.differences[1] + 1):
            for c in range(of.differences[2] + 1):
                minus = (of.differences[0] - a + of.differences[1] - b + of.differences[2] - c) % 2
                value = float(of.values[at + a * plane + b * row + c * step])
                total += -value if minus else value
    return total


@compiled
def largest(of: Nodes) -> float:
    """The largest magnitude of the differences."""
    most = 0.0
    for i in range(of.shape[0] - of.differences[0]):
        for j in range(of.shape[1] - of.differences[1]):
            for k in range(of.shape[2] - of.differences[2]):
                most = max(most, abs(_difference(of, i, j, k)))
    return most


@compiled
def pyramid(of: Nodes) -> Pyramid:
    """The ranges of blocks of 2, 4, 8 ... nodes along each axis, up to one block."""
    sizes = np.ones((64, 3), np.int64)
    starts = np.zeros(64, np.int64)
    for a in range(3):
        sizes[0, a] = of.shape[a] - of.differences[a]
    levels, total = 0, 0
    while levels == 0 or sizes[levels].max() > 1:
        levels += 1
        starts[levels] = total
        for a in range(3):
            sizes[levels, a] = (sizes[0, a] - 1 >> levels) + 1
        total += sizes[levels, 0] * sizes[levels, 1] * sizes[levels, 2]
    ranges = np.empty((total, 2))
    ranges[:, 0] = np.inf
    ranges[:, 1] = -np.inf
    ny, nz = sizes[1, 1], sizes[1, 2]
    for i in range(sizes[0, 0]):
        for j in range(sizes[0, 1]):
            for k in range(sizes[0, 2]):
                value = _difference(of, i, j, k)
                at = ((i >> 1) * ny + (j >> 1)) * nz + (k >> 1)
                ranges[at, 0] = min(ranges[at, 0], value)
                ranges[at, 1] = max(ranges[at, 1], value)
    for level in range(2, levels + 1):
        ny, nz = sizes[level, 1], sizes[level, 2]
        below = starts[level - 1]
        for i in range(sizes[level - 1, 0]):
            for j in range(sizes[level - 1, 1]):
                for k in range(sizes[level - 1, 2]):
                    at = starts[level] + ((i >> 1) * ny + (j >> 1)) * nz + (k >> 1)
                    ranges[at, 0] = min(ranges[at, 0], ranges[below, 0])
                    ranges[at, 1] = max(ranges[at, 1], ranges[below, 1])
                    below += 1
    return Pyramid(ranges, starts[: levels + 1].copy(), sizes[: levels + 1].copy())


@compiled
def _range(of: Nodes, made: Pyramid, lo: Ints, hi: Ints) -> tuple[float, float]:
    """The least and largest of the nodes lo..hi, or of the blocks (no more than MOST_BLOCKS) that hold them.

    A box may be flat: a layer of nodes keeps to small blocks, so that the end of a part can be found.
    """
    level = 0
    while True:
        blocks = 1
        for a in range(3):
            blocks *= (hi[a] >> level) - (lo[a] >> level) + 1
        if blocks <= MOST_BLOCKS:
            break
        level += 1
    least, most = np.inf, -np.inf
    for i in range(lo[0] >> level, (hi[0] >> level) + 1):
        for j in range(lo[1] >> level, (hi[1] >> level) + 1):
            for k in range(lo[2] >> level, (hi[2] >> level) + 1):
                if level == 0:
                    value = _difference(of, i, j, k)
                    least, most = min(least, value), max(most, value)
                else:
                    at = made.starts[level] + (i * made.sizes[level, 1] + j) * made.sizes[level, 2] + k
                    least, most = min(least, made.ranges[at, 0]), max(most, made.ranges[at, 1])
    return least, most


#: Along each axis, the parts in which a box is taken that reaches beyond the grid.
PARTS = 8
#: More parts than this are not looked at for each box, but are blocks of `PIECES` along each axis, enclosed once. In a
#: distance (`metric`) to a lattice with a phase nearly all boxes reach beyond: a millisecond for each of 40,000.
MANY, PIECES = 64, 16


class Room(NamedTuple):
    """Room to work in: matrices to Bernstein coefficients, coefficients, a cell, and the first and last node."""

    to: Floats
    work: Floats
    cell: Ints
    low: Ints
    high: Ints


_CATMULL_ROM = np.array([[0, -0.5, 1, -0.5], [1, 0, -2.5, 1.5], [0, 0.5, 2, -1.5], [0, 0, -0.5, 0.5]])
_LINE = np.array([[0.0, 0, 0, 0], [1, -1, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0]])


@compiled
def _bernstein(cubic: bool, cell: int, count: int, order: int, rate: float, f0: float, f1: float, to: Floats) -> float:
    """The matrix `to` from the four nodes round a cell to Bernstein coefficients over its part f0..f1.

    Returns the largest sum of magnitudes in a row. In the linear form only rows and columns 1 and 2 are used.
    """
    c = _CATMULL_ROM.copy() if cubic else _LINE.copy()
    if cubic and cell == 0:
        c[1] += 2 * c[0]
        c[2] -= c[0]
        c[0] = 0.0
    if cubic and cell == count - 2:
        c[2] += 2 * c[3]
        c[1] -= c[3]
        c[3] = 0.0
    for _ in range(order):
        for m in range(4):
            c[m, 0], c[m, 1], c[m, 2], c[m, 3] = rate * c[m, 1], 2 * rate * c[m, 2], 3 * rate * c[m, 3], 0.0
    h = f1 - f0
    for m in range(4):
        a0 = c[m, 0] + f0 * (c[m, 1] + f0 * (c[m, 2] + f0 * c[m, 3]))
        a1 = (c[m, 1] + f0 * (2 * c[m, 2] + f0 * 3 * c[m, 3])) * h
        a2 = (c[m, 2] + f0 * 3 * c[m, 3]) * h * h
        a3 = c[m, 3] * h * h * h
        if cubic:
            to[0, m], to[1, m] = a0, a0 + a1 / 3
            to[2, m], to[3, m] = a0 + 2 * a1 / 3 + a2 / 3, a0 + a1 + a2 + a3
        else:
            to[1, m], to[2, m] = a0, a0 + a1
    most = 0.0
    for j in range(4):
        most = max(most, abs(to[j, 0]) + abs(to[j, 1]) + abs(to[j, 2]) + abs(to[j, 3]))
    return most


@compiled
def _in_cell(
    of: Nodes, cell: Ints, first: int, last: int, to: Floats, sums: float, work: Floats
) -> tuple[float, float]:
    """The range of the Bernstein coefficients in one cell, from the nodes first..last (of -1..2) along each axis."""
    nx, ny, nz, step = of.shape
    size = 0.0
    for a in range(first, last + 1):
        i = min(max(cell[0] - 1 + a, 0), nx - 1)
        for b in range(first, last + 1):
            j = min(max(cell[1] - 1 + b, 0), ny - 1)
            for c in range(first, last + 1):
                k = min(max(cell[2] - 1 + c, 0), nz - 1)
                value = float(of.values[((i * ny + j) * nz + k) * step + of.component])
                work[0, a, b, c] = value
                size = max(size, abs(value))
    for a in range(first, last + 1):
        for b in range(first, last + 1):
            for c in range(first, last + 1):
                total = 0.0
                for m in range(first, last + 1):
                    total += to[2, c, m] * work[0, a, b, m]
                work[1, a, b, c] = total
    for a in range(first, last + 1):
        for b in range(first, last + 1):
            for c in range(first, last + 1):
                total = 0.0
                for m in range(first, last + 1):
                    total += to[1, b, m] * work[1, a, m, c]
                work[0, a, b, c] = total
    least, most = np.inf, -np.inf
    for a in range(first, last + 1):
        for b in range(first, last + 1):
            for c in range(first, last + 1):
                total = 0.0
                for m in range(first, last + 1):
                    total += to[0, a, m] * work[0, m, b, c]
                least, most = min(least, total), max(most, total)
    slack = 2.0**-46 * size * sums  # some dozens of roundings of float64
    return least - slack, most + slack


@compiled
def _over(
    nodes: Nodes, blocks: Nodes, made: Pyramid, cubic: bool, orders: Ints, rate: Floats, factors: Floats, span: Floats,
    start: Ints, stop: Ints, room: Room,
) -> tuple[float, float]:  # fmt: skip
    """The range over the part `span` (3, 2) of the grid, which lies in the cells start..stop."""
    first, last = (0, 3) if cubic else (1, 2)
    least, most = np.inf, -np.inf
    if max(stop[0] - start[0], stop[1] - start[1], stop[2] - start[2]) < 2:
        for i in range(start[0], stop[0] + 1):
            for j in range(start[1], stop[1] + 1):
                for k in range(start[2], stop[2] + 1):
                    room.cell[0], room.cell[1], room.cell[2] = i, j, k
                    sums = 1.0
                    for a in range(3):
                        cell = room.cell[a]
                        f0 = min(max(span[a, 0] - cell, 0.0), 1.0)
                        f1 = min(max(span[a, 1] - cell, 0.0), 1.0)
                        sums *= _bernstein(cubic, cell, nodes.shape[a], orders[a], rate[a], f0, f1, room.to[a])
                    part = _in_cell(nodes, room.cell, first, last, room.to, sums, room.work)
                    least, most = min(least, part[0]), max(most, part[1])
        return least, most
    for a in range(3):
        reach = 1 if cubic else 0
        top_node = nodes.shape[a] - 1 - blocks.differences[a]
        room.low[a] = max(start[a] - reach, 0)
        room.high[a] = min(stop[a] + reach + 1 - blocks.differences[a], top_node)
    least, most = _range(blocks, made, room.low, room.high)
    middle, half = (least + most) / 2, (most - least) / 2
    slack = 2.0**-48 * max(abs(least), abs(most)) * factors[1]
    return factors[0] * middle - factors[1] * half - slack, factors[0] * middle + factors[1] * half + slack


@compiled
def _over_pieces(pieces: Floats, cells: tuple[int, int, int], start: Ints, stop: Ints) -> tuple[float, float]:
    """The range over the blocks that hold the cells start..stop."""
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    for a in range(3):
        count = pieces.shape[a]
        # block i has the cells from i * cells // count on
        low[a] = ((start[a] + 1) * count - 1) // cells[a]
        high[a] = ((stop[a] + 1) * count - 1) // cells[a]
    least, most = np.inf, -np.inf
    for i in range(low[0], high[0] + 1):
        for j in range(low[1], high[1] + 1):
            for k in range(low[2], high[2] + 1):
                least, most = min(least, pieces[i, j, k, 0]), max(most, pieces[i, j, k, 1])
    return least, most


@compiled
def enclose(
    nodes: Nodes,
    blocks: Nodes,
    made: Pyramid,
    cubic: bool,
    orders: Ints,
    rate: Floats,
    lo: Floats,
    hi: Floats,
    factors: Floats,
    pieces: Floats,
    out: Floats,
) -> None:
    """The ranges `out` (n, 2) of lookup over boxes lo..hi (3, n), which are counted in cells and not yet clamped.

    `blocks` are the nodes with the differences that the pyramid is of. `factors` are (sum of the weights, sum of their
    magnitudes) of the interpolant as a combination of these, over all axes. A cubic may overshoot by a part of the
    range of all its nodes, so a box that reaches beyond the grid, which no halving makes smaller on it, is taken in
    parts: else a solid in the middle of its samples would seem to have no end. No end hangs on a derivative, whose
    boxes are taken as they are. `pieces` (i, j, k, 2) are the ranges of blocks, if they are known.
    """
    of_values = cubic and orders[0] == 0 and orders[1] == 0 and orders[2] == 0
    cells = (nodes.shape[0] - 1, nodes.shape[1] - 1, nodes.shape[2] - 1)
    start, stop = np.empty(3, np.int64), np.empty(3, np.int64)
    begin, end, parts = np.empty(3, np.int64), np.empty(3, np.int64), np.empty(3, np.int64)
    span, piece = np.empty((3, 2)), np.empty((3, 2))
    room = Room(
        np.zeros((3, 4, 4)),
        np.zeros((2, 4, 4, 4)),
        np.empty(3, np.int64),
        np.empty(3, np.int64),
        np.empty(3, np.int64),
    )
    for n in range(len(out)):
        outside, touches, beyond = False, False, False
        for a in range(3):
            top = float(nodes.shape[a] - 1)
            u, v = lo[a, n], hi[a, n]
            beyond = beyond or u < 0 or v > top
            if orders[a] > 0:
                outside = outside or v < 0 or u > top
                touches = touches or u < 0 or v > top
            span[a, 0], span[a, 1] = min(max(u, 0.0), top), min(max(v, 0.0), top)
            start[a] = min(int(span[a, 0]), nodes.shape[a] - 2)
            stop[a] = min(int(span[a, 1]), nodes.shape[a] - 2)
        if outside:
            out[n, 0] = out[n, 1] = 0.0
            continue
        for a in range(3):
            parts[a] = min(stop[a] - start[a] + 1, PARTS) if of_values and beyond else 1
        count = parts[0] * parts[1] * parts[2]
        if count > MANY and pieces.size:
            out[n, 0], out[n, 1] = _over_pieces(pieces, cells, start, stop)
            continue
        least, most = np.inf, -np.inf
        for p in range(count):
            at = p
            for a in range(3):
                wide, i = stop[a] - start[a] + 1, at % parts[a]
                at //= parts[a]
                begin[a] = start[a] + i * wide // parts[a]
                end[a] = start[a] + (i + 1) * wide // parts[a] - 1
                piece[a, 0] = max(span[a, 0], float(begin[a]))
                piece[a, 1] = min(span[a, 1], float(end[a] + 1))
            part = _over(nodes, blocks, made, cubic, orders, rate, factors, piece, begin, end, room)
            least, most = min(least, part[0]), max(most, part[1])
        if touches:
            least, most = min(least, 0.0), max(most, 0.0)
        out[n, 0], out[n, 1] = least, most
