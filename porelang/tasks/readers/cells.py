"""Cells of a mesh, and values at their points or in them; cells become tetrahedra, which know barycentric coordinates.

A tetrahedron stays one, one of second order becomes eight; hexahedra and wedges of second order are cut about all of
their points (`quadratic`). Hexahedra, wedges and pyramids are cut from their corner
with the smallest number, and the faces opposite by diagonals from theirs: two cells cut the face that they share in the
same way (J. Dompierre et al., How to subdivide pyramids, prisms and hexahedra into tetrahedra, 1999). Of other cells of
higher order the corners count.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from porelang.data import FARTHEST, NEAREST
from porelang.tasks.readers.asked import Array, Asked, usable
from porelang.tasks.readers.quadratic import halves, middles
from porelang.tasks.readers.quadratic import tetrahedra as quadratic

#: VTK's numbers of cells with a volume: how many corners, and how many points at least there are.
TETRA, VOXEL, HEXAHEDRON, WEDGE, PYRAMID, TETRA_10 = 10, 11, 12, 13, 14, 24
_CORNERS = {TETRA: 4, VOXEL: 8, HEXAHEDRON: 8, WEDGE: 6, PYRAMID: 5, TETRA_10: 10}
_LIKE = {TETRA: (71, 78), HEXAHEDRON: (25, 29, 33, 72, 79), WEDGE: (26, 31, 32, 73, 80), PYRAMID: (27, 37, 74, 81)}
#: Cells without a volume, which parts are seldom without: points, bars, shells.
#: Of second order: how many of a cell's points count.
_SECOND = {25: 20, 29: 20, 33: 20, 26: 15, 32: 15}
_FLAT = frozenset({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 21, 22, 23, 28, 30, 34, 35, 36, 60, 61, 62, 68, 69, 70, 75, 76, 77})
_NAMES = {41: "convex sets of points", 42: "polyhedra", 5: "triangles", 9: "quadrangles", 22: "triangles", 3: "lines"}
_NAMES |= {1: "points", 2: "points", 7: "polygons", 23: "quadrangles", 15: "prisms", 16: "prisms", 6: "triangle strips"}
#: The faces of each kind by its corners.
_FACES: dict[int, tuple[tuple[int, ...], ...]] = {
    HEXAHEDRON: ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    WEDGE: ((0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    PYRAMID: ((0, 1, 2, 3), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
}
#: A tetrahedron of second order: at each corner one, and four about the diagonal of the octahedron between them.
_EIGHT = (
    (0, 4, 6, 7),
    (4, 1, 5, 8),
    (6, 5, 2, 9),
    (7, 8, 9, 3),
    (4, 9, 5, 8),
    (4, 9, 8, 7),
    (4, 9, 7, 6),
    (4, 9, 6, 5),
)


@dataclass(frozen=True, slots=True)
class Cells:
    """Tetrahedra (t, 4) of `points` (n, 3) in mm; values (n, k) at points, or (t, k) in each tetrahedron.

    `places` (m, 3) are where the file itself says a value, `known` (m, k) which: the points of the cells, and the
    middles of those whose corners tell it. `count` is the number of cells, `left` of those that have no volume,
    `corners` of those of higher order of which the corners alone count; `named` whether the file says which component
    of a tensor is which.
    """

    points: Array
    tetrahedra: Array
    values: Array
    in_cells: bool
    places: Array
    known: Array
    count: int
    left: int
    corners: int
    named: bool


@dataclass(frozen=True, slots=True)
class Block:
    """Cells of one kind (VTK's number): their points (m, n), and which of all cells they are (m,)."""

    kind: int
    points: Array
    numbers: Array


def blocks(asked: Asked, kinds: Array, offsets: Array, connectivity: Array) -> list[Block]:
    """Cells by their kinds; `offsets` (m + 1,) say where the points of each begin and end. Errors: E131."""
    if len(offsets) != len(kinds) + 1:
        raise asked.damaged(f"{len(kinds):,} kinds of cells, and places of {len(offsets) - 1:,}")
    counts = np.diff(offsets)
    if len(counts) and (int(offsets[0]) < 0 or int(counts.min()) < 0 or int(offsets[-1]) > len(connectivity)):
        raise asked.damaged("its cells lie beyond the list of their points")
    out = []
    for kind in np.unique(kinds).tolist():
        of_kind = np.flatnonzero(kinds == kind)
        for count in np.unique(counts[of_kind]).tolist():
            numbers = of_kind[counts[of_kind] == count]
            out.append(Block(kind, connectivity[offsets[numbers][:, None] + np.arange(count)], numbers))
    return out


def cells(
    asked: Asked, points: Array, listed: Sequence[Block], values: Array, in_cells: bool, named: bool = False
) -> Cells:
    """The tetrahedra of cells with values at points (n, k), or in cells (m, k). Errors: E131, E134, E150."""
    made: list[Array] = []
    numbers: list[Array] = []
    places: list[Array] = []
    known: list[Array] = []
    used = np.zeros(len(points), np.bool_)
    more: list[Array] = []  # points in the middles of cells, and values there
    there: list[Array] = []
    count = left = corners_alone = 0
    for block in listed:
        kind = next((k for k, like in _LIKE.items() if block.kind in like), block.kind)
        if kind in _FLAT:
            left += len(block.numbers)
            continue
        if kind not in _CORNERS:
            name = _NAMES.get(kind, f"cells of the kind {kind}")
            hint = "cut them into tetrahedra (in ParaView: the filter Tetrahedralize)"
            raise asked.fail("E150", f"`{asked.path}` holds {name}, which are not read", hint)
        if block.points.shape[1] < _CORNERS[kind]:
            raise asked.damaged(f"a cell with {_CORNERS[kind]} corners has {block.points.shape[1]} points")
        if block.points.size and not 0 <= int(block.points.min()) <= int(block.points.max()) < len(points):
            text = f"a cell names point {int(block.points.max()):,} of {len(points):,}"
            raise asked.damaged(text if int(block.points.max()) >= len(points) else "a cell names a point below 0")
        used[block.points] = True
        count += len(block.numbers)
        corners = block.points[:, : _CORNERS[kind]]
        second = _SECOND.get(block.kind, 0)
        if second and block.points.shape[1] >= second:
            whole = block.points[:, :second]
            tetrahedra, owner = quadratic(whole, len(points) + sum(map(len, more)))
            made.append(tetrahedra)
            numbers.append(block.numbers[owner])
            more.append(middles(points, whole))
            there.append(np.zeros((0, values.shape[1])) if in_cells else middles(values, whole))
            places.append(more[-1])
            known.append(values[block.numbers] if in_cells else there[-1])
            continue
        corners_alone += 0 if kind == block.kind or in_cells else len(block.numbers)
        if kind == VOXEL:  # its points run along x, then y, then z
            kind, corners = HEXAHEDRON, corners[:, [0, 1, 3, 2, 4, 5, 7, 6]]
        tetrahedra, owner = _tetrahedra(kind, corners)
        made.append(tetrahedra)
        numbers.append(block.numbers[owner])
        if in_cells or (kind == block.kind and kind != TETRA_10):
            own = corners[:, :4] if kind == TETRA_10 else corners
            with np.errstate(all="ignore"):
                places.append(points[own].mean(axis=1))
                known.append(values[block.numbers] if in_cells else values[own].mean(axis=1))
    if not count:
        flat = [_NAMES.get(b.kind, "") for b in listed if b.kind in _FLAT]
        what = f", only {next(filter(None, flat), 'what is flat')}" if flat else ""
        hint = "export the cells of the volume (tetrahedra, hexahedra, wedges or pyramids), not a surface"
        if flat and _is_level(points, listed):
            hint += "; of an analysis in a plane write a grid of two layers, .npz: docs/language.md shows how"
        raise asked.fail("E150", f"`{asked.path}` holds no cells with a volume{what}", hint)
    tetrahedra, owner = np.concatenate(made), np.concatenate(numbers)
    _checked(asked, points, used)
    counted = np.isin(np.arange(len(values)), owner) if in_cells else used
    usable(asked, np.where(counted[:, None], values, 0), *(("cell",) if in_cells else ("point", points)))
    if not in_cells:
        places.append(points[used])
        known.append(values[used])
    points, values = np.concatenate([points, *more]), values if in_cells else np.concatenate([values, *there])
    if not _has_volume(points, tetrahedra):
        hint = "export the cells of the volume anew: the corners of each lie in a plane, or on each other"
        raise asked.fail("E150", f"none of the cells of `{asked.path}` has a volume", hint)
    return Cells(points, tetrahedra, values[owner] if in_cells else values, in_cells, np.concatenate(places),
                 np.concatenate(known), count, left, corners_alone, named)  # fmt: skip


def _is_level(points: Array, listed: Sequence[Block]) -> bool:
    """Whether all cells lie in one plane that two axes span, as those of an analysis in a plane."""
    used = np.unique(np.concatenate([b.points.reshape(-1) for b in listed]))
    inside = used[(used >= 0) & (used < len(points))]
    return bool(len(inside) and np.ptp(points[inside], axis=0).min() < NEAREST)


def _has_volume(points: Array, tetrahedra: Array) -> bool:
    """Whether any tetrahedron has one, in the rounding of its places."""
    a, b, c, d = (points[tetrahedra[:, k]] for k in range(4))
    volumes = np.abs(np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a)))
    longest = np.max([np.abs(e).max(axis=1) for e in (b - a, c - a, d - a)], axis=0)
    return bool((volumes > 1e-12 * longest**3).any())


def _checked(asked: Asked, points: Array, used: Array) -> None:
    """Errors: E134 where a corner is no place, or one where there are no parts."""
    here = points[used]
    if not np.isfinite(here).all():
        raise asked.fail("E134", f"`{asked.path}` has points that are no places: not a number, or infinite")
    if (farthest := float(np.abs(here).max())) > FARTHEST:
        hint = f"parts lie within {FARTHEST:,.0f} mm of the origin: lengths are in mm"
        raise asked.fail("E134", f"the cells of `{asked.path}` reach to {farthest:g} mm", hint)
    if float(np.ptp(here, axis=0).min()) < NEAREST:
        raise asked.fail("E150", f"the cells of `{asked.path}` lie in a plane: they have no volume")


def _tetrahedra(kind: int, corners: Array) -> tuple[Array, Array]:
    """The tetrahedra (t, 4) of cells (m, n), and of which cell each is (t,)."""
    count = len(corners)
    if kind == TETRA:
        return corners, np.arange(count)
    if kind == TETRA_10:
        return corners[:, np.array(_EIGHT)].reshape(-1, 4), np.repeat(np.arange(count), 8)
    made: list[Array] = []
    owner: list[Array] = []
    least = np.argmin(corners, axis=1)
    for first in range(corners.shape[1]):
        of = np.flatnonzero(least == first)
        here = corners[of]
        for face in _FACES[kind]:
            if first in face or not len(of):
                continue
            triangles = [here[:, face]] if len(face) == 3 else halves(here[:, face])
            for triangle in triangles:
                made.append(np.concatenate([here[:, [first]], triangle], axis=1))
                owner.append(of)
    return np.concatenate(made), np.concatenate(owner)
