"""The nodes of a mesh: its vertices, for order 2 also the middles of its edges, and the triangles of its boundary.

Corners, then edges in the order of VTK's quadratic tetrahedron (VTK File Formats, 2003): 01, 12, 02, 03, 13, 23.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.fea.problem import Floats, Ints

EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])
#: The corners of each face of a tetrahedron of positive volume, outward; and the edges 01, 12, 02 of each.
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
_FACE_EDGES = np.array([[2, 1, 0], [0, 4, 3], [1, 5, 4], [3, 5, 2]])


@dataclass(frozen=True, slots=True)
class Nodes:
    """`points` (k, 3) mm, the mesh's vertices first; `elements` (m, 4 or 10) and `faces` (f, 3 or 6), of the boundary
    and
    outward, are numbers of nodes, `owner` (f,) the tetrahedron of each face;
    `pairs` (p, 2) are tetrahedra that share a face. `gradients` (m, 4, 3) 1/mm are those of the
    barycentric coordinates, `volumes` (m,) mm3. `edges` (k - n, 2) are the ends of the nodes between vertices.
    """

    points: Floats
    elements: Ints
    faces: Ints
    owner: Ints
    pairs: Ints
    gradients: Floats
    volumes: Floats
    edges: Ints
    vertices: int

    @property
    def order(self) -> int:
        return 1 if self.elements.shape[1] == 4 else 2

    @property
    def corners(self) -> Ints:
        """The four vertices (m, 4) of each tetrahedron."""
        return self.elements[:, :4]


def number(vertices: Floats, tets: Ints, order: int) -> Nodes:
    """The nodes of a mesh for elements of order 1 or 2."""
    vertices = np.ascontiguousarray(vertices, np.float64)
    tets = np.ascontiguousarray(tets, np.int32)
    n = len(vertices)
    ends = np.sort(tets[:, EDGES], axis=2).astype(np.int64)
    keys, place = np.unique(ends[..., 0] * n + ends[..., 1], return_inverse=True)
    place = place.reshape(ends.shape[:2])
    edges = np.stack([keys // n, keys % n], 1).astype(np.int32)
    face, owner, pairs = _matched(tets, place, n)
    faces = tets[owner[:, None], FACES[face]]
    points, elements = vertices, tets
    if order == 2:
        points = np.concatenate([vertices, vertices[edges].mean(axis=1)])
        numbers = (place + n).astype(np.int32)
        elements = np.concatenate([tets, numbers], axis=1)
        faces = np.concatenate([faces, numbers[owner[:, None], _FACE_EDGES[face]]], axis=1)
    gradients, volumes = shapes(vertices, tets)
    return Nodes(points, elements, faces, owner, pairs, gradients, volumes, edges, n)


def _matched(tets: Ints, place: NDArray[np.int64], n: int) -> tuple[NDArray[np.int64], Ints, Ints]:
    """Which face (f,) of which tetrahedron (f,) has no other beside it, and the pairs (p, 2) that share one."""
    low = np.sort(tets[:, FACES], axis=2).astype(np.int64)
    # an edge's number and the third vertex are one number, whatever the count of vertices
    first = np.take_along_axis(place, _least_edges(tets), axis=1)
    keys = (first * n + low[..., 2]).ravel()
    order = np.argsort(keys, kind="stable")
    found = keys[order]
    same = found[1:] == found[:-1]
    alone = np.ones(len(keys), bool)
    alone[1:][same] = False
    alone[:-1][same] = False
    where = np.sort(order[alone])
    twins = np.flatnonzero(same)
    pairs = np.stack([order[twins], order[twins + 1]], axis=1) // 4
    return where % 4, (where // 4).astype(np.int32), pairs.astype(np.int32)


def _least_edges(tets: Ints) -> NDArray[np.int64]:
    """For each face (m, 4), which of the six edges joins its two lowest vertices."""
    out = np.empty((len(tets), 4), np.int64)
    for f in range(4):
        opposite = np.argmax(tets[:, FACES[f]], axis=1)  # the edge of the face that does not touch its highest vertex
        out[:, f] = np.array([_FACE_EDGES[f][1], _FACE_EDGES[f][2], _FACE_EDGES[f][0]])[opposite]
    return out


@compiled
def shapes(vertices: Floats, tets: Ints) -> tuple[Floats, Floats]:
    """The gradients (m, 4, 3) of the barycentric coordinates and the volumes (m,) of tetrahedra."""
    gradients = np.empty((len(tets), 4, 3))
    volumes = np.empty(len(tets))
    for e in range(len(tets)):
        a, b, c = np.empty(3), np.empty(3), np.empty(3)
        for i in range(3):
            base = vertices[tets[e, 0], i]
            a[i] = vertices[tets[e, 1], i] - base
            b[i] = vertices[tets[e, 2], i] - base
            c[i] = vertices[tets[e, 3], i] - base
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            gradients[e, 1, i] = b[j] * c[k] - b[k] * c[j]
            gradients[e, 2, i] = c[j] * a[k] - c[k] * a[j]
            gradients[e, 3, i] = a[j] * b[k] - a[k] * b[j]
        six = 0.0
        for i in range(3):
            six += a[i] * gradients[e, 1, i]
        volumes[e] = six / 6
        for i in range(3):
            for j in range(1, 4):
                gradients[e, j, i] /= six
            gradients[e, 0, i] = -gradients[e, 1, i] - gradients[e, 2, i] - gradients[e, 3, i]
    return gradients, volumes
