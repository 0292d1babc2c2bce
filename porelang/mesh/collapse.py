"""Edges of a mesh collapsed one by one, within an estimate of what that moves the surface.

An edge becomes a vertex where the planes of the triangles round it are met best (Garland & Heckbert 1997, "Surface
simplification using quadric error metrics"). What a collapse moves is how far the new vertex is from the planes that it
replaces, or the old two are from the new triangles; it is added to what moved the triangles there before, as in Cohen,
Manocha & Olano 1997, "Simplifying polygonal models using successive mappings". The sum is on the safe side nearly
always; `porelang.mesh.within` proves it afterwards. The mesh stays a manifold by the link condition.

Passes go from short edges to long ones and from small moves to large ones, and a vertex takes part in one collapse a
pass, so that triangles grow evenly.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.mesh.surface import Surface
from porelang.mesh.within import square
from porelang.progress import tell

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
LEAST_TURN = 0.3  # cosine of the angle that a triangle may turn by in one collapse
STAR = 64  # triangles at most round an edge that may go
SHARES = (1 / 16, 1 / 4, 1 / 2, 1.0)  # of the allowed move, from pass to pass
LONGER = 1.4
PASSES = 16
DONE = 0.002  # of the triangles: a pass that takes out fewer is the last with its share


def collapse(surface: Surface, allowed: Floats) -> Surface:
    """The surface with as many edges collapsed as move nothing by more than is `allowed` (n,) mm at their vertices."""
    at, faces = surface.vertices.copy(), surface.faces.copy()
    first = np.full(len(at), -1, np.int32)
    following = np.empty(3 * len(faces), np.int32)
    quadric = np.zeros((len(at), 10))
    moved = np.zeros(len(faces))  # how far each triangle was moved so far; -1 for those that are gone
    _begin(at, faces, first, following, quadric)
    allowed = allowed.copy()
    mean = math.sqrt(2.3 * surface.area / len(faces))  # the side of a triangle of that size
    stamp = np.zeros(len(at), np.int32)
    turn = 0
    for step, share in enumerate(SHARES):
        dirty = np.ones(len(at), np.bool_)
        longest = mean
        for k in range(PASSES):
            tell(step * PASSES + k, len(SHARES) * PASSES)
            turn += 1
            left = np.zeros(len(at), np.bool_)
            longest = longest * LONGER if k < PASSES - 4 else math.inf
            state = (at, faces, first, following, quadric, moved, allowed, stamp)
            gone = _pass(*state, turn, dirty, left, share, longest)
            dirty = left
            if gone < DONE * (moved >= 0).sum() and longest > 8 * mean:
                break
    kept = faces[moved >= 0]
    used = np.zeros(len(at), np.bool_)
    used[kept] = True
    number = np.cumsum(used, dtype=np.int32) - np.int32(1)
    return Surface(at[used], number[kept])


@compiled
def _begin(at: Floats, faces: Ints, first: Ints, following: Ints, quadric: Floats) -> None:
    """The lists of the corners at each vertex, and its quadric: the sum of area n n^T over its triangles."""
    n = np.empty(4)
    for t in range(len(faces)):
        a, b, c = at[faces[t, 0]], at[faces[t, 1]], at[faces[t, 2]]
        u0, u1, u2 = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        v0, v1, v2 = c[0] - a[0], c[1] - a[1], c[2] - a[2]
        n[0], n[1], n[2] = u1 * v2 - u2 * v1, u2 * v0 - u0 * v2, u0 * v1 - u1 * v0
        size = math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
        if size > 0:
            n[:3] /= size
        n[3] = -(n[0] * a[0] + n[1] * a[1] + n[2] * a[2])
        for k in range(3):
            v = faces[t, k]
            following[3 * t + k] = first[v]
            first[v] = 3 * t + k
            e = 0
            for i in range(4):
                for j in range(i, 4):
                    quadric[v, e] += size * n[i] * n[j]
                    e += 1


@compiled
def _best(q: Floats, a: Floats, b: Floats, p: Floats) -> None:
    """Into `p` where the planes of a quadric are met best, near the middle of a and b where they leave that free."""
    m0, m1, m2 = (a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2
    pull = 1e-3 * (q[0] + q[4] + q[7]) / 3
    xx, xy, xz, yy, yz, zz = q[0] + pull, q[1], q[2], q[4] + pull, q[5], q[7] + pull
    r0 = q[0] * m0 + q[1] * m1 + q[2] * m2 + q[3]
    r1 = q[1] * m0 + q[4] * m1 + q[5] * m2 + q[6]
    r2 = q[2] * m0 + q[5] * m1 + q[7] * m2 + q[8]
    c0, c1, c2 = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    det = xx * c0 + xy * c1 + xz * c2
    p[0], p[1], p[2] = m0, m1, m2
    if not det > 0:
        return
    s0 = (c0 * r0 + c1 * r1 + c2 * r2) / det
    s1 = (c1 * r0 + (xx * zz - xz * xz) * r1 + (xy * xz - xx * yz) * r2) / det
    s2 = (c2 * r0 + (xy * xz - xx * yz) * r1 + (xx * yy - xy * xy) * r2) / det
    far = (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2
    if s0 * s0 + s1 * s1 + s2 * s2 <= far:
        p[0], p[1], p[2] = m0 - s0, m1 - s1, m2 - s2


@compiled
def _star(v: int, faces: Ints, first: Ints, following: Ints, moved: Floats, star: Ints, count: int) -> int:
    """Append the triangles at a vertex to `star`, and take those that are gone out of its list; -1 if too many."""
    before = -1
    c = first[v]
    while c >= 0:
        nxt = following[c]
        if moved[c // 3] < 0:
            if before < 0:
                first[v] = nxt
            else:
                following[before] = nxt
        else:
            if count >= STAR:
                return -1
            star[count] = c // 3
            count += 1
            before = c
        c = nxt
    return count


@compiled
def _ring(v: int, w: int, faces: Ints, star: Ints, begin: int, end: int, ring: Ints) -> int:
    """The neighbours of v but for w, from its triangles; how many."""
    count = 0
    for i in range(begin, end):
        for k in range(3):
            x = faces[star[i], k]
            if x in (v, w):
                continue
            new = True
            for j in range(count):
                if ring[j] == x:
                    new = False
            if new:
                ring[count] = x
                count += 1
    return count


@compiled
def _linked(one: Ints, n: int, other: Ints, m: int, first: Ints, following: Ints, moved: Floats) -> bool:
    """Whether two ends of an edge have two neighbours in common, neither of which would be left with two."""
    common = 0
    for i in range(n):
        for j in range(m):
            if one[i] == other[j]:
                common += 1
                valence = 0
                c = first[one[i]]
                while c >= 0 and valence < 4:
                    if moved[c // 3] >= 0:
                        valence += 1
                    c = following[c]
                if valence < 4:
                    return False
    return common == 2


@compiled
def _move(
    a: int, b: int, p: Floats, at: Floats, faces: Ints, star: Ints, count: int, split: int, most: float, tri: Floats
) -> float:
    """How far the collapse of an edge to `p` moves the surface; infinite if a triangle turns by much or vanishes."""
    far = 0.0
    near_a, near_b = math.inf, math.inf
    for i in range(count):
        t = star[i]
        gone, mine = 0, 0
        for k in range(3):
            x = faces[t, k]
            if x in (a, b):
                gone += 1
                mine = k
        if gone == 2 and i >= split:
            continue  # it came with a already
        o = at[faces[t, 0]]
        u0, u1, u2 = at[faces[t, 1], 0] - o[0], at[faces[t, 1], 1] - o[1], at[faces[t, 1], 2] - o[2]
        v0, v1, v2 = at[faces[t, 2], 0] - o[0], at[faces[t, 2], 1] - o[1], at[faces[t, 2], 2] - o[2]
        n0, n1, n2 = u1 * v2 - u2 * v1, u2 * v0 - u0 * v2, u0 * v1 - u1 * v0
        size = math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
        if size > 0:
            far = max(far, abs(n0 * (p[0] - o[0]) + n1 * (p[1] - o[1]) + n2 * (p[2] - o[2])) / size)
        if far > most:
            return math.inf
        if gone == 2:
            continue
        for k in range(3):
            tri[k] = p if k == mine else at[faces[t, k]]
        u0, u1, u2 = tri[1, 0] - tri[0, 0], tri[1, 1] - tri[0, 1], tri[1, 2] - tri[0, 2]
        v0, v1, v2 = tri[2, 0] - tri[0, 0], tri[2, 1] - tri[0, 1], tri[2, 2] - tri[0, 2]
        m0, m1, m2 = u1 * v2 - u2 * v1, u2 * v0 - u0 * v2, u0 * v1 - u1 * v0
        now = math.sqrt(m0 * m0 + m1 * m1 + m2 * m2)
        w0, w1, w2 = v0 - u0, v1 - u1, v2 - u2
        longest = max(u0 * u0 + u1 * u1 + u2 * u2, v0 * v0 + v1 * v1 + v2 * v2, w0 * w0 + w1 * w1 + w2 * w2)
        if n0 * m0 + n1 * m1 + n2 * m2 <= LEAST_TURN * size * now or now <= 1e-3 * longest:
            return math.inf
        near_a = min(near_a, square(at[a, 0], at[a, 1], at[a, 2], tri))
        near_b = min(near_b, square(at[b, 0], at[b, 1], at[b, 2], tri))
    return max(far, math.sqrt(max(near_a, near_b)))


@compiled
def _pass(
    at: Floats,
    faces: Ints,
    first: Ints,
    following: Ints,
    quadric: Floats,
    moved: Floats,
    allowed: Floats,
    stamp: Ints,
    turn: int,
    dirty: Any,
    left: Any,
    share: float,
    longest: float,
) -> int:
    """Collapse what may go of the edges at `dirty` vertices; marks those `left` for the next pass; how many went."""
    star = np.empty(2 * STAR, np.int32)
    one, other = np.empty(2 * STAR, np.int32), np.empty(2 * STAR, np.int32)
    p, tri = np.empty(3), np.empty((3, 3))
    done = 0
    for t in range(len(faces)):
        if moved[t] < 0:
            continue
        for k in range(3):
            a, b = faces[t, k], faces[t, (k + 1) % 3]
            if a > b or not (dirty[a] or dirty[b]):
                continue
            far = (at[a, 0] - at[b, 0]) ** 2 + (at[a, 1] - at[b, 1]) ** 2 + (at[a, 2] - at[b, 2]) ** 2
            if stamp[a] == turn or stamp[b] == turn or far > longest * longest:
                left[a] = True
                left[b] = True
                continue
            most = share * min(allowed[a], allowed[b])
            if not most > 0:
                continue
            split = _star(a, faces, first, following, moved, star, 0)
            count = -1 if split < 0 else _star(b, faces, first, following, moved, star, split)
            if count < 0:
                continue
            before = 0.0
            for i in range(count):
                before = max(before, moved[star[i]])
            if before > most:
                continue
            _best(quadric[a] + quadric[b], at[a], at[b], p)
            move = _move(a, b, p, at, faces, star, count, split, most - before, tri)
            if before + move > most:
                continue
            n = _ring(a, b, faces, star, 0, split, one)
            m = _ring(b, a, faces, star, split, count, other)
            if not _linked(one, n, other, m, first, following, moved):
                continue
            for i in range(count):
                gone = 0
                for j in range(3):
                    x = faces[star[i], j]
                    if x in (a, b):
                        gone += 1
                moved[star[i]] = -1.0 if gone == 2 else before + move
            c, tail = first[b], -1
            while c >= 0:
                faces[c // 3, c % 3] = a
                tail = c
                c = following[c]
            following[tail] = first[a]
            first[a] = first[b]
            first[b] = -1
            at[a] = p
            quadric[a] += quadric[b]
            allowed[a] = min(allowed[a], allowed[b])
            stamp[a] = turn
            left[a] = True
            for i in range(n):
                stamp[one[i]] = turn
                left[one[i]] = True
            for i in range(m):
                stamp[other[i]] = turn
                left[other[i]] = True
            done += 1
            break
    return done
