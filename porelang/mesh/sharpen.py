"""Rims made sharp: edges of the mesh that run from one branch of the field to another are cut where the two meet.

Where a field is the max or min of others its surface has rims, and marching cubes cuts them off: its vertices lie on
one surface or the other, and an edge of the mesh crosses the rim unseen. The field tells which branch a vertex is on,
so such an edge is known, not guessed. It is split at its point of the rim, and a triangle with two such edges is split
so that the rim becomes an edge of the mesh; where three branches come together, a vertex is put on their corner. An
edge is split for both its triangles, so a closed mesh stays closed. (Cutting chamfers after marching cubes is Attene,
Falcidieno, Rossignac & Spagnuolo 2003, "Edge-Sharpener"; they know no field.)

A vertex that is nearly on a rim is moved onto it first, lest the triangles beside it be needles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.crossed import crossed
from porelang.mesh.crossing import crossings
from porelang.mesh.layers import Layers
from porelang.mesh.merge import merge
from porelang.mesh.patched import Patched, around, common, edges, relax, several, share, turned
from porelang.mesh.project import LEAST, distances
from porelang.mesh.rims import Branched, Flags, Floats, Ints, branch_of, meet, off_surface, on_surface, rim, unit
from porelang.mesh.surface import Surface
from porelang.progress import tell

ROUNDS = 3
RINGS = 3  # of triangles round the rims that may be moved
ON = 1e-6  # voxels: what is nearer than this counts as on the surface
NEARLY = 0.2  # voxels: a vertex that is closer to a rim is moved onto it


@dataclass(frozen=True, slots=True)
class Sharpened:
    """A surface with sharp rims: `rims` counts its edges on them, `corners` the vertices where three surfaces meet.

    `off` is the largest distance (mm, f over its slope) of a vertex from the field, `kept` counts those not on it.
    """

    surface: Surface
    rims: int
    corners: int
    off: float
    kept: int


def sharpen(
    surface: Surface,
    raw: Floats,
    layers: Layers,
    field: Branched,
) -> Sharpened:
    """Cut a surface whose vertices lie on the field where branches of the field meet.

    `raw` are the same vertices as marching cubes placed them in `layers`.
    """
    if not field.count:
        off = np.minimum(distances(surface.vertices, field.slope), layers.grid.spacing)
        return Sharpened(surface, 0, 0, float(off.max(initial=0.0)), int((off > LEAST * layers.grid.spacing).sum()))
    at, faces, voxel = surface.vertices, surface.faces, layers.grid.spacing
    branch = branch_of(at, field, voxel)
    seeds = np.flatnonzero(~on_surface(at, branch, field, voxel) | _at_rims(branch, faces))
    here = around(faces, seeds, len(at), RINGS)
    inner, local = np.unique(faces[here], return_inverse=True)
    moved, sure = crossings(raw[inner], layers, field.value)
    moved[~sure] = at[inner[~sure]]
    branch = branch_of(moved, field, voxel)
    fixed = np.zeros(len(at), np.bool_)
    fixed[faces[~here]] = True
    fixed = fixed[inner]
    moved[fixed] = at[inner[fixed]]
    mesh = Patched(moved, np.repeat(branch[:, None], 3, axis=1), local.reshape(-1, 3), fixed, field, voxel)
    _land(mesh, np.flatnonzero(~fixed & ~on_surface(moved, branch, field, voxel)))
    for turn in range(ROUNDS):
        tell(turn, ROUNDS)
        _snap(mesh)
        if not _cut(mesh):
            break
    merge(mesh)
    number = np.concatenate([inner, len(at) + np.arange(len(mesh.at) - len(inner))])
    everything = np.concatenate([at, mesh.at[len(inner) :]])
    everything[inner] = mesh.at[: len(inner)]
    made = np.concatenate([faces[~here], number[mesh.faces]])
    used = np.zeros(len(everything), np.bool_)
    used[made] = True
    renumber = np.cumsum(used, dtype=np.int32) - np.int32(1)
    sharp = Surface(everything[used], renumber[made])
    return _told(mesh, sharp, field, voxel)


def _told(mesh: Patched, surface: Surface, field: Branched, voxel: float) -> Sharpened:
    """The surface with what is to be said of it."""
    many = several(mesh.on)
    ends, _ = edges(mesh.faces[(many[mesh.faces] > 1).sum(axis=1) > 1])
    a, b = mesh.on[ends[:, 0]], mesh.on[ends[:, 1]]
    shared = np.where((a[:, :, None] == b[:, None, :]).any(axis=2), a, -1)
    rims = int((several(shared) - (shared == -1).any(axis=1) > 1).sum())
    at = surface.vertices
    off = off_surface(at, branch_of(at, field, voxel), field, voxel)
    off = np.minimum(np.nan_to_num(off, posinf=0.0), voxel)  # without a slope it says nothing: a cell is no larger
    corners = int((many[np.unique(mesh.faces)] == 3).sum())
    return Sharpened(surface, rims, corners, float(off.max(initial=0.0)), int((off > ON * voxel).sum()))


def _at_rims(branch: Ints, faces: NDArray[np.int32]) -> Flags:
    """The vertices of triangles whose corners are not on one branch."""
    at = np.zeros(len(branch), np.bool_)
    a, b, c = (branch[faces[:, k]] for k in range(3))
    at[faces[(a != b) | (b != c)]] = True
    return at


def _mixed(mesh: Patched) -> Ints:
    """The triangles that are on no branch as a whole."""
    first = mesh.on[:, 0][mesh.faces]
    some = np.flatnonzero((first != first[:, :1]).any(axis=1))
    return some[common(mesh.on, mesh.faces[some]) < 0]


def _land(mesh: Patched, off: Ints) -> None:
    """Bring the vertices `off` the field onto their branches."""
    place, sure = meet(mesh.at[off], mesh.on[off, :1], mesh.field, mesh.voxel, 1.0)
    moved = off[sure]
    mesh.at[moved] = place[sure]
    relax(mesh, mesh.faces, np.arange(len(mesh.faces)))


def _snap(mesh: Patched) -> None:
    """Move vertices that are nearly on a rim onto it, and those on a rim that are nearly on a corner onto that."""
    ends, _ = edges(mesh.faces[_mixed(mesh)])
    mine, other = np.concatenate([ends, ends[:, ::-1]]).T
    # Each vertex with each branch of its neighbours that it is not on, once.
    pairs = np.concatenate([np.stack([mine, mesh.on[other, k]], axis=1) for k in range(3)])
    pairs = np.unique(pairs[~mesh.fixed[pairs[:, 0]] & (mesh.on[pairs[:, 0]] != pairs[:, 1:]).all(axis=1)], axis=0)
    vertex = pairs[:, 0]
    many = several(mesh.on[vertex])
    both = np.sort(mesh.on[vertex], axis=1)
    foot, sure = mesh.at[vertex].copy(), np.zeros(len(pairs), np.bool_)
    on = np.repeat(pairs[:, 1:], 3, axis=1)
    on[:, 0], on[many == 2, 1] = both[:, 0], both[many == 2, 2]
    for k in (1, 2):
        some = np.flatnonzero(many == k)
        branches = on[some] if k == 2 else on[some, :2]
        foot[some], sure[some] = meet(foot[some], branches, mesh.field, mesh.voxel, NEARLY)
    away = np.linalg.norm(foot - mesh.at[vertex], axis=1)
    close = np.flatnonzero(sure)
    close = close[np.lexsort((away[close], vertex[close]))]
    close = close[np.unique(vertex[close], return_index=True)[1]]
    vertex = vertex[close]
    old = mesh.at[vertex].copy(), mesh.on[vertex].copy()
    mesh.at[vertex], mesh.on[vertex] = foot[close], on[close]
    which = np.full(len(mesh.at), -1, np.int64)
    which[vertex] = np.arange(len(vertex))
    relax(mesh, mesh.faces, np.flatnonzero((which[mesh.faces] >= 0).any(axis=1)))
    while True:  # what is turned over still goes back; so does what lies on one rim with its neighbours
        touched = np.flatnonzero((which[mesh.faces] >= 0).any(axis=1))
        faces = mesh.faces[touched]
        back = np.unique(which[faces[turned(mesh, faces)]])
        back = back[back >= 0]
        if not len(back):
            back = np.unique(which[mesh.faces[crossed(Surface(mesh.at, mesh.faces.astype(np.int32)), touched)]])
            back = back[back >= 0]
        if not len(back):
            break
        mesh.at[vertex[back]], mesh.on[vertex[back]] = old[0][back], old[1][back]
        which[vertex[back]] = -1


def _points(mesh: Patched, ends: Ints) -> tuple[Floats, Ints, Flags]:
    """Where edges (m, 2) between branches are to be split, what each such point is on, and which were found."""
    point = np.zeros((len(ends), 3))
    on = np.zeros((len(ends), 3), np.int64)
    found = np.zeros(len(ends), np.bool_)
    for i in range(3):
        for j in range(3):
            branches = np.stack([mesh.on[ends[:, 0], i], mesh.on[ends[:, 1], j]], axis=1)
            todo = np.flatnonzero(~found)
            if i or j:  # only what was not tried yet
                again = (mesh.on[ends[todo, 0], :i] == branches[todo, :1]).any(axis=1)
                again |= (mesh.on[ends[todo, 1], :j] == branches[todo, 1:]).any(axis=1)
                todo = todo[~again]
            if not len(todo):
                continue
            place, sure = rim(mesh.at[ends[todo]], branches[todo], mesh.field, mesh.voxel)
            good = todo[sure]
            point[good], on[good], found[good] = place[sure], branches[good][:, [0, 1, 1]], True
            point[todo[~sure]] = place[~sure]
    # Two branches that do not meet on the part have a third between them: the one that is above them where they would.
    lost = np.flatnonzero(~found)
    middle, third = mesh.at[ends[lost]].mean(axis=1), mesh.field.of(point[lost])
    place, sure = meet(middle, third[:, None], mesh.field, mesh.voxel, 1.0)
    third = branch_of(place, mesh.field, mesh.voxel)
    sure &= ~((mesh.on[ends[lost]] == third[:, None, None]).any(axis=(1, 2)))
    good = lost[sure]
    point[good], on[good], found[good] = place[sure], third[sure, None], True
    return point, on, found


def _cut(mesh: Patched) -> bool:
    """Split the edges that cross a rim, and the triangles that hold a corner; whether any was."""
    mixed = _mixed(mesh)
    if not len(mixed):
        return False
    ends, of = edges(mesh.faces[mixed])
    crossing = np.flatnonzero(~share(mesh.on[ends[:, 0]], mesh.on[ends[:, 1]]) & ~mesh.fixed[ends].all(axis=1))
    point, on, found = _points(mesh, ends[crossing])
    split = np.full(len(ends), -1, np.int64)
    split[crossing[found]] = mesh.add(point[found], on[found])
    # A split edge is split for all its triangles, also one that is on a branch as a whole: there are none, as its ends
    # share no branch.
    faces = mesh.faces[mixed]
    rest = np.delete(mesh.faces, mixed, axis=0)
    while True:
        parts, whose = _parts(mesh, faces, split[of])
        relax(mesh, np.concatenate([parts, rest]), np.arange(len(parts) + len(rest)))
        bad = _split_of(whose, turned(mesh, parts), of, split)
        if not len(bad):  # nor may the mesh run through itself, as it would in the tips of wedges thinner than a voxel
            whole = Surface(mesh.at, np.concatenate([parts, rest]).astype(np.int32))
            bad = _split_of(whose, crossed(whole, np.arange(len(parts)))[: len(parts)], of, split)
        if not len(bad):
            break
        split[bad] = -1
    parts, corners = _corners(mesh, parts, rest)
    mesh.faces = np.concatenate([rest, parts])
    return bool((split >= 0).any()) or corners > 0


def _split_of(whose: Ints, wrong: Flags, of: Ints, split: Ints) -> Ints:
    """The split edges of the triangles whose `parts` are `wrong`."""
    bad = np.unique(of[np.unique(whose[wrong])])
    found: Ints = bad[split[bad] >= 0]
    return found


def _parts(mesh: Patched, faces: Ints, split: Ints) -> tuple[Ints, Ints]:
    """The triangles that `faces` (n, 3) become and which each was, `split` (n, 3) being the new vertex of each edge."""
    count = (split >= 0).sum(axis=1)
    parts: list[Ints] = []
    whose: list[Ints] = []
    for many in range(4):
        of = np.flatnonzero(count == many)
        v, m = faces[of], split[of]
        if many in (1, 2):  # turned so that edge 0 alone is split, or alone is not
            first = ((m >= 0) == (many == 1)).argmax(axis=1)
            turn = (first[:, None] + np.arange(3)) % 3
            v, m = np.take_along_axis(v, turn, axis=1), np.take_along_axis(m, turn, axis=1)
        (a, b, c), (ab, bc, ca) = v.T, m.T
        match many:
            case 0:
                rows = [(a, b, c)]
            case 1:
                rows = [(a, ab, c), (ab, b, c)]
            case 2:  # c lies beyond the rim from bc to ca; the rest is a quadrilateral
                flip = _better(mesh, np.stack([ca, a, b, bc], axis=1))
                rows = [(c, ca, bc), (a, b, np.where(flip, bc, ca)), (np.where(flip, a, b), bc, ca)]
            case _:
                rows = [(ab, bc, ca), (a, ab, ca), (b, bc, ab), (c, ca, bc)]
        parts += [np.stack(r, axis=1) for r in rows]
        whose += [of] * len(rows)
    return np.concatenate(parts), np.concatenate(whose)


def _better(mesh: Patched, four: Ints) -> Flags:
    """Which quadrilaterals (n, 4) are better cut from corner 1 to 3 than from 0 to 2: their worse half is larger."""
    at = mesh.at[four]

    def worst(one: list[int], other: list[int]) -> Floats:
        normals = [np.cross(at[:, k[1]] - at[:, k[0]], at[:, k[2]] - at[:, k[0]]) for k in (one, other)]
        alike = np.einsum("ij,ij->i", unit(normals[0]), unit(normals[1]))
        sizes = np.minimum(*(np.linalg.norm(n, axis=1) for n in normals))
        worse: Floats = np.where(alike > 0, sizes, alike)
        return worse

    better: Flags = worst([0, 1, 3], [1, 2, 3]) > worst([0, 1, 2], [0, 2, 3])
    return better


def _corners(mesh: Patched, faces: Ints, rest: Ints) -> tuple[Ints, int]:
    """Give the triangles whose corners are on three branches, no two of them on one, a vertex where the three meet."""
    some = np.flatnonzero(common(mesh.on, faces) < 0)
    all_on = np.sort(mesh.on[faces[some]].reshape(-1, 9), axis=1)
    new = np.concatenate([np.ones((len(some), 1), np.bool_), np.diff(all_on, axis=1) != 0], axis=1)
    three = new.sum(axis=1) == 3
    some, branches = some[three], all_on[three][new[three]].reshape(-1, 3)
    point, sure = meet(mesh.at[faces[some]].mean(axis=1), branches, mesh.field, mesh.voxel)
    some = some[sure]
    tip = mesh.add(point[sure], branches[sure])
    a, b, c = faces[some].T
    made = np.stack([np.stack(r, axis=1) for r in ((a, b, tip), (b, c, tip), (c, a, tip))], axis=1)
    good: Flags = np.asarray(~turned(mesh, made.reshape(-1, 3)).reshape(-1, 3).any(axis=1))
    while True:
        kept = np.concatenate([np.delete(faces, some[good], axis=0), made[good].reshape(-1, 3)])
        tips = np.arange(len(kept) - 3 * int(good.sum()), len(kept))
        whole = Surface(mesh.at, np.concatenate([kept, rest]).astype(np.int32))
        through = crossed(whole, tips)[tips].reshape(-1, 3).any(axis=1)
        if not through.any():
            return kept, len(tips) // 3
        good = good & ~np.isin(np.arange(len(good)), np.flatnonzero(good)[through])
