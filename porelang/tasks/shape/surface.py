"""The surface of the body that a mesh means: holes closed, shells turned outwards, and nothing of what lies inside.

A place is inside where the surface winds round it (Jacobson et al., Robust inside-outside segmentation using
generalized winding numbers, 2013), either way: shells that overlap are one body, and what of them lies within it is no
surface.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

Points = NDArray[np.float64]
Faces = NDArray[np.int64]
Mask = NDArray[np.bool_]

AT_ONCE = 1 << 18  # places between two looks at the parent
#: How far from the surface, in cells, it is asked on which side a place lies.
BESIDE = 1e-3
#: Where shells cross, the surface is told from what lies inside to so much of a cell.
SEAM = 1 / 32


@dataclass(frozen=True, slots=True)
class Closed:
    """A mesh without an open edge: corners (n, 3) in mm, triangles (m, 3), and of each hole that was closed the number
    of its edges and its middle, the largest first."""

    vertices: Points
    faces: Faces
    holes: list[tuple[int, Points]]

    def winds_round(self, places: Points, told: Callable[[int, int], None]) -> Mask:
        """Whether places (n, 3) are inside (Barill et al., Fast winding numbers for soups and clouds, 2018)."""
        found = np.zeros(len(places), np.bool_)
        for some in slices(len(places)):
            told(some.start, len(places))
            found[some] = np.abs(igl.fast_winding_number(self.vertices, self.faces, places[some])) > 0.5
        return found


def closed(vertices: Points, faces: Faces) -> Closed:
    """A mesh with each hole closed by a fan of triangles from the middle of its rim, which is exact where it is flat.

    So sign and distance are of one surface, also across a hole.
    """
    faces = _turned_alike(faces)
    edges = _rim(faces)
    if not len(edges):
        return Closed(vertices, _outward(vertices, faces), [])
    corners, ends = np.unique(edges, return_inverse=True)
    ends = ends.reshape(-1, 2)
    count, hole = _connected(ends, len(corners))
    lengths = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    of_edge = hole[ends[:, 0]]
    halves = 0.5 * (vertices[edges[:, 0]] + vertices[edges[:, 1]])
    whole = np.bincount(of_edge, lengths, count)
    middles = np.stack([np.bincount(of_edge, lengths * halves[:, k], count) / whole for k in range(3)], axis=1)
    fans = np.stack([edges[:, 1], edges[:, 0], len(vertices) + of_edge], axis=1)
    sizes = np.bincount(of_edge, minlength=count)
    holes = [(int(sizes[i]), middles[i]) for i in np.argsort(-sizes, kind="stable")]
    vertices, faces = np.concatenate([vertices, middles]), np.concatenate([faces, fans])
    return Closed(vertices, _outward(vertices, faces), holes)


def _rim(faces: Faces) -> Faces:
    """The directed edges (n, 2) which the triangles pass more often one way than the other: those of holes."""
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    ends = np.sort(edges, axis=1)
    names, numbers = np.unique(ends[:, 0] * (faces.max() + 1) + ends[:, 1], return_inverse=True)
    passes = np.bincount(numbers, np.where(edges[:, 0] < edges[:, 1], 1.0, -1.0), len(names)).astype(np.int64)
    pairs = np.stack(np.divmod(names, faces.max() + 1), axis=1)
    forth, back = np.repeat(pairs, np.maximum(passes, 0), axis=0), np.repeat(pairs, np.maximum(-passes, 0), axis=0)
    return np.concatenate([forth, back[:, ::-1]])


def _turned_alike(faces: Faces) -> Faces:
    """The triangles, turned so that neighbours agree where two of them pass their common edge the same way."""
    edges = np.sort(_rim(faces), axis=1)
    _, count = np.unique(edges, axis=0, return_counts=True)
    return np.ascontiguousarray(igl.bfs_orient(faces)[0]) if (count > 1).any() else faces


def _outward(vertices: Points, faces: Faces) -> Faces:
    """The triangles of a closed mesh, with all shells turned outwards but cavities: those that lie within others, and
    are turned against them in the file."""
    count, of_corner = _connected(faces[:, [0, 1, 1, 2]].reshape(-1, 2), len(vertices))
    of_face = of_corner[faces[:, 0]]
    a, b, c = np.moveaxis(vertices[faces] - vertices.mean(axis=0), 1, 0)
    inward = np.bincount(of_face, np.einsum("ij,ij->i", a, np.cross(b, c)), count) < 0
    if not inward.any():
        return faces
    outward = _flipped(faces, inward[of_face])
    contained = np.ones(count, np.bool_)
    against = np.zeros(count, np.bool_)
    for places in _beyond_ends(vertices, faces, of_corner, count):
        contained &= np.abs(igl.fast_winding_number(vertices, outward, places)) > 0.5
        as_given = np.rint(igl.fast_winding_number(vertices, faces, places))
        against |= as_given * np.where(inward, -1, 1) < 0
    return _flipped(outward, (contained & against)[of_face])


def _flipped(faces: Faces, which: Mask) -> Faces:
    return np.ascontiguousarray(np.where(which[:, None], faces[:, ::-1], faces))


def _beyond_ends(vertices: Points, faces: Faces, of_corner: NDArray[np.int32], count: int) -> Iterator[Points]:
    """A place (count, 3) just beyond each shell, at either end of it along each axis."""
    used = np.unique(faces)
    little = 1e-6 * np.ptp(vertices, axis=0).max()
    for axis in range(3):
        for side in (-1, 1):
            ends = used[np.argsort(-side * vertices[used, axis])]
            shells, first = np.unique(of_corner[ends], return_index=True)
            places = np.zeros((count, 3))  # some corners are nobody's, and no shell
            places[shells] = vertices[ends[first]]
            places[:, axis] += side * little
            yield places


def _connected(pairs: Faces, count: int) -> tuple[int, NDArray[np.int32]]:
    """How many groups links (n, 2) make of so many things, and the group of each."""
    linked = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (count, count))
    return connected_components(linked, directed=False)  # type: ignore[no-any-return]  # SciPy has no types


def boundary(mesh: Closed, h: float, told: Callable[[int, int], None]) -> Points:
    """The triangles (n, 3, 3) of a mesh that have the inside on one side alone, those that cross others cut to bits.

    `h` is the size of a cell, in mm. Where shells cross, what is left out or in wrongly is smaller than SEAM cells.
    """
    whole: Points = mesh.vertices[mesh.faces]
    area = np.linalg.norm(_normals(whole), axis=1)
    whole = whole[area > 1e-14 * np.ptp(mesh.vertices, axis=0).max() ** 2]
    size = 2 * h
    bits, owner = halved(whole, np.arange(len(whole)), size)
    parts = _parts(mesh, bits, h, told)
    if parts.all():
        return whole
    mixed = np.zeros(len(whole), np.bool_)
    mixed[owner[~parts | _beside_others(bits, parts)]] = True  # of all others every bit is surface
    known = [whole[~mixed]]
    some = mixed[owner]
    bits, parts = bits[some], parts[some]
    while len(bits) and size > SEAM * h:
        crossed = _beside_others(bits, parts)
        known.append(bits[~crossed & parts])
        size /= 2
        bits, _ = halved(bits[crossed], np.arange(int(crossed.sum())), size)
        parts = _parts(mesh, bits, h, told)
    out: Points = np.concatenate([*known, bits[parts]])
    return out


def _normals(triangles: Points) -> Points:
    a, b, c = np.moveaxis(triangles, 1, 0)
    return np.asarray(np.cross(b - a, c - a))


def _parts(mesh: Closed, triangles: Points, h: float, told: Callable[[int, int], None]) -> Mask:
    """Whether triangles part the inside from the outside, in their middles."""
    normals = _normals(triangles)
    away = BESIDE * h * normals / np.linalg.norm(normals, axis=1, keepdims=True)
    middle = triangles.mean(axis=1)
    found: Mask = mesh.winds_round(middle + away, told) != mesh.winds_round(middle - away, told)
    return found


def _beside_others(triangles: Points, parts: Mask) -> Mask:
    """Which triangles may touch one of the other kind: their middles are no farther apart than both reach."""
    middle = triangles.mean(axis=1)
    size = np.linalg.norm(triangles - middle[:, None], axis=2).max(axis=1)
    near = np.ones(len(middle), np.bool_)
    for kind in (True, False):
        here, others = parts == kind, parts != kind
        if not others.any():
            return np.zeros(len(middle), np.bool_)
        away, _ = cKDTree(middle[others]).query(middle[here])
        near[here] = away <= size[here] + size[others].max()
    return near


def halved(triangles: Points, owner: Faces, size: float) -> tuple[Points, Faces]:
    """Triangles cut along their longest sides until none is longer than `size`, each with the owner that it had."""
    done: list[tuple[Points, Faces]] = []
    while True:
        sides = np.linalg.norm(triangles - np.roll(triangles, -1, axis=1), axis=2)
        small = sides.max(axis=1) <= size
        done.append((triangles[small], owner[small]))
        if small.all():
            return np.concatenate([t for t, _ in done]), np.concatenate([o for _, o in done])
        longest, triangles, owner = sides.argmax(axis=1)[~small], triangles[~small], owner[~small]
        row = np.arange(len(triangles))
        a, b, c = (triangles[row, (longest + k) % 3] for k in range(3))
        half = 0.5 * (a + b)
        triangles = np.concatenate([np.stack([a, half, c], axis=1), np.stack([half, b, c], axis=1)])
        owner = np.concatenate([owner, owner])


def slices(count: int) -> Iterator[slice]:
    for i in range(0, count, AT_ONCE):
        yield slice(i, min(i + AT_ONCE, count))
