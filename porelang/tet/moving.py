"""Vertices that move, one by one, as far as the tetrahedra round them stay good: compiled loops.

They are in one module, as what a compiled function calls is compiled into it: it would not see that another changed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Indices = NDArray[np.int32]
Flags = NDArray[np.bool_]

FLAT = 1e-6  # of the product of three edges: a smaller volume is none
OBTUSE = 0.5  # of how far its cosine is above -1 an obtuse angle counts: 164.7 degrees is as bad as 10.8, 168.4 as 8.2
STEPS = 3  # lengths that are tried of each way, each half of the one before


class Stars(NamedTuple):
    """The tetrahedra of each vertex: those of v are `of[start[v] : start[v + 1]]`."""

    start: Ints
    of: Indices


def stars(tets: Indices, count: int) -> Stars:
    """Which tetrahedra (m, 4) each of so many vertices has."""
    return Stars(*_stars(tets, count))


@compiled
def _stars(tets: Indices, count: int) -> tuple[Ints, Indices]:
    start = np.zeros(count + 1, np.int64)
    for t in range(len(tets)):
        for k in range(4):
            start[tets[t, k] + 1] += 1
    for v in range(count):
        start[v + 1] += start[v]
    put = start[:-1].copy()
    of = np.empty(4 * len(tets), np.int32)
    for t in range(len(tets)):
        for k in range(4):
            v = tets[t, k]
            of[put[v]] = t
            put[v] += 1
    return start, of


@compiled
def sharpest(at: Floats, tet: Indices) -> float:
    """The cosine of the smallest dihedral angle of a tetrahedron, or of one that is as bad as its largest; 2 where it
    has no volume above 0."""
    a, b, c, d = tet[0], tet[1], tet[2], tet[3]
    ux, uy, uz = at[b, 0] - at[a, 0], at[b, 1] - at[a, 1], at[b, 2] - at[a, 2]
    vx, vy, vz = at[c, 0] - at[a, 0], at[c, 1] - at[a, 1], at[c, 2] - at[a, 2]
    wx, wy, wz = at[d, 0] - at[a, 0], at[d, 1] - at[a, 1], at[d, 2] - at[a, 2]
    # normals of the faces opposite d, c and b, all of them inward
    dx, dy, dz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    size = (ux * ux + uy * uy + uz * uz) * (vx * vx + vy * vy + vz * vz) * (wx * wx + wy * wy + wz * wz)
    if not dx * wx + dy * wy + dz * wz > FLAT * np.sqrt(size):
        return 2.0
    cx, cy, cz = wy * uz - wz * uy, wz * ux - wx * uz, wx * uy - wy * ux
    bx, by, bz = vy * wz - vz * wy, vz * wx - vx * wz, vx * wy - vy * wx
    ax, ay, az = -(bx + cx + dx), -(by + cy + dy), -(bz + cz + dz)
    a2 = ax * ax + ay * ay + az * az
    b2 = bx * bx + by * by + bz * bz
    c2 = cx * cx + cy * cy + cz * cz
    d2 = dx * dx + dy * dy + dz * dz
    ab = -(ax * bx + ay * by + az * bz) / np.sqrt(a2 * b2)
    ac = -(ax * cx + ay * cy + az * cz) / np.sqrt(a2 * c2)
    ad = -(ax * dx + ay * dy + az * dz) / np.sqrt(a2 * d2)
    bc = -(bx * cx + by * cy + bz * cz) / np.sqrt(b2 * c2)
    bd = -(bx * dx + by * dy + bz * dz) / np.sqrt(b2 * d2)
    cd = -(cx * dx + cy * dy + cz * dz) / np.sqrt(c2 * d2)
    return float(max(ab, ac, ad, bc, bd, cd, 1 - OBTUSE * (1 + min(ab, ac, ad, bc, bd, cd))))


@compiled
def poor(at: Floats, tets: Indices, least: float) -> Flags:
    """Which tetrahedra have an angle below that with the cosine `least`, or one as bad."""
    found = np.zeros(len(tets), np.bool_)
    for t in range(len(tets)):
        found[t] = sharpest(at, tets[t]) > least
    return found


@compiled
def worst(at: Floats, tets: Indices, start: Ints, of: Indices, v: int) -> float:
    """The largest `sharpest` of the tetrahedra round a vertex."""
    most = -1.0
    for i in range(start[v], start[v + 1]):
        most = max(most, sharpest(at, tets[of[i]]))
    return most


@compiled
def relax(at: Floats, tets: Indices, start: Ints, of: Indices, v: int, ways: Floats, length: float) -> bool:
    """Move a vertex along one of some ways (n, 3), by a length or a part of it, where its worst angle grows most."""
    before = worst(at, tets, start, of, v)
    best, x, y, z = before, at[v, 0], at[v, 1], at[v, 2]
    bx, by, bz = x, y, z
    for step in range(STEPS):
        for w in range(len(ways)):
            at[v, 0] = x + ways[w, 0] * length / 2**step
            at[v, 1] = y + ways[w, 1] * length / 2**step
            at[v, 2] = z + ways[w, 2] * length / 2**step
            now = worst(at, tets, start, of, v)
            if now < best:
                best, bx, by, bz = now, at[v, 0], at[v, 1], at[v, 2]
    at[v, 0], at[v, 1], at[v, 2] = bx, by, bz
    return best < before


@compiled
def moved(
    at: Floats, tets: Indices, start: Ints, of: Indices, inner: Flags, v: int, to: Floats, least: float,
    ways: Floats, length: Floats, rounds: int, went: Flags,
) -> bool:  # fmt: skip
    """Move a vertex to a place, if all angles round it stay above that with the cosine `least`, or no worse than they
    were; inner vertices of tetrahedra that do not are moved to make room. Else all stays as it was. Which vertices
    `went` somewhere is noted."""
    allowed = max(least, worst(at, tets, start, of, v))
    x, y, z = at[v, 0], at[v, 1], at[v, 2]
    at[v] = to
    if worst(at, tets, start, of, v) <= allowed:
        went[v] = True
        return True
    touched = np.empty(64, np.int32)
    old = np.empty((64, 3))
    many = 0
    for _ in range(rounds):
        better = False
        for i in range(start[v], start[v + 1]):
            t = of[i]
            if sharpest(at, tets[t]) <= allowed:
                continue
            for k in range(4):
                n = tets[t, k]
                if n == v or not inner[n]:
                    continue
                known = False
                for j in range(many):
                    known |= touched[j] == n
                if not known:
                    if many == 64:
                        continue
                    touched[many] = n
                    old[many] = at[n]
                    many += 1
                better |= relax(at, tets, start, of, n, ways, length[n])
        most = worst(at, tets, start, of, v)
        for j in range(many):
            most = max(most, worst(at, tets, start, of, touched[j]))
        if most <= allowed:
            went[v] = True
            for j in range(many):
                went[touched[j]] = True
            return True
        if not better:
            break
    for j in range(many):
        at[touched[j]] = old[j]
    at[v, 0], at[v, 1], at[v, 2] = x, y, z
    return False


@compiled
def improve(
    at: Floats, tets: Indices, start: Ints, of: Indices, inner: Flags, least: float, ways: Floats, length: Floats,
    rounds: int,
) -> int:  # fmt: skip
    """Move inner vertices of tetrahedra that have an angle below that with the cosine `least`, where the worst of those
    round them grow by it; again only beside what has moved. How many moves there were."""
    count = 0
    go, then = np.ones(len(at), np.bool_), np.zeros(len(at), np.bool_)
    for _ in range(rounds):
        better = 0
        for t in range(len(tets)):
            if not (go[tets[t, 0]] or go[tets[t, 1]] or go[tets[t, 2]] or go[tets[t, 3]]):
                continue
            if sharpest(at, tets[t]) > least:
                for k in range(4):
                    v = tets[t, k]
                    if inner[v] and go[v] and relax(at, tets, start, of, v, ways, length[v]):
                        better += 1
                        for i in range(start[v], start[v + 1]):
                            for n in tets[of[i]]:
                                then[n] = True
        count += better
        if not better:
            break
        go[:] = then
        then[:] = False
    return count


@compiled
def onto_branches(
    at: Floats, tets: Indices, start: Ints, of: Indices, inner: Flags, on: Ints, mixed: Indices, first: Ints,
    beside: Ints, vertex: Ints, branch: Ints, to: Floats, least: float, ways: Floats, length: Floats, again: Flags,
    went: Flags,
) -> int:  # fmt: skip
    """Move vertices onto a further branch, in order, where a triangle still needs it; a vertex once. How many were.

    Tried are those beside vertices that may have gone somewhere (`again`); which `went` this time is noted."""
    done = np.zeros(len(at), np.bool_)
    count = 0
    for i in range(len(vertex)):
        v = vertex[i]
        if done[v] or not _beside(tets, start, of, again, v):
            continue
        needed = False
        for j in range(first[v], first[v + 1]):
            triangle = mixed[beside[j]]
            wants = False
            for c in range(3):
                for k in range(3):
                    wants |= triangle[c] != v and on[triangle[c], k] == branch[i]
            needed |= wants and not _one(on, triangle)
        if needed and moved(at, tets, start, of, inner, v, to[i], least, ways, length, 3, went):
            done[v] = True
            for k in range(3):
                if on[v, k] < 0:
                    on[v, k] = branch[i]
                    break
            count += 1
    return count


@compiled
def _beside(tets: Indices, start: Ints, of: Indices, some: Flags, v: int) -> bool:
    """Whether a vertex or one next to it is among some."""
    for i in range(start[v], start[v + 1]):
        for n in tets[of[i]]:
            if some[n]:
                return True
    return False


@compiled
def _one(on: Ints, triangle: Indices) -> bool:
    """Whether the corners of a triangle have a branch in common."""
    for k in range(3):
        mine = on[triangle[0], k]
        both = 0
        for c in range(1, 3):
            for m in range(3):
                both += mine >= 0 and on[triangle[c], m] == mine
        if both == 2:
            return True
    return False


@compiled
def shifted(at: Floats, tets: Indices, start: Ints, of: Indices, some: Ints, to: Floats, least: float) -> float:
    """Move vertices to places, as far, to a quarter, as angles allow; the largest distance that one went."""
    none, went = np.zeros(len(at), np.bool_), np.zeros(len(at), np.bool_)
    ways, length = np.zeros((0, 3)), np.zeros(0)
    most = 0.0
    for i in range(len(some)):
        v = some[i]
        x, y, z = at[v, 0], at[v, 1], at[v, 2]
        target = to[i].copy()
        for _ in range(3):
            if moved(at, tets, start, of, none, v, target, least, ways, length, 0, went):
                most = max(most, np.sqrt((at[v, 0] - x) ** 2 + (at[v, 1] - y) ** 2 + (at[v, 2] - z) ** 2))
                break
            target[0], target[1], target[2] = (x + target[0]) / 2, (y + target[1]) / 2, (z + target[2]) / 2
    return most
