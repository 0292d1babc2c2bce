"""Vertices that came to lie together, made one or moved apart, so that no file's rounding joins what is not joined."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

import numpy as np

from porelang.mesh.crossed import crossed
from porelang.mesh.patched import Patched, around, several, turned
from porelang.mesh.rims import Ints, meet
from porelang.mesh.surface import Surface

CLOSE = 0.01  # voxels
APART = 1e-3  # voxels: enough for a file of 32-bit numbers
NEARBY = 0.1  # voxels: how far from there its branch may be
ASIDE = 0.05  # of the way to the middle of its neighbours


def merge(mesh: Patched) -> None:
    """Join the vertices that are closer than CLOSE by an edge that can go; of others, move one aside. Those stay whose
    move would make the mesh run through itself."""
    pairs = _pairs(mesh)
    start = mesh.at, mesh.on, mesh.faces
    while len(pairs):
        mesh.at, mesh.on, mesh.faces = start[0].copy(), start[1].copy(), start[2]
        _merge(mesh, pairs)
        through = np.unique(mesh.faces[crossed(Surface(mesh.at, mesh.faces.astype(np.int32)))])
        apart = np.linalg.norm(start[0][pairs[:, 0]] - start[0][pairs[:, 1]], axis=1) > APART * mesh.voxel
        left = ~(np.isin(pairs, through).any(axis=1) & apart)
        if left.all():
            return
        pairs = pairs[left]
    mesh.at, mesh.on, mesh.faces = start


def _merge(mesh: Patched, pairs: Ints) -> None:
    near = around(mesh.faces, pairs, len(mesh.at), 2)
    fans: dict[int, set[int]] = defaultdict(set)
    faces = {int(i): [int(v) for v in mesh.faces[i]] for i in np.flatnonzero(near)}
    for i, face in faces.items():
        for v in face:
            fans[v].add(i)
    on = {v: {int(k) for k in mesh.on[v]} for v in fans}
    for a, b in pairs.tolist():
        keep, gone = (a, b) if on[a] >= on[b] else (b, a)
        if on[keep] >= on[gone] and _can_go(fans, faces, keep, gone):
            _join(mesh, fans, faces, keep, gone)
    left = np.array([faces[i] for i in sorted(faces)], np.int64)
    mesh.faces = np.concatenate([mesh.faces[~near], left])
    _aside(mesh, mesh.faces[around(mesh.faces, pairs, len(mesh.at), 1)], pairs)


def _pairs(mesh: Patched) -> Ints:
    """Vertices that are close to one another, one of them at least on a rim, (n, 2)."""
    from scipy.spatial import cKDTree

    used = np.unique(mesh.faces)
    tree: Any = cKDTree(mesh.at[used])
    pairs: Ints = used[tree.query_pairs(CLOSE * mesh.voxel, output_type="ndarray")]
    rims = several(mesh.on) > 1
    return pairs[rims[pairs].any(axis=1) & ~mesh.fixed[pairs].any(axis=1)]


def _can_go(fans: dict[int, set[int]], faces: dict[int, list[int]], keep: int, gone: int) -> bool:
    """Whether two vertices have an edge whose collapse leaves a manifold."""
    rings = [{v for i in fans[e] for v in faces[i]} - {keep, gone} for e in (keep, gone)]
    common = rings[0] & rings[1]
    return len(fans[keep] & fans[gone]) == 2 and len(common) == 2 and all(len(fans[v]) > 3 for v in common)


def _join(mesh: Patched, fans: dict[int, set[int]], faces: dict[int, list[int]], keep: int, gone: int) -> None:
    """Collapse an edge, unless a triangle turns over."""
    out = fans[keep] & fans[gone]
    moved = {i: [keep if v == gone else v for v in faces[i]] for i in fans[gone] - out}
    if turned(mesh, np.array(list(moved.values()), np.int64)).any():
        return
    faces.update(moved)
    for i in out:
        for v in faces.pop(i):
            fans[v].discard(i)
    fans[keep] |= set(moved)
    fans[gone] = set()


def _aside(mesh: Patched, faces: Ints, pairs: Ints) -> None:
    """Move one of every two vertices that are still close a little towards its neighbours, on one of its branches."""
    close = _pairs(mesh)
    for a, b in close[np.isin(close, pairs).all(axis=1)].tolist():
        for v in (a, b):
            mine = faces[(faces == v).any(axis=1)]
            others = np.setdiff1d(mine, [v])
            old, wrong = mesh.at[v].copy(), turned(mesh, mine).sum()
            aside = old + ASIDE * (mesh.at[others].mean(axis=0) - old)
            choices = np.unique(mesh.on[v])[:, None]
            places, sure = meet(np.tile(aside, (len(choices), 1)), choices, mesh.field, mesh.voxel, NEARBY)
            # If it cannot be on the surface there, better off it than on another vertex.
            places, choices = np.concatenate([places[sure], aside[None]]), np.concatenate([choices[sure], choices[:1]])
            for place, on in zip(places, choices, strict=True):
                mesh.at[v] = place
                apart = np.linalg.norm(place - mesh.at[a + b - v]) > APART * mesh.voxel
                if apart and turned(mesh, mine).sum() <= wrong:
                    mesh.on[v] = on
                    break
            else:
                mesh.at[v] = old
                continue
            break
