"""How a surface crosses one cell of a grid: the table of marching cubes, derived from its rules.

A cell has eight corners, solid or void, and the surface crosses every edge between a solid and a void corner. On each
face the crossings are joined two by two; the segments of the six faces close to loops, and a loop is spanned by
triangles. Two neighbours see the same four corners of their common face and join them alike, so the mesh is closed; no
diagonal of a loop lies in a face, so no edge has more than two triangles; and round a vertex (which is a grid edge)
each of its four cells contributes one fan, so the mesh is a manifold.

A face with two solid corners on one diagonal can be joined in two ways. There the bilinear interpolant decides
(Nielson & Hamann 1991, "The asymptotic decider"): a row of the table is chosen by the corners' signs (256) and by
which of the six faces connect their solid corners. The rows are generated, not typed in, as nobody can check such a
list by eye.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

# Corner k of a cell lies at (k >> 2 & 1, k >> 1 & 1, k & 1).
CORNERS = tuple((k >> 2 & 1, k >> 1 & 1, k & 1) for k in range(8))
# An edge runs from its first corner along its axis.
EDGES = tuple((k, k | 4 >> axis, axis) for axis in range(3) for k in range(8) if not k & 4 >> axis)
CENTRE = len(EDGES)  # the thirteenth place of a vertex: inside the cell


def _face(axis: int, side: int) -> tuple[int, ...]:
    """The corners of a face, counter-clockwise seen from outside the cell."""
    u, v = 4 >> (axis + 1) % 3, 4 >> (axis + 2) % 3
    start = side * (4 >> axis)
    ring = (start, start | u, start | u | v, start | v)
    return ring if side else ring[::-1]


FACES = tuple(_face(axis, side) for axis in range(3) for side in range(2))
# The corners of each face as its two diagonals, in an order that both cells at the face share.
DIAGONALS = tuple((min(f), max(f), *sorted(set(f) - {min(f), max(f)})) for f in FACES)
EDGE_OF = {frozenset(e[:2]): i for i, e in enumerate(EDGES)}
FACES_OF = tuple({i for i, f in enumerate(FACES) if {a, b} <= set(f)} for a, b, _ in EDGES)
MIDDLES = np.array([(np.array(CORNERS[a]) + CORNERS[b]) / 2 for a, b, _ in EDGES])
_SIDES = MIDDLES[None, :] - MIDDLES[:, None]
AREAS = np.linalg.norm(np.cross(_SIDES[:, :, None], _SIDES[:, None, :]), axis=-1).tolist()  # twice, of three middles


@dataclass(frozen=True)
class Table:
    """Rows of triangles: `edges[start[row] : start[row] + count[row]]` are (n, 3) edge numbers 0..12.

    `row[corners * 64 + joined]` is the row for a byte of solid corners and the bits of the faces that connect their
    solid corners; `ambiguous[corners]` are the bits that matter. `centred[row]` tells the rows that have a vertex
    inside the cell.
    """

    row: NDArray[np.int16]
    ambiguous: NDArray[np.uint8]
    start: NDArray[np.int64]
    count: NDArray[np.int64]
    edges: NDArray[np.uint8]
    centred: NDArray[np.bool_]


@cache
def table() -> Table:
    """The table of all cells (made once, in a fraction of a second)."""
    row = np.zeros(256 * 64, np.int16)
    ambiguous = np.zeros(256, np.uint8)
    triangles: list[list[tuple[int, int, int]]] = []
    for corners in range(256):
        solid = [bool(corners >> k & 1) for k in range(8)]
        mask = sum(1 << i for i, f in enumerate(FACES) if _is_ambiguous(solid, f))
        ambiguous[corners] = mask
        rows: dict[int, int] = {}
        for joined in range(64):
            kept = joined & mask
            if kept not in rows:
                rows[kept] = len(triangles)
                triangles.append([t for loop in _loops(solid, kept) for t in _span(loop)])
            row[corners * 64 + joined] = rows[kept]
    count = np.array([len(t) for t in triangles], np.int64)
    edges = np.array([t for ts in triangles for t in ts], np.uint8)
    centred = np.array([any(CENTRE in t for t in ts) for ts in triangles])
    return Table(row, ambiguous, np.cumsum(count) - count, count, edges, centred)


def _is_ambiguous(solid: list[bool], face: tuple[int, ...]) -> bool:
    a, b, c, d = (solid[k] for k in face)
    return a == c and b == d and a != b


def _loops(solid: list[bool], joined: int) -> list[list[int]]:
    """The closed chains of edges where the surface meets the faces of a cell, counter-clockwise seen from the void."""
    following: dict[int, int] = {}
    for i, face in enumerate(FACES):
        ring = list(zip(face, (*face[1:], face[0]), strict=True))
        crossed = [(EDGE_OF[frozenset(pair)], solid[pair[0]]) for pair in ring if solid[pair[0]] != solid[pair[1]]]
        # Each run of solid corners has the edge that leaves it and the edge that enters it. A segment joins the leaving
        # edge to the entering edge of the same run (the corner is cut off) or of the next (the solid corners connect).
        for n, (edge, leaves) in enumerate(crossed):
            if leaves:
                step = 1 if joined >> i & 1 else -1
                following[crossed[(n + step) % len(crossed)][0]] = edge
    loops = []
    while following:
        first = next(iter(following))
        loop = [first]
        while (edge := following.pop(loop[-1])) != first:
            loop.append(edge)
        loops.append(loop)
    return loops


def _span(loop: list[int]) -> list[tuple[int, int, int]]:
    """Triangles that span a loop: the least area (of the edges' middles) among those with no diagonal in a face."""
    n = len(loop)
    best: dict[tuple[int, int], tuple[float, list[tuple[int, int, int]]]] = {(i, i + 1): (0.0, []) for i in range(n)}
    for width in range(2, n):
        for i in range(n - width):
            j = i + width
            if width < n - 1 and FACES_OF[loop[i]] & FACES_OF[loop[j]]:
                continue
            for k in range(i + 1, j):
                if (i, k) in best and (k, j) in best:
                    area = AREAS[loop[i]][loop[k]][loop[j]] + best[i, k][0] + best[k, j][0]
                    if (i, j) not in best or area < best[i, j][0] - 1e-9:
                        best[i, j] = (area, [*best[i, k][1], (loop[i], loop[k], loop[j]), *best[k, j][1]])
    if (0, n - 1) in best:
        return best[0, n - 1][1]
    return [(a, b, CENTRE) for a, b in pairwise([*loop, loop[0]])]
