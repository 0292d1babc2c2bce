"""A mesh whose vertices know which branches of the field they lie on, and whether its triangles keep to them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.rims import Branched, Flags, Floats, Ints, meet, unit

SLIM = 1e-3  # voxels: the least height of a triangle
FACING = 0.05  # the least cosine between a triangle and the surface that it is on
TURNS = 12
RINGS = 3  # of triangles round a turned one that may move with it


@dataclass(slots=True)
class Patched:
    """The mesh in work: `on` (n, 3) are the branches that a vertex lies on, one of them repeated if it has fewer.

    It may be a part of a larger mesh: the vertices that it shares with the rest are `fixed`.
    """

    at: Floats
    on: Ints
    faces: Ints
    fixed: Flags
    field: Branched
    voxel: float

    def add(self, points: Floats, on: Ints) -> Ints:
        """New vertices; their numbers."""
        first = len(self.at)
        self.at = np.concatenate([self.at, points])
        self.on = np.concatenate([self.on, on])
        self.fixed = np.concatenate([self.fixed, np.zeros(len(points), np.bool_)])
        return np.arange(first, len(self.at))


def several(on: Ints) -> Ints:
    """How many different branches there are in each row of (n, 3)."""
    ordered = np.sort(on, axis=1)
    count: Ints = 1 + (np.diff(ordered, axis=1) != 0).sum(axis=1)
    return count


def share(a: Ints, b: Ints) -> Flags:
    """Whether two sets of branches (n, 3) have one in common."""
    shared: Flags = (a[:, :, None] == b[:, None, :]).any(axis=(1, 2))
    return shared


def common(on: Ints, faces: Ints) -> Ints:
    """A branch that all corners of each triangle are on, or -1."""
    one, two, three = (on[faces[:, k]] for k in range(3))
    common = np.full(len(faces), -1, np.int64)
    for k in range(3):
        mine = one[:, k : k + 1]
        common = np.where((two == mine).any(axis=1) & (three == mine).any(axis=1), one[:, k], common)
    return common


def edges(faces: Ints) -> tuple[Ints, Ints]:
    """The ends (m, 2) of every edge, and the edges (k, 3) of each triangle: from corner i to the next."""
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    most = int(faces.max(initial=0)) + 1
    keys, of = np.unique(ends[:, 0] * most + ends[:, 1], return_inverse=True)
    return np.stack([keys // most, keys % most], axis=1), of.reshape(-1, 3)


def turned(mesh: Patched, faces: Ints) -> Flags:
    """The triangles (n, 3) on one branch that face away from its surface or vanish."""
    corners = mesh.at[faces]
    sides = corners[:, [1, 2, 0]] - corners
    area = np.cross(sides[:, 0], sides[:, 1])
    size = np.linalg.norm(area, axis=1)
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    branch = common(mesh.on, faces)
    wrong: Flags = (size <= SLIM * mesh.voxel * longest) & (branch >= 0)
    some = np.flatnonzero((branch >= 0) & ~wrong)
    outward = unit(mesh.field.held(corners[some].mean(axis=1), branch[some])[1])
    wrong[some] = np.einsum("ij,ij->i", area[some], outward) <= FACING * size[some]
    return wrong


def relax(mesh: Patched, faces: Ints, suspects: Ints) -> None:
    """Move vertices about until none of the `suspects`, rows of `faces`, is turned over, or no more can be mended.

    A vertex goes to the middle of its neighbours and back onto its surface; one on a rim to the middle of its two
    neighbours on the rim and back onto the rim. So they come to lie in order, as in the plane (Tutte 1963). Where that
    does not help (a wedge thinner than a voxel is frayed, and its rim runs to and fro) vertices go back.
    """
    wrong = faces[suspects[turned(mesh, faces[suspects])]]
    if not len(wrong):
        return
    here = around(faces, wrong, len(mesh.at), RINGS)
    inner, number = np.unique(faces[here], return_inverse=True)
    fixed = mesh.fixed.copy()
    fixed[faces[~here]] = True
    part = Patched(mesh.at[inner], mesh.on[inner], number.reshape(-1, 3), fixed[inner], mesh.field, mesh.voxel)
    _relax(part, mesh.at[inner])
    mesh.at[inner] = part.at


def _relax(mesh: Patched, start: Floats) -> None:
    """`relax` of a small mesh, whose vertices were at `start`."""
    faces, count = mesh.faces, len(mesh.at)
    before = turned(mesh, faces)
    wrong = before
    for _ in range(TURNS):
        moving = np.zeros(count, np.bool_)
        moving[faces[around(faces, faces[wrong], count, 1)]] = True
        moving &= ~mesh.fixed
        ends, _ = edges(faces[moving[faces].any(axis=1)])
        _step(mesh, np.concatenate([ends, ends[:, ::-1]]), moving)
        wrong = turned(mesh, faces)
        if not wrong.any():
            return
    back = around(faces, faces[wrong], count, 2)
    while back.any():
        at = np.unique(faces[back])
        mesh.at[at] = start[at]
        moved = (mesh.at != start).any(axis=1)
        back = turned(mesh, faces) & ~before & moved[faces].any(axis=1)


def around(faces: NDArray[np.signedinteger], some: NDArray[np.signedinteger], count: int, rings: int) -> Flags:
    """The triangles within some rings of the vertices `some`, of `count` in all."""
    reached = np.zeros(len(faces), np.bool_)
    for _ in range(rings):
        near = np.zeros(count, np.bool_)
        near[some] = True
        reached = np.asarray(near[faces].any(axis=1))
        some = faces[reached]
    return reached


def _step(mesh: Patched, ends: Ints, moving: Flags) -> None:
    """One step of the `moving` vertices towards the middle of their neighbours; `ends` are edges, both ways round."""
    ends = ends[moving[ends[:, 0]]]
    mine, other = ends.T
    of = several(mesh.on[mine])
    for many in (1, 2):
        some = of == many
        if many == 1:
            some &= (mesh.on[other] == mesh.on[mine, :1]).any(axis=1)
        else:
            both = np.sort(mesh.on[mine], axis=1)[:, [0, 2]]
            some &= (mesh.on[other][:, :, None] == both[:, None, :]).any(axis=1).all(axis=1)
        a, b = mine[some], other[some]
        count = np.bincount(a, minlength=len(mesh.at))
        who = np.flatnonzero(count == 2 if many == 2 else count > 0)
        total = np.stack([np.bincount(a, mesh.at[b, k], len(mesh.at)) for k in range(3)], axis=1)
        target = (mesh.at[who] + total[who] / count[who][:, None]) / 2
        if many == 2:
            place, sure = meet(target, np.sort(mesh.on[who], axis=1)[:, [0, 2]], mesh.field, mesh.voxel, 1.0)
        else:
            place, sure = meet(target, mesh.on[who, :1], mesh.field, mesh.voxel, 1.0)
        mesh.at[who[sure]] = place[sure]
