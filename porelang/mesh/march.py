"""The loops of marching cubes over one block of samples, compiled.

A block is walked along x, a layer of cells at a time. The vertices on the grid's edges are numbered before the cells
that use them, in a small table of the edges at the two planes of nodes in work, so that a cell finds its corners
without a search. Rows along z are looked at eight nodes at a time, for most hold nothing.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.mesh.cells import CENTRE, CORNERS, DIAGONALS, EDGES

Bytes = NDArray[np.uint8]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Numbers = NDArray[np.int32]


class Cases(NamedTuple):
    """The columns of `cells.Table`."""

    rows: NDArray[np.int16]
    ambiguous: Bytes
    starts: Ints
    counts: Ints
    edges: Bytes
    centred: NDArray[np.bool_]


class Frame(NamedTuple):
    """Where a block of nodes lies.

    `seats` (2, 3, n) are the coordinates of its nodes along each axis, as the field has them (`Axis.at`) and as
    vertices do (`Axis.rim`); `least` (3, n) is how near, as a part of the edge that starts there, a vertex comes to
    a node; `lo` is the block's first node in a grid of the shape `whole`, which is clipped at the `box` (2, 3).
    """

    seats: Floats
    least: Floats
    box: Floats
    lo: tuple[int, int, int]
    whole: tuple[int, int, int]


_AXIS_OF = np.array([axis for _, _, axis in EDGES])
_STARTS_AT = np.array([CORNERS[k] for k, _, _ in EDGES])
_DIAGONALS = np.array(DIAGONALS)
_CENTRE = CENTRE
_FULL = np.uint64(0xFFFFFFFFFFFFFFFF)
_HUGE = float(np.finfo(np.float64).max) / 4
_MOST_TRIANGLES = 12  # of one cell
#: The edge of a vertex in one number: its axis (2 bits), its first node's place along that, and from here on of all.
ALONG, PLACED = (1 << 18) - 1, 20


@compiled
def march(
    values: NDArray[Any], frame: Frame, cases: Cases, around: tuple[int, int, int, int, int]
) -> tuple[Floats, Numbers, Numbers, Ints, Ints]:
    """The vertices (n, 3) mm and faces (m, 3) of a block, which vertices lie on its border, the keys of these, and the
    edges (n,) of all: as `PLACED` says, in the samples `around` the block, or for a vertex within a cell one less than
    the negative of the first triangle round it. `around` are the place of the block's first node there, and the sides.
    """
    nx, ny, nz = values.shape
    plane = ny * nz
    signs = np.zeros((2, ny, nz), np.uint8)
    marks = np.zeros(8 * (nz // 8 + 1), np.uint8)
    number = np.empty(5 * plane, np.int32)
    shift = _shifts(ny, nz)
    vertices, total = np.empty((8 * plane, 3)), 0
    edges = np.empty(8 * plane, np.int64)
    faces, made = np.empty((24 * plane, 3), np.int32), 0
    border, keys, shared = np.empty(4 * plane, np.int32), np.empty(4 * plane, np.int64), 0
    for i in range(nx):
        even = i % 2
        now, before = signs[even], signs[1 - even]
        for j in range(ny):
            for k in range(nz):
                now[j, k] = values[i, j, k] < 0
        if total + 4 * plane > len(vertices):
            vertices = _longer(vertices, total, total + 4 * plane)
            edges = _longer_list(edges, total, len(vertices))
        if shared + 3 * plane > len(border):
            border = _longer_list(border, shared, shared + 3 * plane)
            keys = _longer_list(keys, shared, shared + 3 * plane)
        for axis in range(3):
            slot, back = 0, 0
            if axis:  # the edges in this plane; along x, those from the plane before to this one
                slot = 2 * axis - 1 + even
            elif i:
                back = 1
            else:
                continue
            total, shared = _cross(
                axis, i - back, signs[(i - back) % 2], now, values[i - back], values[i],
                int(axis == 1), int(axis == 2), marks, number[slot * plane : (slot + 1) * plane],
                vertices, edges, total, border, keys, shared, nx, frame, around,
            )  # fmt: skip
        if i:
            if made + _MOST_TRIANGLES * plane > len(faces):
                faces = _longer(faces, made, made + _MOST_TRIANGLES * plane)
            total, made = _fill(
                values[i - 1], values[i], before, now, marks, number, shift[1 - even],
                vertices, edges, total, faces, made, cases,
            )  # fmt: skip
    return vertices[:total], faces[:made], border[:shared], keys[:shared], edges[:total]


@compiled
def _shifts(ny: int, nz: int) -> NDArray[np.int64]:
    """Where the number of each edge of a cell stands, counted from its first node, for one in an even or odd plane."""
    out = np.zeros((2, 12), np.int64)
    for even in range(2):
        for e in range(12):
            x, y, z = _STARTS_AT[e]
            axis = _AXIS_OF[e]
            slot = 0 if axis == 0 else 2 * axis - 1 + (x ^ even)
            out[even, e] = (slot * ny + y) * nz + z
    return out


@compiled
def _longer(rows: NDArray[Any], used: int, least: int) -> NDArray[Any]:
    """An array with room for `least` rows that begins with those `used` of this one."""
    out = np.empty((max(least, 2 * len(rows)), 3), rows.dtype)
    for i in range(used):  # a loop, for Numba takes seconds to compile the assignment of a slice
        for n in range(3):
            out[i, n] = rows[i, n]
    return out


@compiled
def _longer_list(rows: NDArray[Any], used: int, least: int) -> NDArray[Any]:
    out = np.empty(max(least, 2 * len(rows)), rows.dtype)
    for i in range(used):
        out[i] = rows[i]
    return out


@compiled
def _cross(
    axis: int,
    i: int,
    begin: Bytes,
    end: Bytes,
    near: NDArray[Any],
    far: NDArray[Any],
    dj: int,
    dk: int,
    marks: Bytes,
    number: Numbers,
    vertices: Floats,
    edges: Ints,
    total: int,
    border: Numbers,
    keys: Ints,
    shared: int,
    nx: int,
    frame: Frame,
    around: tuple[int, int, int, int, int],
) -> tuple[int, int]:
    """A vertex on every crossed edge along `axis`: from nodes (i, j, k) to those of `end` and `far` `dj, dk` further.

    Gives how many vertices, and how many on the border, there are then.
    """
    ny, nz = begin.shape
    by_eight = marks.view(np.uint64)
    seats, least, box, lo, whole = frame.seats, frame.least[axis], frame.box, frame.lo, frame.whole
    cap_lo, cap_hi = -lo[axis], whole[axis] - 2 - lo[axis]
    outer_i = i == 0 or i == nx - 1
    hits = np.empty(8, np.int64)
    for j in range(ny - dj):
        other = end[j + dj, dk:]
        outer_j = j == 0 or j == ny - 1
        for k in range(nz - dk):
            marks[k] = begin[j, k] ^ other[k]
        for k in range(nz - dk, len(marks)):
            marks[k] = 0
        for word in range(len(by_eight)):
            if by_eight[word] == 0:
                continue
            many = 0  # the hits are listed first, without a branch that nobody can predict
            for k in range(8 * word, 8 * word + 8):
                hits[many] = k
                many += marks[k]
            for hit in range(many):
                k = hits[hit]
                from_ = i if axis == 0 else j if axis == 1 else k
                capped = from_ in (cap_lo, cap_hi)
                seat = 0 if capped else 1
                # On a cap the layers next to the bounds of the other axes keep their distance.
                vertices[total, 0] = seats[seat, 0, i]
                vertices[total, 1] = seats[seat, 1, j]
                vertices[total, 2] = seats[seat, 2, k]
                if capped:
                    vertices[total, axis] = box[0 if from_ == cap_lo else 1, axis]
                else:
                    a = min(max(np.float64(near[j, k]), -_HUGE), _HUGE)
                    b = min(max(np.float64(far[j + dj, k + dk]), -_HUGE), _HUGE)
                    start, length = seats[0, axis, from_], seats[0, axis, from_ + 1] - seats[0, axis, from_]
                    part = min(max(a / (a - b), least[from_]), 1 - least[from_])
                    vertices[total, axis] = start + part * length
                number[j * nz + k] = total
                place = ((i + around[0]) * around[3] + j + around[1]) * around[4] + k + around[2]
                edges[total] = (place << PLACED) + (from_ + around[axis] << 2) + axis
                if (axis and outer_i) or (axis != 1 and outer_j) or (axis != 2 and (k == 0 or k == nz - 1)):
                    border[shared] = total
                    node = (i + lo[0]) * whole[1] + j + lo[1]
                    keys[shared] = 4 * (node * whole[2] + k + lo[2]) + axis
                    shared += 1
                total += 1
    return total, shared


@compiled
def _fill(
    low: NDArray[Any],
    high: NDArray[Any],
    before: Bytes,
    now: Bytes,
    marks: Bytes,
    number: Numbers,
    shift: Ints,
    vertices: Floats,
    on: Ints,
    total: int,
    faces: Numbers,
    made: int,
    cases: Cases,
) -> tuple[int, int]:
    """The triangles of the cells between two planes of nodes; gives how many vertices and triangles there are then."""
    ny, nz = before.shape
    by_eight = marks.view(np.uint64)
    rows, ambiguous, starts, counts, edges, centred = cases
    corners = np.empty(8)
    hits = np.empty(8, np.int64)
    for j in range(ny - 1):
        a, b, c, d = before[j], before[j + 1], now[j], now[j + 1]
        for k in range(nz - 1):
            marks[k] = (
                a[k] | a[k + 1] << 1 | b[k] << 2 | b[k + 1] << 3
                | c[k] << 4 | c[k + 1] << 5 | d[k] << 6 | d[k + 1] << 7
            )  # fmt: skip
        for k in range(nz - 1, len(marks)):
            marks[k] = 0
        for word in range(len(by_eight)):
            if by_eight[word] == 0 or by_eight[word] == _FULL:
                continue
            many = 0
            for k in range(8 * word, 8 * word + 8):
                hits[many] = k
                many += (marks[k] != 0) & (marks[k] != 255)
            for hit in range(many):
                k = hits[hit]
                case = marks[k]
                joined = 0
                if ambiguous[case]:
                    for n in range(4):
                        corners[n] = np.float64(low[j + (n >> 1), k + (n & 1)])
                        corners[4 + n] = np.float64(high[j + (n >> 1), k + (n & 1)])
                    joined = _joined(corners)
                row = rows[np.int64(case) * 64 + joined]
                first = j * nz + k
                start, end = starts[row], starts[row] + counts[row]
                for t in range(start, end):
                    for corner in range(3):
                        e = edges[t, corner]
                        faces[made, corner] = total if e == _CENTRE else number[shift[e] + first]
                    made += 1
                if centred[row]:
                    mine = made - (end - start)  # the triangles of another sheet in the cell may come before the fan
                    on[total] = -1 - mine - _centre(vertices, total, faces[mine:made])
                    total += 1
    return total, made


@compiled
def _joined(corners: Floats) -> int:
    """The bits of the faces whose solid corners connect: there the bilinear interpolant is solid at its saddle."""
    bits = 0
    for face in range(6):
        a, b, c, d = _DIAGONALS[face]
        # Kept from overflow. A product of two float32 is exact here, one of two float64 does not depend on their order.
        one = min(max(corners[a], -1e150), 1e150) * min(max(corners[b], -1e150), 1e150)
        other = min(max(corners[c], -1e150), 1e150) * min(max(corners[d], -1e150), 1e150)
        if (one > other) if corners[a] < 0 else (other > one):
            bits |= 1 << face
    return bits


@compiled
def _centre(vertices: Floats, which: int, cell: Numbers) -> int:
    """Put a vertex in the middle of the loop that its fan of triangles (start, end, centre) spans, and give the first
    of these in the `cell`."""
    vertices[which] = 0.0
    many, first = 0, 0
    for t in range(len(cell)):
        if cell[t, 2] == which:
            if many == 0:
                first = t
            many += 1
            for n in range(3):
                vertices[which, n] += vertices[cell[t, 0], n]
    for n in range(3):
        vertices[which, n] /= many
    return first
