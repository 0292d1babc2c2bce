"""The surface of the body that a mesh means: holes closed, shells turned outwards, and nothing of what lies inside.

A place is inside where the surface winds round it (Jacobson et al., Robust inside-outside segmentation using
generalized winding numbers, 2013), either way: shells that overlap are one body, and what of them lies within it is no
surface.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from porelang.tasks.shape.file import UnusableError
from porelang.tasks.shape.mend import ONE, Faces, Mask, Points, connected, distinct, loops, merged, rim, sewn

AT_ONCE = 1 << 18  # places between two looks at the parent
#: How far from the surface, in cells, it is asked on which side a place lies.
BESIDE = 1e-3
#: And from triangles that close a hole, in the end: those over a ragged rim fold over each other, and in a fold nearer
#: than that the outside is walled off by nothing.
FOLD = 1 / 8
#: Triangles whose corners lie within this share of the root of their area, off a plane, are a sheet; more sheets, or
#: shells within each other, than this are a soup.
THIN, SHEETS = 1e-3, 50
#: Where shells cross, the surface is told from what lies inside to so much of a cell.
SEAM = 1 / 32
#: The area of a rim in squares of its length, of which a circle has 1/6, below which it is a line up to rounding.
FLAT = 1e-6
#: Triangles of which one need not build a tree.
FEW = 2000
#: Of the sides of FEW triangles or more, the share beyond which those without a neighbour are no rims of holes: a scan
#: of which every tenth triangle is missing has a tenth, one of which half are missing a half.
TORN = 0.25
#: Bits that are looked at where shells cross, at most: 2 to 6 s of one core. Four times as many of a mesh of FEW.
MOST_BITS = 300_000
#: Bits of triangles that are halved down to a size, for a square of it.
PER_SQUARE = 4.0
#: At which nodes of the tree stand for their triangles, in their radii. Round a closed mesh numbers are whole, and come
#: out to 0.06; at 2, as is usual, to 0.005 in more than twice the time.
ACCURACY = 1.25
#: Where holes are looked at for triangles that fill them: places along each axis of a mesh, what is outside with fans
#: and inside without, and how many places have to say so.
_LOOKED, _OUT, _IN, _AGREED = 20, 0.25, 0.85, 3


@dataclass(frozen=True)
class Closed:
    """A mesh without an open edge: corners (n, 3) in mm, triangles (m, 3), and of each hole that was closed the number
    of its edges and its middle, the largest first.

    The last triangles are the `fans` over holes; they do not count (`loose`) for whether places are inside where other
    triangles fill the holes, which have no common edges with those round them. `sheets` enclosed nothing and are left
    out; `within` are the shells that lie within others, are turned as these are, and so no cavities.
    """

    vertices: Points
    faces: Faces
    holes: list[tuple[int, Points]]
    fans: int = 0
    loose: bool = False
    sheets: int = 0
    within: int = 0

    @cached_property
    def _tree(self) -> Any:
        tree = igl.FastWindingNumberBVH()
        tree.init(self.vertices, self.faces[: len(self.faces) - (self.fans if self.loose else 0)], 2)
        return tree

    def winds_round(self, places: Points, told: Callable[[int, int], None]) -> Mask:
        """Whether places (n, 3) are inside (Barill et al., Fast winding numbers for soups and clouds, 2018)."""
        found = np.zeros(len(places), np.bool_)
        for some in slices(len(places)):
            told(some.start, len(places))
            found[some] = np.abs(self.winding(places[some])) > 0.5
        return found

    def winding(self, places: Points) -> Points:
        """How often the surface winds round places (n, 3), to about 0.06."""
        return np.asarray(self._tree.winding_number(np.ascontiguousarray(places), ACCURACY))


def cut(mesh: Closed, size: float) -> Closed:
    """The same surface of triangles that are no longer than `size` mm, if there are many: between small ones a few that
    are long, as those of large holes, make the tree of all of them three times slower to ask."""
    if len(mesh.faces) < FEW:
        return mesh
    triangles, owner = halved(mesh.vertices[mesh.faces], np.arange(len(mesh.faces)), size)
    if len(triangles) == len(mesh.faces):
        return mesh
    triangles = triangles[np.argsort(owner, kind="stable")]
    fans = int((owner >= len(mesh.faces) - mesh.fans).sum())
    return replace(
        mesh, vertices=triangles.reshape(-1, 3), faces=np.arange(3 * len(triangles)).reshape(-1, 3), fans=fans
    )


def closed(vertices: Points, faces: Faces, gap: float = 0.0) -> Closed:
    """A mesh without triangles that stand twice, or nearly, with open edges sewn that are no farther than `gap` apart,
    in mm, and each hole closed by a fan of triangles from the middle of its rim, which is exact where it is flat.

    So sign and distance are of one surface, also across a hole. Errors: UnusableError, where there is none.
    """
    faces = sewn(vertices, _turned_alike(distinct(merged(vertices, faces, ONE * gap))), gap)
    edges = rim(faces)
    if not len(edges):
        return Closed(vertices, _outward(vertices, faces), [], within=_within(vertices, faces))
    flat, sheets = _flat(vertices, faces, edges)
    if sheets:
        faces = faces[~flat]
        edges = rim(faces)
    if not len(edges):
        return Closed(vertices, _outward(vertices, faces), [], sheets=sheets, within=_within(vertices, faces))
    if len(faces) > FEW and len(edges) > TORN * 3 * len(faces):
        raise UnusableError(
            "E143",
            f"is torn: of {3 * len(faces):,} sides of its triangles {len(edges):,} have no triangle beside them",
            "join and mend the triangles in the program that made them",
        )
    count, of_edge = loops(edges)
    lengths = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    halves = 0.5 * (vertices[edges[:, 0]] + vertices[edges[:, 1]])
    whole = np.bincount(of_edge, lengths, count)
    middles = np.stack([np.bincount(of_edge, lengths * halves[:, k], count) / whole for k in range(3)], axis=1)
    fans = np.stack([edges[:, 1], edges[:, 0], len(vertices) + of_edge], axis=1)
    corners = np.concatenate([vertices, middles])
    # A loop that goes there and back along a line is no hole: nothing is seen through it.
    area = np.bincount(of_edge, np.linalg.norm(_normals(corners[fans]), axis=1), count)
    seen = (area > FLAT * whole**2)[of_edge]
    holes = _holes(edges[seen], lengths[seen], halves[seen]) if seen.any() else []
    found = Closed(corners, _outward(corners, np.concatenate([faces, fans])), holes, len(fans), sheets=sheets)
    loose = Closed(corners, np.concatenate([faces, fans]), holes, len(fans), loose=True, sheets=sheets)
    return loose if _filled(found, loose, np.asarray(area[of_edge], np.float64), fans) else found


def _flat(vertices: Points, faces: Faces, edges: Faces) -> tuple[Mask, int]:
    """Which triangles are of sheets beside bodies, and how many sheets there are: groups with open edges that lie in a
    plane. None where all are, and where there are so many that they are the bits of something."""
    count, of_corner = connected(faces[:, [0, 1, 1, 2]].reshape(-1, 2), len(vertices))
    of_face, opened = of_corner[faces[:, 0]], np.zeros(count, np.bool_)
    opened[of_corner[edges[:, 0]]] = True
    normals = _normals(vertices[faces])
    sums = np.stack([np.bincount(of_face, normals[:, k], count) for k in range(3)], axis=1)
    ways = sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-300)
    height = np.einsum("ijk,ik->ij", vertices[faces], ways[of_face])
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(low, of_face, height.min(axis=1))
    np.maximum.at(high, of_face, height.max(axis=1))
    area = np.bincount(of_face, np.linalg.norm(normals, axis=1), count)
    flat = (opened & (high - low <= THIN * np.sqrt(area)))[of_face]
    sheets = len(np.unique(of_face[flat]))
    return flat, 0 if flat.all() or sheets > SHEETS else sheets


def _within(vertices: Points, faces: Faces) -> int:
    """How many shells of a closed mesh lie within others and are turned as these are: no cavities, as given."""
    _, of_corner = connected(faces[:, [0, 1, 1, 2]].reshape(-1, 2), len(vertices))
    of_face = of_corner[faces[:, 0]]
    shells = np.unique(of_face)
    if not 1 < len(shells) <= SHEETS:
        return 0
    parts = [faces[of_face == shell] for shell in shells]
    ends = np.array([(vertices[part].min(axis=(0, 1)), vertices[part].max(axis=(0, 1))) for part in parts])
    found = 0
    for part, (low, high) in zip(parts, ends, strict=True):
        around = np.flatnonzero((ends[:, 0] < low).all(axis=1) & (ends[:, 1] > high).all(axis=1))
        if not len(around):
            continue
        place = vertices[part[0, :1]]
        a, b, c = np.moveaxis(vertices[part] - place, 1, 0)
        volume = float(np.einsum("ij,ij->", a, np.cross(b, c)))
        others = np.ascontiguousarray(np.concatenate([parts[k] for k in around]))
        winds = float(igl.fast_winding_number(vertices, others, place)[0])
        found += abs(winds) > 0.5 and winds * volume > 0
    return found


def _filled(closed: Closed, loose: Closed, area: Points, fans: Faces) -> bool:
    """Whether holes are filled by triangles that touch nobody: what their fans cut off, these go round.

    A scan in patches, or one whose corners were rounded apart, is a soup where it is torn. Its triangles by themselves
    wind round a place as they do round the whole; closed one by one they are flaps round nothing, and a fan over all of
    them cuts off what lies below. Of a true hole triangles leave out a half of the winding at the most.
    """
    lo, hi = closed.vertices.min(axis=0), closed.vertices.max(axis=0)
    axes = [a + (b - a) * (np.arange(_LOOKED) + 0.5) / _LOOKED for a, b in zip(lo, hi, strict=True)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    some = np.argsort(-area, kind="stable")[: _LOOKED**3]
    normals = _normals(closed.vertices[fans[some]])
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    away = normals / np.maximum(size, 1e-300) * 0.1 * np.sqrt(area[some])[:, None]
    middle = closed.vertices[fans[some]].mean(axis=1)
    places = np.concatenate([places, middle + away, middle - away])
    without = np.abs(closed.winding(places)) < _OUT
    return bool((np.abs(loose.winding(places[without])) > _IN).sum() >= _AGREED)


def _holes(edges: Faces, lengths: Points, halves: Points) -> list[tuple[int, Points]]:
    """Of each hole the number of its edges (n, 2) and its middle, the largest first: loops that touch are one."""
    ends = np.unique(edges, return_inverse=True)[1].reshape(-1, 2)
    count, of_corner = connected(ends, int(ends.max(initial=-1)) + 1)
    of_edge = of_corner[ends[:, 0]]
    sizes, whole = np.bincount(of_edge, minlength=count), np.bincount(of_edge, lengths, count)
    middles = np.stack([np.bincount(of_edge, lengths * halves[:, k], count) / whole for k in range(3)], axis=1)
    return [(int(sizes[i]), middles[i]) for i in np.argsort(-sizes, kind="stable")]


def _turned_alike(faces: Faces) -> Faces:
    """The triangles, turned so that neighbours agree where two of them pass their common edge the same way."""
    edges = np.sort(rim(faces), axis=1)
    _, count = np.unique(edges, axis=0, return_counts=True)
    return np.ascontiguousarray(igl.bfs_orient(faces)[0]) if (count > 1).any() else faces


def _outward(vertices: Points, faces: Faces) -> Faces:
    """The triangles of a closed mesh, with all shells turned outwards but cavities: those that lie within others, and
    are turned against them in the file."""
    count, of_corner = connected(faces[:, [0, 1, 1, 2]].reshape(-1, 2), len(vertices))
    of_face = of_corner[faces[:, 0]]
    a, b, c = np.moveaxis(vertices[faces] - vertices.mean(axis=0), 1, 0)
    inward = np.bincount(of_face, np.einsum("ij,ij->i", a, np.cross(b, c)), count) < 0
    if not inward.any():
        return faces
    outward = _flipped(faces, inward[of_face])
    contained, against = np.ones(count, np.bool_), np.zeros(count, np.bool_)
    for places in _beyond_ends(vertices, faces, of_corner, count):
        asked = np.flatnonzero(contained)
        contained[asked] = np.abs(igl.fast_winding_number(vertices, outward, places[asked])) > 0.5
        asked = np.flatnonzero(contained)
        if not len(asked):
            return outward
        as_given = np.rint(igl.fast_winding_number(vertices, faces, places[asked]))
        against[asked] |= as_given * np.where(inward[asked], -1, 1) < 0
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


def boundary(mesh: Closed, h: float, told: Callable[[int, int], None]) -> tuple[Points, float]:
    """The triangles (n, 3, 3) of a mesh that have the inside on one side alone, those that cross others cut to bits,
    and how large what is left out or in wrongly may be where they cross, in mm: SEAM cells, or what MOST_BITS allow.

    `h` is the size of a cell, in mm.
    """
    whole: Points = mesh.vertices[mesh.faces]
    area = np.linalg.norm(_normals(whole), axis=1)
    sized = area > 1e-14 * np.ptp(mesh.vertices, axis=0).max() ** 2
    whole, fan = whole[sized], (np.arange(len(whole)) >= len(whole) - mesh.fans)[sized]
    most = 4 * MOST_BITS if len(whole) < FEW else MOST_BITS
    size = max(2 * h, float((PER_SQUARE * 0.5 * area.sum() / most) ** 0.5))
    bits, owner = halved(whole, np.arange(len(whole)), size)
    parts = _parts(mesh, bits, BESIDE * h, told)
    if parts.all():
        return _unfolded(mesh, whole, fan, h, told), SEAM * h
    mixed = np.zeros(len(whole), np.bool_)
    mixed[owner[~parts | _beside_others(bits, parts)]] = True  # of all others every bit is surface
    known, fans = [whole[~mixed]], [fan[~mixed]]
    some = mixed[owner]
    bits, parts, of_fan = bits[some], parts[some], fan[owner][some]
    asked, seam = 0, SEAM * h
    while size > SEAM * h and parts.any() and not parts.all():
        crossed = _beside_others(bits, parts)
        finer, from_fan = halved(bits[crossed], of_fan[crossed], size / 2)
        if (asked := asked + len(finer)) > most:
            seam = size
            break
        known.append(bits[~crossed & parts])
        fans.append(of_fan[~crossed & parts])
        bits, of_fan, size = finer, from_fan, size / 2
        parts = _parts(mesh, bits, BESIDE * h, told)
    out: Points = np.concatenate([*known, bits[parts]])
    return _unfolded(mesh, out, np.concatenate([*fans, of_fan[parts]]), h, told), seam


def _unfolded(mesh: Closed, triangles: Points, fan: Mask, h: float, told: Callable[[int, int], None]) -> Points:
    """Triangles without the folds of fans, which part nothing a little farther off; a fan that has some, in bits."""
    if not fan.any() or mesh.loose:
        return triangles
    bits, owner = halved(triangles[fan], np.arange(int(fan.sum())), 2 * h)
    parts = _parts(mesh, bits, FOLD * h, told)
    whole = np.ones(int(fan.sum()), np.bool_)
    whole[owner[~parts]] = False
    return np.concatenate([triangles[~fan], triangles[fan][whole], bits[parts & ~whole[owner]]])


def _normals(triangles: Points) -> Points:
    a, b, c = np.moveaxis(triangles, 1, 0)
    return np.asarray(np.cross(b - a, c - a))


def _parts(mesh: Closed, triangles: Points, beside: float, told: Callable[[int, int], None]) -> Mask:
    """Whether triangles part the inside from the outside, so many mm `beside` their middles."""
    normals = _normals(triangles)
    away = beside * normals / np.linalg.norm(normals, axis=1, keepdims=True)
    middle = triangles.mean(axis=1)
    inside = mesh.winds_round(np.concatenate([middle + away, middle - away]), told)
    found: Mask = inside[: len(middle)] != inside[len(middle) :]
    return found


def _beside_others(triangles: Points, parts: Mask) -> Mask:
    """Which triangles may touch one of the other kind: their middles are no farther apart than both reach."""
    near = np.zeros(len(triangles), np.bool_)
    middle = triangles.mean(axis=1)
    size = np.linalg.norm(triangles - middle[:, None], axis=2).max(axis=1)
    rank = np.ceil(np.log2(np.maximum(size, 1e-300)))  # those of one rank differ by a factor of 2
    for kind in (True, False):
        here = np.flatnonzero(parts == kind)
        for r in np.unique(rank[parts != kind]):
            others = (parts != kind) & (rank == r)
            reach = size[here] + size[others].max()
            farthest = 1.01 * float(reach.max(initial=0))
            away, _ = cKDTree(middle[others]).query(middle[here], distance_upper_bound=farthest)
            near[here] |= away <= reach
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
