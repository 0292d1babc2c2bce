"""Rims made sharp: the chamfers that marching cubes leaves are cut where the surfaces on either side meet.

Where a field is the max or min of others its surface has rims, and marching cubes cuts them off: an edge of the mesh
runs from one surface to the other. Such an edge is split at the point where the two tangent planes meet, and a
triangle with two (three) such edges is split so that the rim (the corner) becomes edges of the mesh (Attene,
Falcidieno, Rossignac & Spagnuolo 2003, "Edge-Sharpener"). An edge is split for both its triangles, so a closed mesh
stays closed.

A rim is told from a curved surface by coming nearer: the tangent planes are taken again a quarter as far from where
they met, three times over. At a rim the angle between them stays; on a smooth surface it goes to nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.grid import Point
from porelang.mesh.project import Floats, Slope, on_caps, onto
from porelang.mesh.surface import Surface

Ints = NDArray[np.int64]
SUSPECT = np.cos(np.radians(25))  # normals of neighbours that differ by more may have a rim between them
RIM = np.cos(np.radians(12))  # and have one if close to it they still differ by this
NEARER = 0.25
ROUNDS = 3
SHORTEST = 0.02  # voxels: what is cut off by a shorter edge nobody sees


@dataclass(frozen=True, slots=True)
class Sharpened:
    """A surface with sharp rims: `rims` counts the edges that were split, `corners` the triangles."""

    surface: Surface
    rims: int
    corners: int


def sharpen(surface: Surface, slope: Slope, voxel: float, box: tuple[Point, Point] | None = None) -> Sharpened:
    """Cut a surface whose vertices lie on the field where the surfaces on either side of a rim meet.

    `voxel` (mm) is the grid's spacing, `box` the one whose caps are to stay flat.
    """
    at, faces = surface.vertices, surface.faces
    normal = _unit(slope(at)[1])
    caps = on_caps(at, box)
    a, b, of = _edges(faces)
    along = at[b] - at[a]
    length = np.linalg.norm(along, axis=1)
    bent = np.einsum("ij,ij->i", normal[a], normal[b]) < SUSPECT
    chosen = np.flatnonzero(bent & (length > SHORTEST * voxel))
    ends = np.stack([a[chosen], b[chosen]], axis=1)
    point, sure = _meet(at[ends], slope, voxel, np.logical_and(caps[a[chosen]], caps[b[chosen]]))
    chosen, point = chosen[sure], point[sure]
    if not len(chosen):
        return Sharpened(surface, 0, 0)
    split = np.full(len(a), -1, np.int64)
    split[chosen] = len(at) + np.arange(len(chosen))
    everything = np.concatenate([at, point])
    while True:
        pieces = _cut(faces, split[of])
        wrong = _turned(pieces, everything, normal, len(at), voxel)
        if not len(wrong):
            break
        bad = np.unique(of[wrong])
        bad = bad[split[bad] >= 0]
        if not len(bad):
            break
        split[bad] = -1
    everything, corners = _corners(pieces, everything, faces, slope, voxel, normal)
    used = np.unique(np.concatenate([p.triangles.ravel() for p in pieces]))
    number = np.zeros(len(everything), np.int32)
    number[used] = np.arange(len(used))
    made = np.concatenate([p.triangles.reshape(-1, 3) for p in pieces])
    return Sharpened(Surface(everything[used], number[made]), int((split >= 0).sum()), corners)


def _unit(vectors: Floats) -> Floats:
    with np.errstate(all="ignore"):
        unit = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.where(np.isfinite(unit), unit, 0.0)


def _edges(faces: NDArray[np.int32]) -> tuple[Ints, Ints, Ints]:
    """The two ends of every edge, and the edges (m, 3) of each triangle: from corner i to the next."""
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2).astype(np.int64), axis=1)
    most = int(faces.max()) + 1
    keys, of = np.unique(ends[:, 0] * most + ends[:, 1], return_inverse=True)
    return keys // most, keys % most, of.reshape(-1, 3)


def _meet(ends: Floats, slope: Slope, voxel: float, flat: NDArray[np.bool_]) -> tuple[Floats, NDArray[np.bool_]]:
    """Where the tangent planes at points (n, k, 3) meet, and whether there is a rim (k = 2) or a corner (k = 3) there.

    `flat` (n, 3) are the axes along which the result stays on a cap.
    """
    n, k = ends.shape[:2]
    near = ends
    middle = ends.mean(axis=1)
    point = middle
    fixed = np.eye(3)[None] * flat[:, :, None]
    sure = np.ones(n, np.bool_)
    for turn in range(ROUNDS + 1):
        if turn:
            near = point[:, None] + NEARER * (near - point[:, None])
            near = onto(near.reshape(-1, 3), slope, voxel, np.repeat(flat, k, axis=0)).reshape(n, k, 3)
        normal = _unit(slope(near.reshape(-1, 3))[1]).reshape(n, k, 3)
        centre = near.mean(axis=1)
        rows = np.concatenate([normal, fixed], axis=1)
        right = np.zeros(rows.shape[:2])
        right[:, :k] = np.einsum("nki,nki->nk", normal, near - centre[:, None])
        point = centre + np.einsum("nij,nj->ni", np.linalg.pinv(rows, rcond=0.05), right)
        strayed = np.linalg.norm(point - middle, axis=1) > voxel
        sure &= ~strayed
        point = np.where(strayed[:, None], middle, point)
    for i in range(k):
        for j in range(i):
            sure &= np.einsum("ni,ni->n", normal[:, i], normal[:, j]) < RIM
    if k == 3:  # three planes that share a line have no corner
        sure &= np.abs(np.linalg.det(normal)) > 0.05
    # A plane's foot is not yet the rim: the point counts only where the field says that it is on the surface.
    value, gradient = slope(point)
    with np.errstate(all="ignore"):
        sure &= np.abs(value) / np.linalg.norm(gradient, axis=1) < 0.05 * voxel
    return point, sure


@dataclass(slots=True)
class _Pieces:
    """What the triangles `of` (n,) with as many split edges become: (n, k, 3), and a corner whose side each is on."""

    of: Ints
    triangles: Ints
    side: Ints


def _cut(faces: NDArray[np.int32], split: Ints) -> list[_Pieces]:
    """Triangles for every pattern of split edges; `split` (m, 3) has the new vertex of each edge, or -1."""
    count = (split >= 0).sum(axis=1)
    out = []
    for many in range(4):
        of = np.flatnonzero(count == many)
        v, m = faces[of].astype(np.int64), split[of]
        if many in (1, 2):  # turned so that edge 0 alone is split, or alone is not
            first = ((m >= 0) == (many == 1)).argmax(axis=1)
            turn = (first[:, None] + np.arange(3)) % 3
            v, m = np.take_along_axis(v, turn, axis=1), np.take_along_axis(m, turn, axis=1)
        (a, b, c), (ab, bc, ca) = v.T, m.T
        rows: list[tuple[Ints, Ints, Ints, Ints]]
        if many == 0:
            rows = [(a, b, c, np.full_like(a, -1))]
        elif many == 1:
            rows = [(a, ab, c, np.full_like(a, -1)), (ab, b, c, np.full_like(a, -1))]
        elif many == 2:  # c lies beyond the rim from bc to ca
            rows = [(c, ca, bc, c), (ca, a, b, a), (ca, b, bc, b)]
        else:
            rows = [(ab, bc, ca, np.full_like(a, -1)), (a, ab, ca, a), (b, bc, ab, b), (c, ca, bc, c)]
        out.append(_Pieces(
            of,
            np.stack([np.stack(r[:3], axis=1) for r in rows], axis=1),
            np.stack([r[3] for r in rows], axis=1),
        ))
    return out


def _turned(pieces: list[_Pieces], at: Floats, normal: Floats, old: int, voxel: float) -> Ints:
    """The triangles of which a piece vanishes or faces away from the surface that it is on."""
    wrong = []
    for p in pieces[1:]:
        if not len(p.of):
            continue
        corners = at[p.triangles]
        area = np.cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0])
        size = np.linalg.norm(area, axis=-1)
        away = np.einsum("nki,nki->nk", area, normal[np.maximum(p.side, 0)]) <= 0.2 * size
        wrong.append(p.of[((size <= 1e-7 * voxel**2) | (away & (p.side >= 0))).any(axis=1)])
    return np.concatenate([np.zeros(0, np.int64), *wrong])


def _corners(
    pieces: list[_Pieces], at: Floats, faces: NDArray[np.int32], slope: Slope, voxel: float, normal: Floats
) -> tuple[Floats, int]:
    """Give the triangles with three split edges a vertex at the corner where three surfaces meet, if there is one."""
    three = pieces[3]
    if not len(three.of):
        return at, 0
    point, sure = _meet(at[faces[three.of]], slope, voxel, np.zeros((len(three.of), 3), np.bool_))
    ab, bc, ca = three.triangles[:, 0].T
    a, b, c = faces[three.of].T.astype(np.int64)
    k = len(at) + np.arange(len(three.of))
    six = [(a, ab, k, a), (ab, b, k, b), (b, bc, k, b), (bc, c, k, c), (c, ca, k, c), (ca, a, k, a)]
    made = _Pieces(
        three.of, np.stack([np.stack(r[:3], axis=1) for r in six], axis=1), np.stack([r[3] for r in six], axis=1)
    )
    at = np.concatenate([at, point])
    sure &= ~np.isin(three.of, _turned([made, made], at, normal, 0, voxel))
    pieces[3] = _Pieces(three.of[~sure], three.triangles[~sure], three.side[~sure])
    pieces.append(_Pieces(made.of[sure], made.triangles[sure], made.side[sure]))
    return at, int(sure.sum())
