"""What is left of a tetrahedron that a surface cuts: isosurface stuffing's stencils, for one side of it or for both.

A face of which the surface takes one corner off leaves a quadrilateral, which both tetrahedra of the face have to part
alike. So its diagonal is chosen by what both know: the corner that was cut off, and the two that stay. It starts at the
one that is joined to the first by a short edge of the lattice (from a corner of a cube to its centre) where only one
is, else at the one of lower rank; ranks alternate along the axes (the parity rule of F. Labelle & J. R. Shewchuk,
Isosurface Stuffing, SIGGRAPH 2007, section 3.2). That order has no circles, so that what is left can always be parted.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Indices = NDArray[np.int32]
MOST = 6  # tetrahedra that one becomes, both sides together


@compiled
def stuff(
    at: Floats,
    tets: Indices,
    sign: NDArray[np.int8],
    short: NDArray[np.int8],
    rank: Ints,
    slot: Indices,
    both: bool,
) -> tuple[Indices, NDArray[np.int8]]:
    """The tetrahedra (k, 4) that `tets` (m, 4) become, and on which side each is: 0 the inner (sign -1), 1 the outer,
    which is left out unless `both` are wanted.

    `at` are all vertices, cut points included; `sign` (n,) says where a corner is, 0 on the surface; `short` its kind,
    edges between kinds being the short ones; `rank` orders corners. `slot` (m, 6) are the cut points of the edges 01,
    02, 03, 12, 13, 23, read where an edge's ends are on different sides. Each tetrahedron turns as the first did.
    A tetrahedron with all corners on the surface belongs to the outer side.
    """
    count = 0
    piece = np.empty((MOST, 4), np.int32)
    side = np.empty(MOST, np.int8)
    for t in range(len(tets)):
        count += _part(at, tets[t], sign, short, rank, slot[t], both, piece, side)
    made = np.empty((count, 4), np.int32)
    sides = np.empty(count, np.int8)
    count = 0
    for t in range(len(tets)):
        n = _part(at, tets[t], sign, short, rank, slot[t], both, piece, side)
        made[count : count + n] = piece[:n]
        sides[count : count + n] = side[:n]
        count += n
    return made, sides


@compiled
def _edge(i: int, j: int) -> int:
    """The place of an edge among 01, 02, 03, 12, 13, 23."""
    low, high = min(i, j), max(i, j)
    return high - 1 if low == 0 else low + high


@compiled
def _squared(at: Floats, a: int, b: int) -> float:
    x, y, z = at[a, 0] - at[b, 0], at[a, 1] - at[b, 1], at[a, 2] - at[b, 2]
    return float(x * x + y * y + z * z)


@compiled
def _put(piece: Indices, side: NDArray[np.int8], n: int, s: int, a: int, b: int, c: int, d: int) -> int:
    piece[n, 0], piece[n, 1], piece[n, 2], piece[n, 3] = a, b, c, d
    side[n] = s
    return n + 1


@compiled
def _prism(
    piece: Indices, side: NDArray[np.int8], n: int, s: int,
    a: int, b: int, c: int, x: int, y: int, z: int, ab: bool, bc: bool, ca: bool,
) -> int:  # fmt: skip
    """A prism a b c - x y z, of which `ab` says that the diagonal of the side between a and b starts at a, not b."""
    if ab == bc and bc == ca:
        return -1  # it cannot be parted
    # the corner of a b c at which both its sides' diagonals start comes first
    if bc and not ab:
        a, b, c, x, y, z, ab, bc, ca = b, c, a, y, z, x, bc, ca, ab
    elif ca and not bc:
        a, b, c, x, y, z, ab, bc, ca = c, a, b, z, x, y, ca, ab, bc
    n = _put(piece, side, n, s, a, x, y, z)
    if bc:  # from b to z
        n = _put(piece, side, n, s, a, b, z, y)
        return _put(piece, side, n, s, a, b, c, z)
    n = _put(piece, side, n, s, a, z, y, c)
    return _put(piece, side, n, s, a, b, c, y)


@compiled
def _starts(p: int, q: int, r: int, short: NDArray[np.int8], rank: Ints) -> bool:
    """Whether the diagonal of what is left of a face without its corner p starts at q, not r."""
    one, other = short[p] != short[q], short[p] != short[r]
    if one != other:
        return bool(one)
    return bool(rank[q] < rank[r])


@compiled
def _part(
    at: Floats, tet: Indices, sign: NDArray[np.int8], short: NDArray[np.int8], rank: Ints, slot: Indices, both: bool,
    piece: Indices, side: NDArray[np.int8],
) -> int:  # fmt: skip
    order = np.empty(4, np.int64)
    inner = on = 0
    for k in range(4):
        inner += sign[tet[k]] < 0
        on += sign[tet[k]] == 0
    outer = 4 - inner - on
    if inner == 0 and not both:
        return 0
    if inner == 0 or outer == 0:
        return _put(piece, side, 0, 0 if outer == 0 and inner else 1, tet[0], tet[1], tet[2], tet[3])
    put = 0
    for s in range(-1, 2):
        for k in range(4):
            if sign[tet[k]] == s:
                order[put] = k
                put += 1
    odd = False
    for i in range(4):
        for j in range(i):
            odd ^= order[j] > order[i]
    if odd:  # two of a kind change places, so that it turns as before: some kind has two
        if inner >= 2:
            order[0], order[1] = order[1], order[0]
        elif on >= 2:
            order[1], order[2] = order[2], order[1]
        elif outer >= 2:
            order[2], order[3] = order[3], order[2]
    i, j, k, m = order[0], order[1], order[2], order[3]
    a, b, c, d = tet[i], tet[j], tet[k], tet[m]
    n = 0
    if inner == 1 and on == 2:
        x = slot[_edge(i, m)]
        n = _put(piece, side, n, 0, a, b, c, x)
        if both:
            n = _put(piece, side, n, 1, x, b, c, d)
    elif inner == 1 and on == 1:  # b on, c and d outer
        x, y = slot[_edge(i, k)], slot[_edge(i, m)]
        n = _put(piece, side, n, 0, a, b, x, y)
        if both:
            if _starts(a, c, d, short, rank):  # from c to y
                n = _put(piece, side, n, 1, x, b, c, y)
                n = _put(piece, side, n, 1, y, b, c, d)
            else:
                n = _put(piece, side, n, 1, x, b, c, d)
                n = _put(piece, side, n, 1, y, b, x, d)
    elif inner == 2 and on == 1:  # a, b inner, c on, d outer
        x, y = slot[_edge(i, m)], slot[_edge(j, m)]
        if _starts(d, a, b, short, rank):  # from a to y
            n = _put(piece, side, n, 0, a, b, c, y)
            n = _put(piece, side, n, 0, a, y, c, x)
        else:
            n = _put(piece, side, n, 0, a, b, c, x)
            n = _put(piece, side, n, 0, x, b, c, y)
        if both:
            n = _put(piece, side, n, 1, x, y, c, d)
    elif inner == 1:  # b, c, d outer
        x, y, z = slot[_edge(i, j)], slot[_edge(i, k)], slot[_edge(i, m)]
        n = _put(piece, side, n, 0, a, x, y, z)
        if both:
            bd, dc, cb = _starts(a, b, d, short, rank), _starts(a, d, c, short, rank), _starts(a, c, b, short, rank)
            # seen from a the cut comes first: the prism from b, c, d turns the other way
            n = _prism(piece, side, n, 1, b, d, c, x, z, y, bd, dc, cb)
    elif inner == 3:  # a, b, c inner, d outer
        x, y, z = slot[_edge(i, m)], slot[_edge(j, m)], slot[_edge(k, m)]
        ab, bc, ca = _starts(d, a, b, short, rank), _starts(d, b, c, short, rank), _starts(d, c, a, short, rank)
        n = _prism(piece, side, n, 0, a, b, c, x, y, z, ab, bc, ca)
        if both:
            n = _put(piece, side, n, 1, x, y, z, d)
    else:  # a, b inner, c, d outer
        ac, ad, bc, bd = slot[_edge(i, k)], slot[_edge(i, m)], slot[_edge(j, k)], slot[_edge(j, m)]
        from_a, also_a = _starts(c, a, b, short, rank), _starts(d, a, b, short, rank)
        from_c, also_c = _starts(a, c, d, short, rank), _starts(b, c, d, short, rank)
        shorter = _squared(at, ac, bd) <= _squared(at, ad, bc)
        for first in (shorter, not shorter):  # of the surface: from ac to bd, or from ad to bc
            n = _prism(piece, side, 0, 0, a, ac, ad, b, bc, bd, from_a, first, not also_a)
            if n > 0 and both:
                n = _prism(piece, side, n, 1, c, ac, bc, d, ad, bd, from_c, first, not also_c)
            if n > 0:
                break
    return n
