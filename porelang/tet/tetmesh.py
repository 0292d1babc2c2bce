"""A mesh of tetrahedra, and what follows from which tetrahedra share a face: its boundary, interfaces and pieces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]
Flags = NDArray[np.bool_]

#: The corners of the face opposite each corner, so that they turn outward.
FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]], np.int32)
ALONE, CROWDED = -1, -2  # a face that no other tetrahedron has, and one that more than two have


@dataclass(frozen=True, slots=True)
class TetMesh:
    """Tetrahedra in mm: `vertices` (n, 3) float64, `tets` (m, 4) int32, each of positive volume: the determinant of
    the edges from its first corner to the others, in their order, is above 0. `phase` (m,) int8 is an index into the
    names `phases`: of one phase "solid"; of two also "void", or "void 1", "void 2", ... for networks that do not meet.

    >>> corner = TetMesh(np.vstack([np.zeros(3), np.eye(3)]), np.array([[0, 1, 2, 3]], np.int32), np.zeros(1, np.int8))
    >>> volumes(corner).tolist()
    [0.16666666666666666]
    """

    vertices: Floats
    tets: Indices
    phase: NDArray[np.int8]
    phases: tuple[str, ...] = ("solid",)


def volumes(mesh: TetMesh) -> Floats:
    """The volumes (m,) of a mesh's tetrahedra in mm3."""
    return volumes_of(mesh.vertices, mesh.tets)


def neighbours(mesh: TetMesh) -> Indices:
    """The tetrahedra (m, 4) beyond the faces opposite the corners of each: `ALONE` where there is none, `CROWDED` where
    a face belongs to more than two, which no conforming mesh has."""
    return _neighbours(mesh.tets, len(mesh.vertices))


def boundary(mesh: TetMesh, beside: Indices | None = None) -> tuple[Indices, Indices]:
    """The triangles (k, 3) that bound a mesh, outward, and the tetrahedron (k,) that each belongs to.

    `beside` are its `neighbours`, where they are known. Faces between two phases are no part of it (`interfaces`).
    """
    beside = neighbours(mesh) if beside is None else beside
    owner, side = np.nonzero(beside == ALONE)
    return np.take_along_axis(mesh.tets[owner], FACES[side], axis=1), owner.astype(np.int32)


def interfaces(mesh: TetMesh, beside: Indices | None = None) -> tuple[Indices, Indices]:
    """The triangles (k, 3) between phases, and the two tetrahedra (k, 2) that share each: outward from the first, whose
    phase has the lower index."""
    beside = neighbours(mesh) if beside is None else beside
    shared = beside >= 0
    shared &= mesh.phase[:, None] < mesh.phase[np.maximum(beside, 0)]
    owner, side = np.nonzero(shared)
    triangles = np.take_along_axis(mesh.tets[owner], FACES[side], axis=1)
    return triangles, np.stack([owner.astype(np.int32), beside[owner, side]], axis=1)


def dihedral_angles(mesh: TetMesh) -> Floats:
    """The angles (m, 6) in degrees between faces, at the edges 01, 02, 03, 12, 13, 23 of each tetrahedron."""
    return _dihedral_angles(mesh.vertices, mesh.tets)


def components(mesh: TetMesh, beside: Indices | None = None) -> Indices:
    """The number (m,) of the piece that each tetrahedron belongs to: pieces are of one phase and hang together by
    faces; the largest by volume is 0, then the others in order."""
    beside = neighbours(mesh) if beside is None else beside
    raw, count = _components(beside, mesh.phase)
    size = np.bincount(raw, volumes(mesh), count)
    rank = np.empty(count, np.int32)
    rank[np.argsort(-size, kind="stable")] = np.arange(count, dtype=np.int32)
    return rank[raw]


def taken(mesh: TetMesh, some: Flags) -> TetMesh:
    """A mesh of some (m,) of the tetrahedra, without the vertices that none of them has."""
    tets = mesh.tets[some]
    used = np.zeros(len(mesh.vertices), np.bool_)
    used[tets] = True
    number = np.cumsum(used, dtype=np.int32) - np.int32(1)
    return TetMesh(mesh.vertices[used], number[tets], mesh.phase[some], mesh.phases)


@compiled
def volumes_of(at: Floats, tets: Indices) -> Floats:
    """The volumes (m,) of tetrahedra of vertices `at`."""
    found = np.empty(len(tets))
    for t in range(len(tets)):
        o, a, b, c = tets[t, 0], tets[t, 1], tets[t, 2], tets[t, 3]
        ax, ay, az = at[a, 0] - at[o, 0], at[a, 1] - at[o, 1], at[a, 2] - at[o, 2]
        bx, by, bz = at[b, 0] - at[o, 0], at[b, 1] - at[o, 1], at[b, 2] - at[o, 2]
        cx, cy, cz = at[c, 0] - at[o, 0], at[c, 1] - at[o, 1], at[c, 2] - at[o, 2]
        det = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
        found[t] = det / 6
    return found


@compiled
def _neighbours(tets: Indices, count: int) -> Indices:
    """Faces are sorted by counting into drawers, one for each vertex that is the least of a face; a drawer holds some
    twenty, so that comparing them one by one is faster than to sort all."""
    start = np.zeros(count + 1, np.int64)
    for t in range(len(tets)):
        for k in range(4):
            a, b, c = tets[t, k - 3], tets[t, k - 2], tets[t, k - 1]
            start[min(a, b, c) + 1] += 1
    for v in range(count):
        start[v + 1] += start[v]
    put = start[:-1].copy()
    key = np.empty(4 * len(tets), np.int64)
    face = np.empty(4 * len(tets), np.int64)
    for t in range(len(tets)):
        for k in range(4):
            a, b, c = np.int64(tets[t, k - 3]), np.int64(tets[t, k - 2]), np.int64(tets[t, k - 1])
            least, most = min(a, b, c), max(a, b, c)
            i = put[least]
            put[least] += 1
            key[i] = ((a + b + c - least - most) << 32) | most
            face[i] = 4 * t + k
    beside = np.full((len(tets), 4), np.int32(-1), np.int32)
    for v in range(count):
        for i in range(start[v], start[v + 1]):
            for j in range(i + 1, start[v + 1]):
                if key[i] == key[j]:
                    one, other = face[i], face[j]
                    s, k, t, n = one >> 2, one & 3, other >> 2, other & 3
                    free = beside[s, k] == -1 and beside[t, n] == -1
                    beside[s, k] = t if free else -2
                    beside[t, n] = s if free else -2
    return beside


@compiled
def _components(beside: Indices, phase: NDArray[np.int8]) -> tuple[Indices, int]:
    piece = np.full(len(beside), np.int32(-1), np.int32)
    waiting = np.empty(len(beside), np.int32)
    count = 0
    for first in range(len(beside)):
        if piece[first] >= 0:
            continue
        piece[first] = count
        waiting[0] = first
        many = 1
        while many > 0:
            many -= 1
            t = waiting[many]
            for k in range(4):
                n = beside[t, k]
                if n >= 0 and piece[n] < 0 and phase[n] == phase[t]:
                    piece[n] = count
                    waiting[many] = n
                    many += 1
        count += 1
    return piece, count


@compiled
def _dihedral_angles(at: Floats, tets: Indices) -> Floats:
    found = np.empty((len(tets), 6))
    normal = np.empty((4, 3))
    for t in range(len(tets)):
        for k in range(4):  # the normals of the faces opposite each corner, all outward or all inward
            a, b, c = tets[t, (k + 1) % 4], tets[t, (k + 2) % 4], tets[t, (k + 3) % 4]
            ux, uy, uz = at[b, 0] - at[a, 0], at[b, 1] - at[a, 1], at[b, 2] - at[a, 2]
            vx, vy, vz = at[c, 0] - at[a, 0], at[c, 1] - at[a, 1], at[c, 2] - at[a, 2]
            sign = 1.0 if k % 2 == 0 else -1.0
            normal[k, 0] = sign * (uy * vz - uz * vy)
            normal[k, 1] = sign * (uz * vx - ux * vz)
            normal[k, 2] = sign * (ux * vy - uy * vx)
        e = 0
        for i in range(4):
            for j in range(i + 1, 4):  # at the edge ij meet the faces opposite the two others
                p, q = 0, 0
                for k in range(4):
                    if k != i and k != j:
                        p, q = q, k
                dot = normal[p, 0] * normal[q, 0] + normal[p, 1] * normal[q, 1] + normal[p, 2] * normal[q, 2]
                cx = normal[p, 1] * normal[q, 2] - normal[p, 2] * normal[q, 1]
                cy = normal[p, 2] * normal[q, 0] - normal[p, 0] * normal[q, 2]
                cz = normal[p, 0] * normal[q, 1] - normal[p, 1] * normal[q, 0]
                found[t, e] = np.degrees(np.pi - np.arctan2(np.sqrt(cx * cx + cy * cy + cz * cz), dot))
                e += 1
    return found
