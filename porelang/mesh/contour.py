"""The surface in one block of samples: marching cubes in NumPy, which lets other threads run while it works.

scikit-image's marching cubes holds the interpreter's lock, and gives edges of four triangles where the two diagonals of
a face tie (a field of +1 and -1 does so on purpose, a symmetric lattice by accident). Here every vertex has the integer
key of the grid edge it lies on, and its place is computed from that edge's two samples alone, so neighbouring blocks
agree on it to the last bit.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.cells import CORNERS, DIAGONALS, EDGES, table
from porelang.mesh.grid import Index
from porelang.mesh.layers import Layers, Values

Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """The triangles of a block: `vertices` (n, 3) mm and `faces` (m, 3) into them.

    `border` (b,) are the vertices that neighbouring blocks may share, and `keys` (b,) their keys: four times the number
    of a node plus the axis of the edge that starts there.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int32]
    border: Ints
    keys: Ints


def contour(values: Values, layers: Layers, lo: Index) -> Patch:
    """The surface where `values`, the field at the layers from `lo` on, passes zero; negative is solid."""
    shape = (values.shape[0], values.shape[1], values.shape[2])
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
    centred = cells[cases.centred[row]]
    number[3 * flat.size + centred] = np.arange(total, total + len(centred), dtype=np.int32)
    count = cases.count[row]
    first = np.cumsum(count) - count
    triangle = np.repeat(cases.start[row] - first, count)
    triangle += np.arange(len(triangle))
    corners = _shifted(shape).take(triangle, axis=0)
    corners += np.repeat(cells.astype(corners.dtype), count)[:, None]
    faces = number.take(corners)

    parts = [_place(flat, nodes, axis, shape, strides, layers, lo) for axis, nodes in enumerate(crossed)]
    vertices = np.concatenate([p[0] for p in parts])
    if len(centred):
        vertices = np.concatenate([vertices, _centres(vertices, faces[faces[:, 2] >= total], total, len(centred))])
    starts = np.cumsum([0, *map(len, crossed)])
    border = np.concatenate([start + p[1] for start, p in zip(starts[:3], parts, strict=True)])
    keys = np.concatenate([
        4 * _globally(nodes[p[1]], shape, layers.shape, lo) + axis
        for axis, (nodes, p) in enumerate(zip(crossed, parts, strict=True))
    ])
    return Patch(vertices, faces, border, keys)


@lru_cache(maxsize=32)
def _shifted(shape: Index) -> NDArray[Any]:
    """The corners of the table's triangles as places in `number`, counted from a cell's first node."""
    size = shape[0] * shape[1] * shape[2]
    strides = (shape[1] * shape[2], shape[2], 1)
    shift = [axis * size + int(np.dot(CORNERS[k], strides)) for k, _, axis in EDGES] + [3 * size]
    return np.array(shift, np.int32 if 4 * size < 2**31 else np.int64)[table().edges]


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
    return cells, cases.row[case.astype(np.int64) * 64 + joined]


def _place(
    flat: Values, nodes: Ints, axis: int, shape: Index, strides: Index, layers: Layers, lo: Index
) -> tuple[NDArray[np.float64], Ints]:
    """Where the surface passes the edges that start at `nodes`, and which of them lie on the block's border."""
    place = np.empty((len(nodes), 3))
    border = np.zeros(len(nodes), np.bool_)
    index = _unravel(nodes, shape)
    along = layers.axes[axis]
    first, last = lo[axis], lo[axis] + shape[axis]
    capped = first == 0 or last >= len(along)
    start = index[axis] + lo[axis]
    cap = (start == 0) | (start == len(along) - 2) if capped else None
    for n, other in enumerate(layers.axes):
        if n != axis:
            rim = other.rim[lo[n] : lo[n] + shape[n]].take(index[n])
            # On a cap the layers next to the bounds of the other axes keep their distance.
            place[:, n] = rim if cap is None else np.where(cap, other.at[lo[n] : lo[n] + shape[n]].take(index[n]), rim)
            border |= (index[n] == 0) | (index[n] == shape[n] - 1)
    near = flat.take(nodes).astype(np.float64)
    far = flat.take(nodes + strides[axis]).astype(np.float64)
    biggest = np.finfo(np.float64).max / 4
    np.clip(near, -biggest, biggest, out=near)
    np.clip(far, -biggest, biggest, out=far)
    begin = along.at.take(start)
    length = along.at.take(start + 1) - begin
    least = np.minimum(layers.hair / length, 0.25)
    part = np.clip(near / (near - far), least, 1 - least)
    place[:, axis] = begin + part * length
    if cap is not None:
        place[cap, axis] = np.where(start[cap] == 0, along.lo, along.hi)
    return place, np.flatnonzero(border)


def _centres(vertices: NDArray[np.float64], fans: NDArray[np.int32], first: int, count: int) -> NDArray[np.float64]:
    """The middle of each loop that is spanned by a fan, from the fan's triangles (start, end, centre)."""
    which = fans[:, 2] - first
    sums = [np.bincount(which, vertices[fans[:, 0], n], count) for n in range(3)]
    return np.stack(sums, axis=1) / np.bincount(which, minlength=count)[:, None]


def _unravel(nodes: Ints, shape: Index) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    size = shape[0] * shape[1] * shape[2]
    small = nodes.astype(np.int32) if size < 2**31 else nodes  # NumPy divides 32-bit numbers several times as fast
    rest = small // shape[2]
    i = rest // shape[1]
    return i, rest - i * shape[1], small - rest * shape[2]


def _globally(nodes: Ints, shape: Index, whole: Index, lo: Index) -> Ints:
    """The numbers of a block's nodes in the whole of the layers."""
    i, j, k = (n.astype(np.int64) for n in _unravel(nodes, shape))
    return ((i + lo[0]) * whole[1] + j + lo[1]) * whole[2] + k + lo[2]
