"""The surface in one block of samples: marching cubes in NumPy, which lets other threads run while it works.

scikit-image's marching cubes holds the interpreter's lock, and gives edges of four triangles where the two diagonals of
a face tie (a field of +1 and -1 does so on purpose, a symmetric lattice by accident). Here every vertex has the integer
key of the grid edge it lies on, and its place is computed from that edge's two samples alone, so neighbouring blocks
agree on it to the last bit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.cells import CENTRE, CORNERS, DIAGONALS, EDGES, table
from porelang.mesh.grid import Index
from porelang.mesh.layers import Layers, Values

Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """The triangles of a block: `vertices` (n, 3) mm with their `keys` (n,), `faces` (m, 3) into them.

    A key is four times the number of a node plus the axis of the edge that starts there, or plus 3 for a vertex inside
    the cell that starts there. `border` (n,) tells the vertices that neighbouring blocks may share.
    """

    keys: Ints
    vertices: NDArray[np.float64]
    faces: NDArray[np.int32]
    border: NDArray[np.bool_]


def contour(values: Values, layers: Layers, lo: Index) -> Patch:
    """The surface where `values`, the field at the layers from `lo` on, passes zero; negative is solid."""
    shape = values.shape
    strides = (shape[1] * shape[2], shape[2], 1)
    flat = values.ravel()
    solid = values < 0
    crossed = _crossed(solid)
    number = np.empty(4 * flat.size, np.int32)  # the vertex on each edge that is crossed; the rest is never read
    total = 0
    for axis, nodes in enumerate(crossed):
        number[axis * flat.size + nodes] = np.arange(total, total + len(nodes), dtype=np.int32)
        total += len(nodes)

    cells, row = _rows(solid, flat, strides)
    cases = table()
    count = cases.count[row]
    cell = np.repeat(cells, count)
    first = np.cumsum(count) - count
    edges = cases.edges[np.repeat(cases.start[row] - first, count) + np.arange(len(cell))]
    shift = [a * flat.size + int(np.dot(CORNERS[k], strides)) for k, _, a in EDGES] + [3 * flat.size]
    centred = np.unique(cell[edges[:, 2] == CENTRE])
    number[3 * flat.size + centred] = np.arange(total, total + len(centred), dtype=np.int32)
    faces = number[np.array(shift)[edges] + cell[:, None]]

    parts = [_place(flat, nodes, axis, shape, strides, layers, lo) for axis, nodes in enumerate(crossed)]
    vertices = np.concatenate([p[0] for p in parts])
    if len(centred):
        vertices = np.concatenate([vertices, _centres(vertices, faces[faces[:, 2] >= total], total, len(centred))])
    border = np.concatenate([*(p[1] for p in parts), np.zeros(len(centred), np.bool_)])
    groups = (*crossed, centred)
    keys = np.concatenate([4 * _globally(nodes, shape, layers.shape, lo) + k for k, nodes in enumerate(groups)])
    return Patch(keys, vertices, faces, border)


def _crossed(solid: NDArray[np.bool_]) -> tuple[Ints, Ints, Ints]:
    """For each axis the flat numbers of the nodes whose edge along it is crossed."""
    found: list[Ints] = []
    for axis in range(3):
        ends = np.zeros(solid.shape, np.bool_)
        low: Any = (slice(None),) * axis + (slice(None, -1),)
        high: Any = (slice(None),) * axis + (slice(1, None),)
        np.not_equal(solid[high], solid[low], out=ends[low])
        found.append(np.flatnonzero(ends))
    return found[0], found[1], found[2]


def _rows(solid: NDArray[np.bool_], flat: Values, strides: Index) -> tuple[Ints, Ints]:
    """The cells that the surface passes, by their first node, and the row of the table for each."""
    bits: NDArray[Any] = solid.view(np.uint8)
    bits = bits[:, :, :-1] | bits[:, :, 1:] << 1
    bits = bits[:, :-1] | bits[:, 1:] << 2
    corners = np.zeros(solid.shape, np.uint8)
    corners[:-1, :-1, :-1] = bits[:-1] | bits[1:] << 4
    cells = np.flatnonzero(corners + np.uint8(1) > 1)  # neither 0, all void, nor 255, all solid
    case = corners.ravel()[cells]
    cases = table()
    joined = np.zeros(len(cells), np.int64)
    unclear = np.flatnonzero(cases.ambiguous[case])
    if len(unclear):
        offsets = np.array([np.dot(c, strides) for c in CORNERS])
        # The product of two float32 is exact in float64, and that of two float64 does not depend on their order.
        at = flat[cells[unclear, None] + offsets].astype(np.float64)
        np.clip(at, -1e150, 1e150, out=at)
        for i, (a, b, c, d) in enumerate(DIAGONALS):
            one, other = at[:, a] * at[:, b], at[:, c] * at[:, d]
            joined[unclear] |= np.where(at[:, a] < 0, one > other, other > one).astype(np.int64) << i
    return cells, cases.row[case.astype(np.int64) * 64 + joined].astype(np.int64)


def _place(
    flat: Values, nodes: Ints, axis: int, shape: tuple[int, ...], strides: Index, layers: Layers, lo: Index
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Where the surface passes the edges that start at `nodes`, and which of them lie on the block's border."""
    place = np.empty((len(nodes), 3))
    border = np.zeros(len(nodes), np.bool_)
    index = _unravel(nodes, shape)
    along = layers.axes[axis]
    start = index[axis] + lo[axis]
    cap = (start == 0) | (start == len(along) - 2)
    for n, other in enumerate(layers.axes):
        if n != axis:
            i = index[n] + lo[n]
            place[:, n] = np.where(cap, other.at[i], other.rim[i])
            border |= (index[n] == 0) | (index[n] == shape[n] - 1)
    near = flat[nodes].astype(np.float64)
    far = flat[nodes + strides[axis]].astype(np.float64)
    biggest = np.finfo(np.float64).max / 4
    np.clip(near, -biggest, biggest, out=near)
    np.clip(far, -biggest, biggest, out=far)
    length = along.at[start + 1] - along.at[start]
    least = np.minimum(layers.hair / length, 0.25)
    part = np.clip(near / (near - far), least, 1 - least)
    place[:, axis] = np.where(cap, np.where(start == 0, along.lo, along.hi), along.at[start] + part * length)
    return place, border


def _centres(vertices: NDArray[np.float64], fans: NDArray[np.int32], first: int, count: int) -> NDArray[np.float64]:
    """The middle of each loop that is spanned by a fan, from the fan's triangles (start, end, centre)."""
    which = fans[:, 2] - first
    sums = [np.bincount(which, vertices[fans[:, 0], n], count) for n in range(3)]
    return np.stack(sums, axis=1) / np.bincount(which, minlength=count)[:, None]


def _unravel(nodes: Ints, shape: tuple[int, ...]) -> tuple[Ints, Ints, Ints]:
    rest, k = np.divmod(nodes, shape[2])
    i, j = np.divmod(rest, shape[1])
    return i, j, k


def _globally(nodes: Ints, shape: tuple[int, ...], whole: Index, lo: Index) -> Ints:
    """The numbers of a block's nodes in the whole of the layers."""
    i, j, k = _unravel(nodes, shape)
    return ((i + lo[0]) * whole[1] + j + lo[1]) * whole[2] + k + lo[2]
