"""How the triangles of a surface are joined: its edges, the fans round its vertices, its components; compiled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled

Ints = NDArray[np.int64]
Faces = NDArray[np.int32]
Floats = NDArray[np.float64]


@compiled
def joints(faces: Faces, count: int) -> tuple[int, int, int]:
    """What is wrong with how triangles (m, 3) join `count` vertices, and the number of fans round vertices.

    Gives the edges that two triangles run through in the same direction, the edges that no triangle runs back through,
    and, where there are none of either, the closed fans of triangles: one for each vertex of a manifold.
    """
    # The triangles round each vertex, by the two other corners in their order.
    first = np.zeros(count + 1, np.int64)
    for t in range(len(faces)):
        for k in range(3):
            first[faces[t, k] + 1] += 1
    for v in range(count):
        first[v + 1] += first[v]
    free = first[:-1].copy()
    after = np.empty(3 * len(faces), np.int32)
    before = np.empty(3 * len(faces), np.int32)
    for t in range(len(faces)):
        for k in range(3):
            v = faces[t, k]
            after[free[v]] = faces[t, (k + 1) % 3]
            before[free[v]] = faces[t, (k + 2) % 3]
            free[v] += 1
    repeated, unmatched, fans = 0, 0, 0
    for v in range(count):
        lo, hi = first[v], first[v + 1]
        for i in range(lo, hi):
            for j in range(lo, i):
                if after[j] == after[i]:
                    repeated += 1
                    break
            back = False  # whether some triangle runs from after[i] back to v: then v follows it there
            for j in range(lo, hi):
                back |= before[j] == after[i]
            unmatched += not back
    if repeated or unmatched:
        return repeated, unmatched, 0
    for v in range(count):
        lo, hi = first[v], first[v + 1]
        left = hi - lo
        while left > 0:
            start = lo
            while after[start] < 0:
                start += 1
            fans += 1
            at = start
            while after[at] >= 0:  # to the triangle that begins where this one ends
                after[at] = -1
                left -= 1
                for j in range(lo, hi):
                    if after[j] == before[at]:
                        at = j
                        break
    return 0, 0, fans


@compiled
def components(faces: Faces, count: int) -> tuple[Faces, int]:
    """The number of the component of each of `count` vertices (-1: of none), and how many components there are.

    A component is a set of triangles that share no vertex with others.
    """
    root = np.arange(count).astype(np.int32)
    used = np.zeros(count, np.bool_)
    for t in range(len(faces)):
        a = faces[t, 0]
        for k in range(3):
            v = faces[t, k]
            used[v] = True
            while root[v] != v:  # the path is halved on the way
                root[v] = root[root[v]]
                v = root[v]
            while root[a] != a:
                root[a] = root[root[a]]
                a = root[a]
            if a < v:
                root[v] = a
            else:
                root[a] = v
                a = v
    sets = 0
    for v in range(count):  # a root comes before what it is the root of
        if not used[v]:
            root[v] = -1
        elif root[v] == v:
            root[v] = sets
            sets += 1
        else:
            root[v] = root[root[v]]
    return root, sets


@compiled
def sums(vertices: Floats, faces: Faces, label: Faces, count: int) -> tuple[Floats, Floats, Floats, Ints]:
    """Of each of `count` components: the volume that it encloses (negative: a void), the corners of its box, and the
    number of its triangles."""
    volume = np.zeros(count)
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    first = np.zeros((count, 3))
    many = np.zeros(count, np.int64)
    for v in range(len(vertices)):
        c = label[v]
        if c < 0:
            continue
        if low[c, 0] == np.inf:
            for n in range(3):
                first[c, n] = vertices[v, n]
        for n in range(3):
            low[c, n] = min(low[c, n], vertices[v, n])
            high[c, n] = max(high[c, n], vertices[v, n])
    for t in range(len(faces)):
        a, b, d = faces[t, 0], faces[t, 1], faces[t, 2]
        c = label[a]
        many[c] += 1
        ax, ay, az = vertices[a, 0] - first[c, 0], vertices[a, 1] - first[c, 1], vertices[a, 2] - first[c, 2]
        bx, by, bz = vertices[b, 0] - first[c, 0], vertices[b, 1] - first[c, 1], vertices[b, 2] - first[c, 2]
        dx, dy, dz = vertices[d, 0] - first[c, 0], vertices[d, 1] - first[c, 1], vertices[d, 2] - first[c, 2]
        volume[c] += (ax * (by * dz - bz * dy) + ay * (bz * dx - bx * dz) + az * (bx * dy - by * dx)) / 6
    return volume, low, high, many
