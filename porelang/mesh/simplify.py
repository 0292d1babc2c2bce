"""Fewer triangles within a stated deviation: quadric edge collapse, many edges at once, measured afterwards.

An edge becomes a vertex where the planes of the triangles round it are met best (Garland & Heckbert 1997, "Surface
simplification using quadric error metrics"). A round collapses every edge that is the cheapest in its neighbourhood: no
two such edges have neighbours in common triangles, so each can be judged as if it were alone. The mesh stays a
manifold by the link condition. As the quadrics only estimate a distance, the result is measured against the original,
both ways, and made again more carefully if it deviates too far.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import CancelledError
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.surface import Surface

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
AT_ONCE = 2**16
ROUNDS = 200
CLOSEST = 12  # triangles that are tried as the nearest to a point
ATTEMPTS = 14
CARE = 0.35  # what is allowed where a mesh went too far, as a part of what was allowed before
LEAST_TURN = 0.3  # cosine of the angle that a triangle may turn by in one collapse


@dataclass(frozen=True, slots=True)
class Simplified:
    """A surface with fewer triangles, and the largest distance (mm) found between it and the original."""

    surface: Surface
    deviation: float


def simplify(surface: Surface, deviation: float, cancel: Callable[[], bool] | None = None) -> Simplified:
    """The surface with as few triangles as keep it within `deviation` (mm) of the original, closed as before.

    The deviation is measured at the vertices, the middles of the edges and the centres of the triangles of either
    surface; if no collapse keeps to it, the surface is given back as it is. Raises `CancelledError` when cancelled.
    """
    from scipy.spatial import cKDTree

    allowed = np.full(len(surface.vertices), deviation)
    tree: Any = None
    for attempt in range(ATTEMPTS):
        made = _collapse(surface, allowed, cancel)
        there, triangle = _distances(surface, made)
        back, _ = _distances(made, surface)
        measured = max(float(there.max()), float(back.max()))
        if measured <= deviation:
            return Simplified(made, measured)
        # Only where it went too far is it to be done with more care.
        mine = np.flatnonzero(back > deviation) % len(made.faces)
        wrong = np.unique(np.concatenate([triangle[there > deviation], mine]))
        corners = made.vertices[made.faces[wrong]]
        middle = corners.mean(axis=1)
        reach = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1) + deviation
        tree = cKDTree(surface.vertices) if tree is None else tree
        near = np.unique(np.concatenate([np.array(w, np.int64) for w in tree.query_ball_point(middle, reach)]))
        allowed[near] *= CARE if attempt < 4 else np.nan  # and at last not at all
    return Simplified(surface, 0.0)


def _collapse(surface: Surface, allowed: Floats, cancel: Callable[[], bool] | None) -> Surface:
    at = surface.vertices.copy()
    faces = surface.faces.astype(np.int64)
    quadric, weight = _quadrics(at, faces)
    allowed = allowed.copy()
    floor = float(np.nanmax(allowed) / 8) ** 2 if np.isfinite(allowed).any() else 0.0
    stuck = False
    refused = np.zeros(0, np.int64)  # edges that cannot go as things are: they would only keep their neighbours waiting
    for turn in range(ROUNDS):
        if cancel is not None and cancel():
            raise CancelledError
        a, b = _edges(faces, len(at))
        place, cost = _best(at, quadric, weight, a, b)
        keys = a * len(at) + b
        cheap = np.flatnonzero((cost <= np.minimum(allowed[a], allowed[b]) ** 2) & ~np.isin(keys, refused))
        length = np.linalg.norm(at[a[cheap]] - at[b[cheap]], axis=1)
        order = _order(np.maximum(cost[cheap], floor), length, turn)
        apart = cheap[_apart(faces, a[cheap], b[cheap], order, len(at))]
        chosen = apart[_linked(a, b, apart, len(at))]
        chosen = chosen[_keeps_facing(at, faces, a[chosen], b[chosen], place[chosen])]
        refused = np.concatenate([refused, np.setdiff1d(keys[apart], keys[chosen])])
        keep, gone = a[chosen], b[chosen]
        at[keep] = place[chosen]
        quadric[keep] += quadric[gone]
        weight[keep] += weight[gone]
        allowed[keep] = np.minimum(allowed[keep], allowed[gone])
        to = np.arange(len(at))
        to[gone] = keep
        before = len(faces)
        faces = to[faces]
        faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])]
        if before - len(faces) < 0.003 * before:
            if not len(refused):
                break
            refused = refused[:0]  # their neighbours have changed: they get one more chance
            if stuck:
                break
            stuck = True
        else:
            stuck = False
    used = np.unique(faces)
    number = np.zeros(len(at), np.int32)
    number[used] = np.arange(len(used), dtype=np.int32)
    return Surface(at[used], number[faces])


def _order(cost: Floats, length: Floats, turn: int) -> Ints:
    """The rank of each edge: by cost, then by length, both by octaves, then by chance."""
    chance = np.random.default_rng(turn).random(len(cost))
    rank = np.empty(len(cost), np.int64)
    with np.errstate(divide="ignore"):
        octaves = np.round(np.log2(cost)), np.round(np.log2(length))
    rank[np.lexsort((chance, octaves[1], octaves[0]))] = np.arange(len(cost))
    return rank


def _quadrics(at: Floats, faces: Ints) -> tuple[Floats, Floats]:
    """For each vertex the sum of area n n^T over its triangles, n a plane (4), as (n, 4, 4), and of the areas."""
    normal = np.cross(at[faces[:, 1]] - at[faces[:, 0]], at[faces[:, 2]] - at[faces[:, 0]])
    area = np.linalg.norm(normal, axis=1)
    with np.errstate(all="ignore"):
        normal = np.nan_to_num(normal / area[:, None])
    plane = np.concatenate([normal, -np.einsum("ij,ij->i", normal, at[faces[:, 0]])[:, None]], axis=1)
    quadric = np.zeros((len(at), 4, 4))
    for i in range(4):
        for j in range(i, 4):
            entry = area * plane[:, i] * plane[:, j]
            total = sum(np.bincount(faces[:, k], entry, len(at)) for k in range(3))
            quadric[:, i, j] = quadric[:, j, i] = total
    weight = sum(np.bincount(faces[:, k], area, len(at)) for k in range(3))
    return quadric, np.asarray(weight)


def _edges(faces: Ints, count: int) -> tuple[Ints, Ints]:
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    ends = ends[ends[:, 0] < ends[:, 1]]
    keys = np.sort(ends[:, 0] * count + ends[:, 1])[::2]  # every edge has two triangles
    return keys // count, keys % count


def _best(at: Floats, quadric: Floats, weight: Floats, a: Ints, b: Ints) -> tuple[Floats, Floats]:
    """Where each edge's vertex goes, and the mean square distance (mm2) there from the planes it stands for."""
    place, cost = np.empty((len(a), 3)), np.empty(len(a))
    for i in range(0, len(a), AT_ONCE):
        s = slice(i, i + AT_ONCE)
        q, w = quadric[a[s]] + quadric[b[s]], weight[a[s]] + weight[b[s]]
        middle = (at[a[s]] + at[b[s]]) / 2
        # A pull to the middle, too weak to matter but where the planes leave a direction free.
        matrix = q[:, :3, :3] + (1e-3 * w)[:, None, None] * np.eye(3)
        slope = np.einsum("nij,nj->ni", q[:, :3, :3], middle) + q[:, :3, 3]
        with np.errstate(all="ignore"):
            there = middle - np.linalg.solve(matrix, slope[:, :, None])[:, :, 0] if (w > 0).all() else middle
        long = np.linalg.norm(there - middle, axis=1) > np.linalg.norm(at[a[s]] - at[b[s]], axis=1)
        there = np.where(long[:, None] | ~np.isfinite(there), middle, there)
        full = np.concatenate([there, np.ones((len(there), 1))], axis=1)
        with np.errstate(all="ignore"):
            square = np.maximum(np.einsum("ni,nij,nj->n", full, q, full), 0.0) / w
        place[s], cost[s] = there, np.where(np.isfinite(square), square, np.inf)
    return place, cost


def _apart(faces: Ints, a: Ints, b: Ints, rank: Ints, count: int) -> NDArray[np.bool_]:
    """The edges that come before all those that touch a neighbour of theirs."""
    least = np.full(count, len(a), np.int64)
    np.minimum.at(least, a, rank)
    np.minimum.at(least, b, rank)
    near = least.copy()
    lowest = least[faces].min(axis=1)
    for k in range(3):
        np.minimum.at(near, faces[:, k], lowest)
    first: NDArray[np.bool_] = (near[a] == rank) & (near[b] == rank)
    return first


def _linked(a: Ints, b: Ints, chosen: Ints, count: int) -> NDArray[np.bool_]:
    """The edges whose ends have two neighbours in common, neither of which would be left with two."""
    valence = np.bincount(np.concatenate([a, b]), minlength=count)
    which = np.full(count, -1, np.int64)
    which[a[chosen]] = which[b[chosen]] = np.arange(len(chosen))
    one = np.concatenate([a, b])
    two = np.concatenate([b, a])
    touched = which[one] >= 0
    keys = np.sort(which[one[touched]] * count + two[touched])
    shared = keys[:-1][keys[1:] == keys[:-1]]
    edge, vertex = shared // count, shared % count
    common = np.bincount(edge, minlength=len(chosen))
    slim = np.bincount(edge, valence[vertex] <= 3, minlength=len(chosen))
    linked: NDArray[np.bool_] = (common == 2) & (slim == 0)
    return linked


def _keeps_facing(at: Floats, faces: Ints, a: Ints, b: Ints, place: Floats) -> NDArray[np.bool_]:
    """The edges whose collapse turns no triangle by much, nor makes it vanish."""
    which = np.full(len(at), -1, np.int64)
    which[a] = which[b] = np.arange(len(a))
    owner = which[faces]
    some = faces[(owner >= 0).any(axis=1)]
    owner = which[some]
    mine = owner.max(axis=1)
    left = (owner >= 0).sum(axis=1) == 1  # the two triangles at the edge go
    some, owner, mine = some[left], owner[left], mine[left]
    old = at[some]
    new = np.where((owner >= 0)[:, :, None], place[mine][:, None], old)
    before = np.cross(old[:, 1] - old[:, 0], old[:, 2] - old[:, 0])
    after = np.cross(new[:, 1] - new[:, 0], new[:, 2] - new[:, 0])
    sizes = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    longest = np.max([((new[:, k] - new[:, k - 1]) ** 2).sum(axis=1) for k in range(3)], axis=0)
    bad = np.einsum("ij,ij->i", before, after) <= LEAST_TURN * sizes
    bad |= np.linalg.norm(after, axis=1) <= 1e-3 * longest  # a needle, whose normal means nothing
    facing: NDArray[np.bool_] = np.bincount(mine, bad, minlength=len(a)) == 0
    return facing


def distance(one: Surface, other: Surface) -> float:
    """The largest distance (mm) found from points of either surface to the other one."""
    return max(float(_distances(one, other)[0].max()), float(_distances(other, one)[0].max()))


def _distances(of: Surface, to: Surface) -> tuple[Floats, Ints]:
    """Bounds on the distances (5 m,) to `to` from a corner, the centre and the edge middles of every triangle of `of`,
    one kind after the other, and the triangle of `to` that is nearest to each."""
    from scipy.spatial import cKDTree

    corners = to.vertices[to.faces]
    spacing = 2 * np.sqrt((of.area + to.area) / (len(of.faces) + 1))
    places, whose = _strewn(corners, spacing)
    tree: Any = cKDTree(places)
    own = of.vertices[of.faces]
    points = np.concatenate([own[:, 0], own.mean(axis=1), *((own[:, k] + own[:, k - 1]) / 2 for k in range(3))])
    least, nearest = np.full(len(points), np.inf), np.zeros(len(points), np.int64)
    for i in range(0, len(points), AT_ONCE):
        s = slice(i, i + AT_ONCE)
        found = whose[tree.query(points[s], k=min(CLOSEST, tree.n))[1].reshape(len(points[s]), -1)]
        for k in range(found.shape[1]):
            far = _to_triangle(points[s], corners[found[:, k]])
            closer = far < least[s]
            least[s][closer], nearest[s][closer] = far[closer], found[closer, k]
    return least, nearest


def _strewn(corners: Floats, spacing: float) -> tuple[Floats, Ints]:
    """Points on triangles (m, 3, 3), no further than about `spacing` apart, and the triangle that each is on."""
    longest = np.max([np.linalg.norm(corners[:, k] - corners[:, k - 1], axis=1) for k in range(3)], axis=0)
    steps = np.clip(np.ceil(longest / spacing), 1, 64).astype(np.int64)
    places, whose = [], []
    for n in np.unique(steps):
        some = np.flatnonzero(steps == n)
        i, j = (w.ravel() for w in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
        i, j = (w[i + j < n] + 1 / 3 for w in (i, j))
        weights = np.stack([i, j, n - i - j], axis=1) / n
        places.append(np.einsum("wk,nki->nwi", weights, corners[some]).reshape(-1, 3))
        whose.append(np.repeat(some, len(weights)))
    return np.concatenate(places), np.concatenate(whose)


def _to_triangle(points: Floats, corners: Floats) -> Floats:
    """The distances of points (n, 3) from triangles (n, 3, 3)."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    square = np.einsum("ij,ij->i", normal, normal)
    inside = np.ones(len(points), np.bool_)
    least = np.full(len(points), np.inf)
    for k in range(3):
        start, side = corners[:, k], corners[:, (k + 1) % 3] - corners[:, k]
        to = points - start
        inside &= np.einsum("ij,ij->i", np.cross(side, to), normal) >= 0
        with np.errstate(all="ignore"):
            part = np.einsum("ij,ij->i", to, side) / np.einsum("ij,ij->i", side, side)
        foot = np.clip(np.nan_to_num(part), 0, 1)[:, None] * side
        least = np.minimum(least, np.linalg.norm(to - foot, axis=1))
    with np.errstate(all="ignore"):
        height = np.abs(np.einsum("ij,ij->i", points - corners[:, 0], normal)) / np.sqrt(square)
    return np.where(inside & (square > 0), height, least)
