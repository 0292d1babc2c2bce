"""Hexahedra and wedges of second order, cut into tetrahedra that have all of their points as corners.

Each face is cut about its corners and across the middles of its edges, the same from both sides, and joined with the
middle of the cell, whose place and value are those of the cell's own shape functions (O. Zienkiewicz, R. Taylor, The
Finite Element Method, 2000, vol. 1, 8.7 and 8.9): what is quadratic is exact at all of these points.
"""

from __future__ import annotations

import numpy as np

from porelang.tasks.readers.asked import Array

#: VTK's edges between corners, in the order of the points in their middles, and faces, of hexahedra and of wedges.
_EDGES = {
    20: ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
    15: ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
}
_FACES: dict[int, tuple[tuple[int, ...], ...]] = {
    20: ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    15: ((0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
}
#: The shape functions of all points in the middle of a cell.
_MIDDLE = {20: [-1 / 4] * 8 + [1 / 4] * 12, 15: [-2 / 9] * 6 + [2 / 9] * 6 + [1 / 3] * 3}


def middles(values: Array, cells: Array) -> Array:
    """What is linear or quadratic in the middles of cells (m, 20 or 15), of values (n, k) at points."""
    with np.errstate(all="ignore"):
        found: Array = np.einsum("p,mpk->mk", _MIDDLE[cells.shape[1]], values[cells])
    return found


def tetrahedra(cells: Array, first: int) -> tuple[Array, Array]:
    """The tetrahedra (t, 4) of cells (m, 20 or 15), whose middles are points from `first` on; and of which cell each
    is (t,)."""
    count, kind = len(cells), cells.shape[1]
    corners = kind - len(_EDGES[kind])
    between = {frozenset(edge): corners + i for i, edge in enumerate(_EDGES[kind])}
    middle = first + np.arange(count)[:, None]
    made: list[Array] = []
    for face in _FACES[kind]:
        around = [between[frozenset((a, b))] for a, b in zip(face, (*face[1:], face[0]), strict=True)]
        triangles = [cells[:, [face[i], around[i], around[i - 1]]] for i in range(len(face))]
        inner = cells[:, around]
        triangles += [inner] if len(face) == 3 else halves(inner)
        made += [np.concatenate([middle, triangle], axis=1) for triangle in triangles]
    return np.concatenate(made), np.tile(np.arange(count), len(made))


def halves(quadrangles: Array) -> list[Array]:
    """The two triangles of each, cut from the corner with the smallest number."""
    turned = (np.argmin(quadrangles, axis=1)[:, None] + np.arange(4)) % 4
    round_ = np.take_along_axis(quadrangles, turned, axis=1)
    return [round_[:, [0, 1, 2]], round_[:, [0, 2, 3]]]
