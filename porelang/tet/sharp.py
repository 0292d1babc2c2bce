"""Rims of a part made edges of its tetrahedra: vertices of the surface next to a rim are moved onto it.

Stuffing cuts rims off: its vertices lie on one surface or the other, and edges between them cross the rim unseen. The
field tells which branch a vertex is on, so such an edge is known, not guessed: of its ends the nearer one is moved to
where the two branches meet, of those on a rim next to a third surface to the corner. A vertex moves only as far as the
angles round it allow; inner vertices make room.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.branches import Branches
from porelang.progress import tell
from porelang.tet.frame import Frame
from porelang.tet.moving import Stars, improve, onto_branches
from porelang.tet.rims import INSIDE, branch_of, meet

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Indices = NDArray[np.int32]
Flags = NDArray[np.bool_]

ROUNDS = 10
REACH = 2.0  # cubes: how far from a vertex a rim is, as beyond a chamfered wedge
FIRST, LEAST = 14.0, 13.0  # degrees: dihedral angles that rims leave at first, and at last, if they were no smaller
POOR = 16.0  # degrees: what has smaller angles is made better, as far as inner vertices can
FEW = 0.02  # of the edges that cross rims: where fewer are mended the first will not do
ROOM = 0.35  # cubes: how far an inner vertex makes room at once
WAYS = np.array([w for w in np.ndindex(3, 3, 3) if w != (1, 1, 1)]) - 1.0
WAYS /= np.linalg.norm(WAYS, axis=1)[:, None]


@dataclass(frozen=True, slots=True)
class Sharpened:
    """What was done at rims: `moved` vertices, and triangles that still cut off a rim or a corner which is known, as
    none of their corners could be moved there (`left`)."""

    moved: int
    left: int


def branches_on(at: Floats, triangles: Indices, field: Branches, frame: Frame, cube: Floats) -> Ints:
    """The branches (n, 3) that vertices (n, 3) of a surface's `triangles` (k, 3) are on: one each; else, and of other
    vertices, -1. `cube` (n,) is how large cubes are there, in mm."""
    some = np.unique(triangles)
    on = np.full((len(at), 3), -1)
    on[some, 0] = branch_of(frame.before_ends(at[some], INSIDE), field, cube[some]) if field.count else 0
    return on


def sharpen(
    at: Floats, tets: Indices, around: Stars, triangles: Indices, on: Ints, free: Flags, field: Branches, cube: Floats
) -> Sharpened:
    """Move vertices (n, 3), in place, of the surface that `triangles` (k, 3) make onto its rims, and add to the
    branches (n, 3) that they are `on`. Each moves along the axes that are `free` (n, 3); `cube` (n,) is how large
    cubes are there, in mm."""
    inner: Flags = np.asarray((on < 0).all(axis=1) & free.all(axis=1))
    total = left = 0
    least = FIRST
    again, mixed = np.ones(len(at), np.bool_), triangles
    for turn in range(ROUNDS + 1):
        tell(turn, ROUNDS + 1)
        mixed = mixed[common(on, mixed) < 0]
        vertex, branch = _wanted(mixed, on, free)
        branches = np.concatenate([on[vertex], branch[:, None]], axis=1)
        branches = np.sort(branches, axis=1)[:, :0:-1]  # three at most, those that are none last
        to, sure = meet(at[vertex], branches, free[vertex].astype(np.float64), field, cube[vertex], REACH)
        vertex, branch, to = vertex[sure], branch[sure], to[sure]
        left = _left(mixed, on, vertex, branch)
        if not left or turn == ROUNDS:
            break
        order = np.argsort(np.linalg.norm(to - at[vertex], axis=1), kind="stable")
        first, beside = _around(mixed, len(at))
        went = np.zeros(len(at), np.bool_)
        done = onto_branches(
            at, tets, around.start, around.of, inner, on, mixed, first, beside, vertex[order], branch[order], to[order],
            np.cos(np.radians(least)), WAYS, ROOM * cube, again, went,
        )  # fmt: skip
        total, again = total + done, went
        if done < FEW * left:
            if least == LEAST:
                break
            least = LEAST
            again = np.ones(len(at), np.bool_)
    improve(at, tets, around.start, around.of, inner, np.cos(np.radians(POOR)), WAYS, ROOM * cube, ROUNDS)
    return Sharpened(total, left)


def common(on: Ints, triangles: Indices) -> Ints:
    """A branch that all corners of triangles are on; -1 where there is none."""
    found = np.full(len(triangles), -1)
    for k in range(3):
        mine = on[triangles[:, 0], k]
        all_on = (mine >= 0) & (found < 0)
        for c in (1, 2):
            all_on &= (on[triangles[:, c]] == mine[:, None]).any(axis=1)
        found[all_on] = mine[all_on]
    return found


def _left(mixed: Indices, on: Ints, vertex: Ints, branch: Ints) -> int:
    """How many triangles still cut a rim or a corner off: those of which a corner could be on it, as vertices could on
    these branches."""
    known = vertex << 32 | branch
    either = np.zeros(len(mixed), np.bool_)
    for one in range(3):
        for other in (one - 1, one - 2):
            for k in range(3):
                wanted = on[mixed[:, other], k]
                either |= (wanted >= 0) & np.isin(mixed[:, one].astype(np.int64) << 32 | wanted, known)
    return int(either.sum())


def _wanted(mixed: Indices, on: Ints, free: Flags) -> tuple[Ints, Ints]:
    """The vertices that may be moved onto another branch, and these branches: those of other corners of triangles."""
    turned = np.concatenate([mixed[:, [a, b]] for a in range(3) for b in range(3) if a != b])
    vertex = np.repeat(turned[:, 0], 3).astype(np.int64)
    branch = on[turned[:, 1]].ravel()
    room = free[vertex].sum(axis=1) - (on[vertex] >= 0).sum(axis=1) > 0
    good = (branch >= 0) & room & ~(on[vertex] == branch[:, None]).any(axis=1)
    pairs = np.unique(np.stack([vertex[good], branch[good]], axis=1), axis=0)
    return pairs[:, 0], pairs[:, 1]


def _around(triangles: Indices, count: int) -> tuple[Ints, Ints]:
    """The triangles of each vertex: those of v are `of[start[v] : start[v + 1]]`."""
    vertex = triangles.ravel()
    order = np.argsort(vertex, kind="stable")
    return np.searchsorted(vertex[order], np.arange(count + 1)), order // 3
