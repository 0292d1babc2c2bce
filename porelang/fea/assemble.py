"""The stiffness matrix, in blocks of 3 x 3, row by row: each row is written by one thread, from the elements round
its node.

With straight edges the gradient of a shape function is a sum over corners k of a linear function times grad L_k, and
so each block is

    K_ab = lambda G_ab + mu G_ab^T + mu tr(G_ab) I,    G_ab = V sum_kl c_akbl grad L_k grad L_l^T

with numbers c that are the same in all tetrahedra (`terms`): no quadrature, and nothing but the matrix itself is
kept. A row costs twice what symmetry would allow, and in return nothing waits, and the sums have one order on any
number of threads (docs/decisions/0016).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.fea.elements import terms
from porelang.fea.nodes import Nodes
from porelang.fea.problem import Floats, Ints, Mask
from porelang.parallel import parallel_for, workers

Longs = NDArray[np.int64]
#: Rows that a thread takes at once.
_ROWS = 16_384


def lame(young: Floats, poisson: Floats) -> Floats:
    """Lame's constants lambda and mu, (m, 2) MPa."""
    mu = young / (2 * (1 + poisson))
    return np.stack([2 * mu * poisson / (1 - 2 * poisson), mu], axis=1)


class Blocks:
    """A square matrix of 3 x 3 blocks by rows, as `scipy.sparse.bsr_array` has it: columns ascend in each row."""

    __slots__ = ("data", "indices", "indptr")

    def __init__(self, indptr: Longs, indices: Ints, data: Floats) -> None:
        self.indptr, self.indices, self.data = indptr, indices, data

    def __matmul__(self, vector: Floats) -> Floats:
        out = np.empty_like(vector)
        self.into(vector, out)
        return out

    def into(self, vector: Floats, out: Floats) -> None:
        """The product with a vector (n, 3), written to `out`."""
        over_rows(len(out), lambda r: multiply(r[0], r[1], self.indptr, self.indices, self.data, vector, out))

    def hold(self, held: Mask) -> None:
        """Take held components (n, 3) out: their rows and columns are 0, the diagonal stays as it was."""
        over_rows(len(held), lambda r: hold(r[0], r[1], self.indptr, self.indices, self.data, held))

    def diagonal(self, rows: Longs) -> Floats:
        """The blocks (n, 3, 3) of some rows (n,) on the diagonal."""
        out = np.empty((len(rows), 3, 3))
        pick_diagonal(rows.astype(np.int64), self.indptr, self.indices, self.data, out)
        return out

    def add(self, rows: Ints, columns: Ints, values: Floats) -> None:
        """Add values (n, 3) to the diagonals of blocks that are there: pairs (n,), (n,) may come more than once."""
        add_to(rows, columns, values, self.indptr, self.indices, self.data)

    def to_scipy(self) -> Any:
        from scipy.sparse import bsr_matrix

        rows = 3 * (len(self.indptr) - 1)
        narrow = np.int32 if self.indptr[-1] < 2**31 else np.int64
        return bsr_matrix((self.data, self.indices, self.indptr.astype(narrow)), shape=(rows, rows))


def stiffness(nodes: Nodes, constants: Floats, order: int | None = None) -> Blocks:
    """The stiffness of all nodes, N/mm; `order` 1 is that of the vertices alone.

    `constants` are Lame's (m, 2).
    """
    order = nodes.order if order is None else order
    elements = nodes.elements if order == 2 else np.ascontiguousarray(nodes.corners)
    count = len(nodes.points) if order == 2 else nodes.vertices
    corners, numbers = terms(order)
    starts, items = incidence(elements, count)
    indptr = np.zeros(count + 1, np.int64)
    over_rows(count, lambda r: count_columns(r[0], r[1], starts, items, elements, count, indptr))
    np.cumsum(indptr, out=indptr)
    indices = np.empty(indptr[-1], np.int32)
    data = np.empty((indptr[-1], 3, 3))
    over_rows(count, lambda r: fill_rows(r[0], r[1], starts, items, elements, nodes.gradients, nodes.volumes, constants,
                                          corners, numbers, count, indptr, indices, data))  # fmt: skip
    return Blocks(indptr, indices, data)


def over_rows(count: int, work: Any) -> None:
    ranges = [(first, min(first + _ROWS, count)) for first in range(0, count, _ROWS)]
    parallel_for(work, ranges, workers())


@compiled
def incidence(elements: Ints, count: int) -> tuple[Longs, Longs]:
    """For each node the elements round it, as element times width plus its place there."""
    m, width = elements.shape
    starts = np.zeros(count + 1, np.int64)
    for e in range(m):
        for a in range(width):
            starts[elements[e, a] + 1] += 1
    for i in range(count):
        starts[i + 1] += starts[i]
    at = starts[:-1].copy()
    items = np.empty(starts[count], np.int64)
    for e in range(m):
        for a in range(width):
            i = elements[e, a]
            items[at[i]] = e * width + a
            at[i] += 1
    return starts, items


@compiled
def count_columns(
    first: int, last: int, starts: Longs, items: Longs, elements: Ints, count: int, counts: Longs
) -> None:
    """How many nodes share an element with each node from `first` to `last`: at `counts[node + 1]`."""
    width = elements.shape[1]
    seen = np.full(count, -1, np.int32)
    for row in range(first, last):
        total = 0
        for s in range(starts[row], starts[row + 1]):
            e = items[s] // width
            for b in range(width):
                column = elements[e, b]
                if seen[column] != row:
                    seen[column] = row
                    total += 1
        counts[row + 1] = total


@compiled
def fill_rows(
    first: int, last: int, starts: Longs, items: Longs, elements: Ints, gradients: Floats, volumes: Floats,
    constants: Floats, corners: Ints, numbers: Floats, count: int, indptr: Longs, indices: Ints, data: Floats,
) -> None:  # fmt: skip
    """Columns and blocks of the rows from `first` to `last`."""
    width = elements.shape[1]
    seen = np.full(count, -1, np.int32)
    place = np.empty(count, np.int64)
    left, g = np.empty(3), np.empty((3, 3))
    for row in range(first, last):
        begin, end = indptr[row], indptr[row]
        for s in range(starts[row], starts[row + 1]):
            e = items[s] // width
            for b in range(width):
                column = elements[e, b]
                if seen[column] != row:
                    seen[column] = row
                    at = end  # sorted by insertion: rows are short
                    while at > begin and indices[at - 1] > column:
                        indices[at] = indices[at - 1]
                        at -= 1
                    indices[at] = column
                    end += 1
        for at in range(begin, end):
            place[indices[at]] = at
            for i in range(3):
                for j in range(3):
                    data[at, i, j] = 0.0
        for s in range(starts[row], starts[row + 1]):
            e, a = items[s] // width, items[s] % width
            lam, mu = constants[e, 0] * volumes[e], constants[e, 1] * volumes[e]
            for b in range(width):
                for i in range(3):
                    for j in range(3):
                        g[i, j] = 0.0
                for n in range(2):
                    if corners[b, n] < 0:
                        continue
                    for i in range(3):
                        left[i] = 0.0
                    for k in range(2):
                        if corners[a, k] >= 0:
                            c = numbers[a, k, b, n]
                            for i in range(3):
                                left[i] += c * gradients[e, corners[a, k], i]
                    for i in range(3):
                        for j in range(3):
                            g[i, j] += left[i] * gradients[e, corners[b, n], j]
                trace = mu * (g[0, 0] + g[1, 1] + g[2, 2])
                at = place[elements[e, b]]
                for i in range(3):
                    for j in range(3):
                        data[at, i, j] += lam * g[i, j] + mu * g[j, i]
                    data[at, i, i] += trace


@compiled
def multiply(first: int, last: int, indptr: Longs, indices: Ints, data: Floats, x: Floats, out: Floats) -> None:
    """Rows from `first` to `last` of a product with a vector (n, 3)."""
    for row in range(first, last):
        a, b, c = 0.0, 0.0, 0.0
        for at in range(indptr[row], indptr[row + 1]):
            col = indices[at]
            u, v, w = x[col, 0], x[col, 1], x[col, 2]
            a += data[at, 0, 0] * u + data[at, 0, 1] * v + data[at, 0, 2] * w
            b += data[at, 1, 0] * u + data[at, 1, 1] * v + data[at, 1, 2] * w
            c += data[at, 2, 0] * u + data[at, 2, 1] * v + data[at, 2, 2] * w
        out[row, 0], out[row, 1], out[row, 2] = a, b, c


@compiled
def pick_diagonal(rows: Longs, indptr: Longs, indices: Ints, data: Floats, out: Floats) -> None:
    """The blocks (n, 3, 3) of some rows on the diagonal."""
    for n in range(len(rows)):
        for at in range(indptr[rows[n]], indptr[rows[n] + 1]):
            if indices[at] == rows[n]:
                for i in range(3):
                    for j in range(3):
                        out[n, i, j] = data[at, i, j]


@compiled
def add_to(rows: Ints, columns: Ints, values: Floats, indptr: Longs, indices: Ints, data: Floats) -> None:
    """Add values (n, 3) to the diagonals of the blocks of rows and columns (n,)."""
    for n in range(len(rows)):
        for at in range(indptr[rows[n]], indptr[rows[n] + 1]):
            if indices[at] == columns[n]:
                for i in range(3):
                    data[at, i, i] += values[n, i]


@compiled
def hold(first: int, last: int, indptr: Longs, indices: Ints, data: Floats, held: Mask) -> None:
    """Take held components (n, 3) out of the rows from `first` to `last`: rows and columns 0, the diagonal as it
    was."""
    for row in range(first, last):
        for at in range(indptr[row], indptr[row + 1]):
            col = indices[at]
            for i in range(3):
                for j in range(3):
                    if (held[row, i] or held[col, j]) and not (row == col and i == j):
                        data[at, i, j] = 0.0


@compiled
def internal(
    elements: Ints, gradients: Floats, volumes: Floats, constants: Floats, corners: Ints, factors: Floats,
    displacement: Floats, out: Floats,
) -> None:  # fmt: skip
    """Add to `out` (k, 3) N the forces with which stresses resist a displacement (k, 3): K u without K.

    `factors` (q, w, 2) are those of grad L at the quadrature's points, of equal weight.
    """
    m, width = elements.shape
    points = factors.shape[0]
    slope, own, stress = np.empty((3, 3)), np.empty((width, 3)), np.empty((3, 3))
    for e in range(m):
        weight = volumes[e] / points
        for q in range(points):
            for i in range(3):
                for j in range(3):
                    slope[i, j] = 0.0
            for a in range(width):
                for j in range(3):
                    own[a, j] = factors[q, a, 0] * gradients[e, corners[a, 0], j]
                    if corners[a, 1] >= 0:
                        own[a, j] += factors[q, a, 1] * gradients[e, corners[a, 1], j]
                for i in range(3):
                    for j in range(3):
                        slope[i, j] += displacement[elements[e, a], i] * own[a, j]
            trace = constants[e, 0] * (slope[0, 0] + slope[1, 1] + slope[2, 2])
            for i in range(3):
                for j in range(3):
                    stress[i, j] = weight * constants[e, 1] * (slope[i, j] + slope[j, i])
                stress[i, i] += weight * trace
            for a in range(width):
                for i in range(3):
                    for j in range(3):
                        out[elements[e, a], i] += stress[i, j] * own[a, j]
