"""Triangles as files have them, made fit to be closed: repeated ones left out, edges that meet sewn, rims of holes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

Points = NDArray[np.float64]
Faces = NDArray[np.int64]
Mask = NDArray[np.bool_]

#: Open corners that may lie on edges, over all edges: some 3 s.
MOST_PAIRS = 5_000_000
#: Of the distance over which open edges are sewn: corners that are nearer are one.
ONE = 1 / 4


def merged(vertices: Points, faces: Faces, near: float) -> Faces:
    """Triangles (n, 3) whose corners are one where they are no farther than `near` apart: rounded, or scanned twice."""
    pairs = cKDTree(vertices).query_pairs(near, output_type="ndarray")
    if not len(pairs):
        return faces
    _, cluster = connected(pairs, len(vertices))
    _, first = np.unique(cluster, return_index=True)
    faces = first[cluster][faces]
    return np.ascontiguousarray(faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)])


def distinct(faces: Faces) -> Faces:
    """Triangles (n, 3) without those that stand more than once, whichever way turned.

    One of a group is kept where its neighbours need one to meet it. They need none, or two, where bodies touch or
    overlap with faces in common: then what is kept of a group winds round as all of it does.
    """
    corners, group, count = np.unique(np.sort(faces, axis=1), axis=0, return_inverse=True, return_counts=True)
    if len(corners) == len(faces):
        return faces
    group = group.reshape(-1)
    repeated, even = count > 1, _even(corners, count > 1)
    # Triangles are turned one way or the other as their corners follow each other upwards an odd or an even times.
    upwards = (faces < np.roll(faces, -1, axis=1)).sum(axis=1) == 2
    net = np.bincount(group, np.where(upwards, 1, -1), len(corners))
    wanted = np.where(even, np.where(net == 0, 0, 2), 1)
    fits = upwards == (net[group] > 0)
    fits |= (net == 0)[group]
    order = np.lexsort((~fits, group))  # of each group, those turned as most of it are first
    place = np.empty(len(faces), np.int64)
    place[order] = np.arange(len(faces)) - np.repeat(np.cumsum(count) - count, count)
    return np.ascontiguousarray(faces[~repeated[group] | (place < wanted[group])])


def _even(corners: Faces, repeated: Mask) -> Mask:
    """Which of the repeated triangles (n, 3) are to be there an even number of times, for every edge to have an even
    number of triangles: found from the rims of the regions of repeated ones inwards. A region without a rim is a shell:
    there once."""
    _, edge = _edges(corners)
    edge = edge.reshape(-1, 3)
    edges = int(edge.max()) + 1
    shared = np.bincount(edge.reshape(-1), minlength=edges) > 1
    odd, unknown = ~repeated, repeated.copy()
    while unknown.any():
        open_to = np.bincount(edge[unknown].reshape(-1), minlength=edges)
        passed = np.bincount(edge[odd & ~unknown].reshape(-1), minlength=edges) % 2 == 1
        which = np.flatnonzero(unknown)
        told = (open_to[edge[which]] == 1) & shared[edge[which]]
        for_one = np.where(told, np.where(passed[edge[which]], 1, -1), 0).sum(axis=1)
        known = told.any(axis=1)
        if not known.any():
            odd[which] = True
            break
        odd[which[known]] = for_one[known] >= 0
        unknown[which[known]] = False
    return ~odd


def _edges(faces: Faces) -> tuple[Faces, NDArray[np.int64]]:
    """The edges (m, 2) that triangles have, and the number of each of their 3 n sides."""
    sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    names, numbers = np.unique(sides[:, 0] * (faces.max() + 1) + sides[:, 1], return_inverse=True)
    return np.stack(np.divmod(names, faces.max() + 1), axis=1), numbers.reshape(-1)


def rim(faces: Faces) -> Faces:
    """The directed edges (n, 2) which the triangles pass more often one way than the other: those of holes."""
    pairs, numbers = _edges(faces)
    ways = np.where(faces < np.roll(faces, -1, axis=1), 1.0, -1.0).reshape(-1)
    passes = np.bincount(numbers, ways, len(pairs)).astype(np.int64)
    forth, back = np.repeat(pairs, np.maximum(passes, 0), axis=0), np.repeat(pairs, np.maximum(-passes, 0), axis=0)
    return np.concatenate([forth, back[:, ::-1]])


def sewn(vertices: Points, faces: Faces, gap: float) -> Faces:
    """Triangles whose open edges are joined where they are no farther than `gap` apart, if that is little beside them.

    Corners become one; where that of one edge lies on another, as at T-junctions, slivers lead the other round by it.
    """
    edges = rim(faces)
    if not len(edges):
        return faces
    gap = min(gap, 0.25 * float(np.median(np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1))))
    open_ones = np.unique(edges)
    pairs = cKDTree(vertices[open_ones]).query_pairs(gap, output_type="ndarray")
    if len(pairs):
        _, cluster = connected(pairs, len(open_ones))
        _, first = np.unique(cluster, return_index=True)
        now = np.arange(len(vertices))
        now[open_ones] = open_ones[first[cluster]]
        faces = now[faces]
        faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    slivers = _round_by(vertices, rim(faces), gap)
    return np.concatenate([faces, slivers])


def _round_by(vertices: Points, edges: Faces, gap: float) -> Faces:
    """Triangles (n, 3) beside edges (m, 2) that lead round by the open corners on them: from a to b by way of those."""
    open_ones = np.unique(edges)
    if not len(open_ones):
        return np.zeros((0, 3), np.int64)
    tree = cKDTree(vertices[open_ones])
    start, end = vertices[edges[:, 0]], vertices[edges[:, 1]]
    length = np.linalg.norm(end - start, axis=1)
    some = np.random.default_rng(1).choice(len(edges), min(200, len(edges)), replace=False)
    about = tree.query_ball_point(0.5 * (start + end)[some], 0.5 * length[some] + gap, return_length=True)
    if float(about.mean()) * len(edges) > MOST_PAIRS:  # edges at random, and no seams
        return np.zeros((0, 3), np.int64)
    made = [np.zeros((0, 3), np.int64)]
    for first in range(0, len(edges), 1 << 14):
        here = slice(first, first + (1 << 14))
        lists = tree.query_ball_point(0.5 * (start + end)[here], 0.5 * length[here] + gap)
        number = np.repeat(np.arange(len(lists)) + first, [len(one) for one in lists])
        corner = open_ones[np.concatenate([np.array(one, np.int64) for one in lists])]
        way = (end - start)[number] / np.maximum(length[number], 1e-300)[:, None]
        along = np.einsum("ij,ij->i", vertices[corner] - start[number], way)
        off = np.linalg.norm(vertices[corner] - start[number] - along[:, None] * way, axis=1)
        on = (off <= gap) & (along > gap) & (along < length[number] - gap)
        on &= (corner != edges[number, 0]) & (corner != edges[number, 1])
        number, corner, along = number[on], corner[on], along[on]
        order = np.lexsort((along, number))
        number, corner = number[order], corner[order]
        begins = np.ones(len(number), np.bool_)
        begins[1:] = number[1:] != number[:-1]
        before = np.where(begins, edges[number, 0], np.roll(corner, 1))
        made.append(np.stack([edges[number, 1], before, corner], axis=1))
    return np.concatenate(made)


def loops(edges: Faces) -> tuple[int, NDArray[np.int64]]:
    """How many closed loops directed edges (n, 2) make, of which none passes a corner twice, and the loop of each.

    As many of the edges end in every corner as begin there: they bound triangles.
    """
    leaving: dict[int, list[int]] = {}
    ends = edges[:, 1].tolist()
    for number, start in enumerate(edges[:, 0].tolist()):
        leaving.setdefault(start, []).append(number)
    loop_of = np.zeros(len(edges), np.int64)
    count = 0
    for start in list(leaving):
        here, path, since = start, list[int](), dict[int, int]()
        while here in since or leaving[here]:
            if (begun := since.get(here)) is None:
                since[here] = len(path)
                path.append(leaving[here].pop())
            else:
                for number in path[begun:]:
                    del since[int(edges[number, 0])]
                    loop_of[number] = count
                count += 1
                del path[begun:]
                continue
            here = ends[path[-1]]
    return count, loop_of


def connected(pairs: Faces, count: int) -> tuple[int, NDArray[np.int32]]:
    """How many groups links (n, 2) make of so many things, and the group of each."""
    linked = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (count, count))
    return connected_components(linked, directed=False)  # type: ignore[no-any-return]  # SciPy has no types
