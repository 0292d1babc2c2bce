"""How the triangles of a surface are joined: its edges, the fans round its vertices, its components; compiled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled

Ints = NDArray[np.int64]
Faces = NDArray[np.int32]


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
def components(faces: Faces, count: int) -> int:
    """The number of sets of triangles that share no vertex, of those that `count` vertices are joined to."""
    root = np.arange(count)
    used = np.zeros(count, np.bool_)
    sets = 0
    for t in range(len(faces)):
        a = np.int64(faces[t, 0])
        for k in range(3):
            v = np.int64(faces[t, k])
            if not used[v]:
                used[v] = True
                sets += 1
            while root[v] != v:  # the path is halved on the way
                root[v] = root[root[v]]
                v = root[v]
            while root[a] != a:
                root[a] = root[root[a]]
                a = root[a]
            if a != v:
                sets -= 1
                if a < v:
                    root[v] = a
                else:
                    root[a] = v
    return sets
