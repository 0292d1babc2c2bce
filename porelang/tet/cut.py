"""A background of tetrahedra cut at a surface: where its edges cross it, which vertices move there, what is left.

Isosurface stuffing, F. Labelle & J. R. Shewchuk, SIGGRAPH 2007, sections 3.1 and 3.2. A vertex that is nearer to a
crossing than a part of the edge would leave slivers: it is moved to the nearest such crossing, and its edges cross no
more. The parts that the paper gives bound the angles of what is left of a lattice of cubes and their centres.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.tet.stencils import stuff
from porelang.tet.tetmesh import volumes_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Indices = NDArray[np.int32]
Signs = NDArray[np.int8]
#: The field (n,) at points (n, 3) in mm.
Value = Callable[[Floats], Floats]

#: The least part of an edge between a corner that stays and the surface: of an edge along an axis, and of one from a
#: corner to a centre (Labelle & Shewchuk's for the largest least angle).
LONG, SHORT = 0.24999, 0.41189
LEAST = 0.2  # of its volume before: a tetrahedron in a plane is left as much
FURTHER = 1.5  # of the distance to the surface: within a plane it is looked for as far
STEPS = 60  # evaluations for one crossing at most; four or five do on smooth fields
NEAR = 1e-7  # of an edge: a crossing is known as closely as that
EDGES = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]], np.int32)


@dataclass(frozen=True, slots=True)
class Background:
    """Tetrahedra to be cut: vertices (n, 3) mm, tets (m, 4) of positive volume, of each vertex the field there (n,),
    its kind (n,), whose edges to another kind are short ones, its rank (n,), in which ties are broken, and in which
    planes it is `held` (n,), by bits: it is moved within them only."""

    vertices: Floats
    tets: Indices
    values: Floats
    kind: Signs
    rank: Ints
    held: NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Cut:
    """What a background became: vertices (n, 3) mm, tets (m, 4), side (m,) (0 where the field is below 0, 1 above),
    and which vertices (n,) lie on the surface."""

    vertices: Floats
    tets: Indices
    side: Signs
    on: NDArray[np.bool_]


def cut(background: Background, value: Value, both: bool = False) -> Cut:
    """Cut a background where a field is 0; of the side above 0 nothing is left unless `both` are wanted."""
    at, tets = background.vertices, background.tets
    sign = np.sign(background.values).astype(np.int8)
    some, mixed = sorted_out(tets, sign, both)
    keys, slot = crossed_edges(tets, mixed, sign)
    ends = np.stack([keys >> 32, keys & 0xFFFFFFFF], axis=1)
    share = crossings(at, ends, background.values, value)
    at, sign = at.copy(), sign.copy()
    points = at[ends[:, 0]] + share[:, None] * (at[ends[:, 1]] - at[ends[:, 0]])
    warp(at, sign, background, ends, share, points, value)
    while settled(at, sign, background, tets[mixed]):
        pass
    vertices = np.concatenate([at, points])
    slot = np.where(slot >= 0, slot + np.int32(len(at)), slot)
    parts, side = stuff(vertices, tets[mixed], sign, background.kind, background.rank, slot, both)
    whole = tets[some]
    kept = np.concatenate([whole, parts])
    sides = np.concatenate([(sign[whole].max(axis=1, initial=-1) > 0).astype(np.int8), side])
    on = np.concatenate([sign == 0, np.ones(len(points), np.bool_)])
    used = np.zeros(len(vertices), np.bool_)
    used[kept] = True
    number = np.cumsum(used, dtype=np.int32) - np.int32(1)
    return Cut(vertices[used], number[kept], sides, on[used])


def crossings(at: Floats, ends: Ints, values: Floats, value: Value) -> Floats:
    """Where on edges (k, 2), from the first end on, a field is 0: parts (k,) of their lengths, each bracketed.

    The secant, with the Illinois rule: of an end that stays twice the value is halved (M. Dowell & P. Jarratt 1971).
    """
    start, way = at[ends[:, 0]], at[ends[:, 1]] - at[ends[:, 0]]
    low, high = np.zeros(len(ends)), np.ones(len(ends))
    below, above = values[ends[:, 0]].copy(), values[ends[:, 1]].copy()
    share, scale = np.empty(len(ends)), np.minimum(np.abs(below), np.abs(above))
    todo, size = np.arange(len(ends)), scale
    last, slow = np.zeros(len(ends), np.int8), np.zeros(len(ends), np.bool_)
    for _ in range(STEPS):
        with np.errstate(all="ignore"):
            x = low - (high - low) * below / (above - below)
        x = np.where((x > low) & (x < high), x, (low + high) / 2)
        x = np.where(slow, (low + high) / 2, x)
        found = value(start + x[:, None] * way)
        first = (found < 0) == (below < 0)
        share[todo] = x
        same = last == np.where(first, 1, -1)
        above = np.where(first, np.where(same, above / 2, above), found)
        below = np.where(first, found, np.where(same, below / 2, below))
        before = high - low
        low, high = np.where(first, x, low), np.where(first, high, x)
        # a kink holds one end, and the values do not fall: then the middle is tried
        slow = (high - low > 0.5 * before) & (np.abs(found) > 0.25 * size)
        size = np.abs(found)
        last = np.where(first, 1, -1).astype(np.int8)
        left = (np.abs(found) > NEAR * scale) & (high - low > NEAR)
        todo, low, high, below, above, last = todo[left], low[left], high[left], below[left], above[left], last[left]
        scale, size = scale[left], size[left]
        start, way, slow = start[left], way[left], slow[left]
        if not len(todo):
            break
    return np.clip(share, 1e-9, 1 - 1e-9)


def sorted_out(tets: Indices, sign: Signs, both: bool) -> tuple[Ints, Ints]:
    """The tetrahedra that are left whole, and those that have corners on both sides, or on the surface."""
    low, high = _extremes(tets, sign)
    whole = (high < 0) | ((low > 0) & both)
    return np.flatnonzero(whole), np.flatnonzero(~whole & ((low < 0) | both))


def crossed_edges(tets: Indices, some: Ints, sign: Signs) -> tuple[Ints, Indices]:
    """The edges that join both sides, as keys (k,) of two ends, the lower in the upper half; and the number of each of
    the edges of `some` tetrahedra (j, 6), -1 where it does not."""
    keys, place = _crossed(tets, some, sign)
    found, number = np.unique(keys, return_inverse=True)
    slot = np.full((len(some), 6), np.int32(-1), np.int32)
    slot.ravel()[place] = number.ravel()
    return found, slot


def warp(
    at: Floats, sign: Signs, background: Background, ends: Ints, share: Floats, points: Floats, value: Value
) -> int:
    """Move every vertex that is too near to a crossing of one of its edges there; the nearest first.

    What is held in a plane goes along edges within it; where none of them is crossed nearby, to where the surface meets
    the plane; and where that does not, it stays and counts as on the surface: how many do is returned.
    """
    kind, held = background.kind, background.held
    least = np.where(kind[ends[:, 0]] == kind[ends[:, 1]], LONG, SHORT)
    one, other = np.where(share < 0.5, ends.T, ends.T[::-1])
    near = np.flatnonzero(np.minimum(share, 1 - share) < least)
    target = points[near]
    leaves = (held[one[near]] & ~held[other[near]]) != 0
    if leaves.any():
        target[leaves] = _within(at, one[near[leaves]], held, background.values, value, target[leaves])
    distance = np.linalg.norm(target - at[one[near]], axis=1)
    stays = distance == 0
    distance[stays] = np.inf
    order = np.argsort(distance, kind="stable")
    return int(_warp(at, sign, one[near], other[near], target, stays, order))


def settled(at: Floats, sign: Signs, background: Background, tets: Indices) -> int:
    """Put vertices back that have left a tetrahedron next to no volume, of each the one that went furthest; how many.

    It is so where three that bound one in a plane came to lie on one line, and where cubes of two sizes meet, as along
    an edge of the larger a vertex goes far for the smaller. Among cubes of one size at least 0.3 of a volume is left.
    """
    volume, before = volumes_of(at, tets), volumes_of(background.vertices, tets)
    some = tets[volume < LEAST * before]
    gone = np.linalg.norm(at[some] - background.vertices[some], axis=2)
    planes = background.held[some] != 0
    gone *= planes | (planes.sum(axis=1) < 2)[:, None]
    back = np.unique(some[np.arange(len(some)), gone.argmax(axis=1)][gone.max(axis=1, initial=0) > 0])
    at[back] = background.vertices[back]
    sign[back] = np.sign(background.values[back])
    return len(back)


def _within(at: Floats, some: Ints, held: NDArray[np.uint8], values: Floats, value: Value, points: Floats) -> Floats:
    """Where the surface is met from vertices along its steepest way within the planes that these are held in; their own
    places where it is not met near by. `points` are places on it beside them."""
    free = np.stack([(held[some] >> (2 * k)) & 3 for k in range(3)], axis=1) == 0
    reach = np.linalg.norm(points - at[some], axis=1)
    start = at[some]
    slope = np.zeros((len(some), 3))
    for k in range(3):
        step = np.zeros((len(some), 3))
        step[:, k] = 0.01 * reach + 1e-9
        with np.errstate(all="ignore"):
            slope[:, k] = (value(start + step) - value(start - step)) / step[:, k] * free[:, k]
    length = np.linalg.norm(slope, axis=1)
    with np.errstate(all="ignore"):
        way = -np.sign(values[some])[:, None] * np.where(length > 0, slope.T / length, 0.0).T
    way = np.nan_to_num(way) * (FURTHER * reach)[:, None]
    ends = np.arange(2 * len(some)).reshape(2, -1).T
    both = np.concatenate([start, start + way])
    seen = np.concatenate([values[some], value(start + way)])
    met = np.flatnonzero(seen[ends[:, 0]] * seen[ends[:, 1]] < 0)
    found = start.copy()
    found[met] += crossings(both, ends[met], seen, value)[:, None] * way[met]
    return found


@compiled
def _warp(
    at: Floats, sign: Signs, one: Ints, other: Ints, target: Floats, stays: NDArray[np.bool_], order: Ints
) -> int:
    stayed = 0
    for e in order:
        v = one[e]
        if sign[v] != 0 and sign[other[e]] != 0:
            sign[v] = 0
            at[v] = target[e]
            stayed += stays[e]
    return stayed


@compiled
def _extremes(tets: Indices, sign: Signs) -> tuple[Signs, Signs]:
    low, high = np.empty(len(tets), np.int8), np.empty(len(tets), np.int8)
    for t in range(len(tets)):
        a, b, c, d = sign[tets[t, 0]], sign[tets[t, 1]], sign[tets[t, 2]], sign[tets[t, 3]]
        low[t], high[t] = min(a, b, c, d), max(a, b, c, d)
    return low, high


@compiled
def _crossed(tets: Indices, some: Ints, sign: Signs) -> tuple[Ints, Ints]:
    count = 0
    for t in some:
        for i in range(4):
            for j in range(i):
                count += sign[tets[t, i]] * sign[tets[t, j]] < 0
    keys, place = np.empty(count, np.int64), np.empty(count, np.int64)
    n = 0
    for row in range(len(some)):
        e = 6 * row
        for i in range(4):
            for j in range(i + 1, 4):
                a, b = np.int64(tets[some[row], i]), np.int64(tets[some[row], j])
                if sign[a] * sign[b] < 0:
                    keys[n], place[n] = (min(a, b) << 32) | max(a, b), e
                    n += 1
                e += 1
    return keys, place
