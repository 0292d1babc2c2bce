"""Where a mesh runs through itself: triangles that cross others, by a grid of the triangles in each cell.

Two triangles cross where an edge of one passes the other from one side to the other, strictly: what only touches does
not count, nor do two that share an edge. A triangle that is told to cross another does.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.mesh.surface import Surface
from porelang.mesh.within import cells_of
from porelang.parallel import parallel_for, workers

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ints = NDArray[np.int64]
PIECES = 1 << 14  # triangles at a time
_SURE = 1e-13  # of the size of what is added up: more than its rounding


def crossed(surface: Surface, some: Ints | None = None, threads: int | None = None) -> Flags:
    """Which triangles of a surface cross another one, (m,); or which of `some` and those that they cross."""
    found = np.zeros(len(surface.faces), np.bool_)
    rows = np.arange(len(found)) if some is None else some
    if not len(rows):
        return found
    size = max(float(np.sqrt(2 * surface.area / len(found))), 1e-9 * float(np.abs(surface.vertices).max()))
    cells = cells_of(surface, size, surface.vertices.min(axis=0), surface.vertices.max(axis=0))
    faces, corners = np.ascontiguousarray(surface.faces), cells.corners
    least, most = corners.min(axis=1), corners.max(axis=1)

    def work(first: int) -> None:
        _look(
            rows[first : first + PIECES], some is None, faces, corners, least, most, cells.low, cells.size, cells.shape,
            cells.start, cells.member, found,
        )  # fmt: skip

    parallel_for(work, range(0, len(rows), PIECES), workers(threads))
    return found


@compiled
def _look(
    rows: Ints,
    later: bool,
    faces: NDArray[np.int32],
    corners: Floats,
    least: Floats,
    most: Floats,
    low: Floats,
    size: float,
    shape: Ints,
    start: Ints,
    member: Any,
    found: Flags,
) -> None:
    """Look at the triangles `rows`; if `later` only at pairs with those that come after each, for all are looked at."""
    begin, end = np.empty(3, np.int64), np.empty(3, np.int64)
    for t in rows:
        for n in range(3):
            begin[n] = min(max(int((least[t, n] - low[n]) / size), 0), shape[n] - 1)
            end[n] = min(max(int((most[t, n] - low[n]) / size), 0), shape[n] - 1) + 1
        x0, y0, z0, x1, y1, z1 = least[t, 0], least[t, 1], least[t, 2], most[t, 0], most[t, 1], most[t, 2]
        for i in range(begin[0], end[0]):
            for j in range(begin[1], end[1]):
                for k in range(begin[2], end[2]):
                    cell = (i * shape[1] + j) * shape[2] + k
                    for m in range(start[cell], start[cell + 1]):
                        u = member[m]
                        if u == t or (later and u < t) or (found[t] and found[u]):
                            continue
                        if least[u, 0] > x1 or least[u, 1] > y1 or least[u, 2] > z1:
                            continue
                        if most[u, 0] < x0 or most[u, 1] < y0 or most[u, 2] < z0:
                            continue
                        if _cross(faces, corners, t, u):
                            found[t] = True
                            found[u] = True


@compiled
def _cross(faces: NDArray[np.int32], corners: Floats, t: int, u: int) -> bool:
    """Whether two triangles cross."""
    shared, mine, yours = 0, 0, 0
    for a in range(3):
        for b in range(3):
            if faces[t, a] == faces[u, b]:
                shared, mine, yours = shared + 1, a, b
    if shared > 1:
        return False
    if shared == 1:  # only the sides across from the common corner can
        a, b = (mine + 1) % 3, (mine + 2) % 3
        c, d = (yours + 1) % 3, (yours + 2) % 3
        return _pierces(corners, t, a, b, u) or _pierces(corners, u, c, d, t)
    beyond = 0
    for a in range(3):
        beyond += _side(corners, t, 0, t, 1, t, 2, u, a)
    if beyond in (-3, 3):
        return False
    for a in range(3):
        b = (a + 1) % 3
        if _pierces(corners, t, a, b, u) or _pierces(corners, u, a, b, t):
            return True
    return False


@compiled
def _pierces(corners: Floats, t: int, a: int, b: int, u: int) -> bool:
    """Whether the side from corner `a` to `b` of triangle `t` passes through the inside of triangle `u`."""
    above, below = _side(corners, u, 0, u, 1, u, 2, t, a), _side(corners, u, 0, u, 1, u, 2, t, b)
    if above * below >= 0:
        return False
    one = _side(corners, t, a, t, b, u, 0, u, 1)
    return one != 0 and one == _side(corners, t, a, t, b, u, 1, u, 2) == _side(corners, t, a, t, b, u, 2, u, 0)


@compiled
def _side(corners: Floats, ta: int, a: int, tb: int, b: int, tc: int, c: int, td: int, d: int) -> int:
    """On which side of the plane through three corners a fourth lies: 1, -1, or 0 where rounding may decide."""
    x, y, z = corners[td, d, 0], corners[td, d, 1], corners[td, d, 2]
    ux, uy, uz = corners[ta, a, 0] - x, corners[ta, a, 1] - y, corners[ta, a, 2] - z
    vx, vy, vz = corners[tb, b, 0] - x, corners[tb, b, 1] - y, corners[tb, b, 2] - z
    wx, wy, wz = corners[tc, c, 0] - x, corners[tc, c, 1] - y, corners[tc, c, 2] - z
    total = ux * (vy * wz - vz * wy) + uy * (vz * wx - vx * wz) + uz * (vx * wy - vy * wx)
    sizes = (
        abs(ux) * (abs(vy * wz) + abs(vz * wy)) + abs(uy) * (abs(vz * wx) + abs(vx * wz))
        + abs(uz) * (abs(vx * wy) + abs(vy * wx))
    )  # fmt: skip
    if abs(total) <= _SURE * sizes:
        return 0
    return 1 if total > 0 else -1
