"""What of a part its tetrahedra miss, and what they have too much: points all over the cubes at its surface, asked.

Stuffing knows the field where its edges cross it. A tongue that is thinner than a cube, as where a wall meets an
envelope at a small angle, may lie between its vertices, and a rim may be cut off: the mesh looks well and is not the
part. So each cube near the surface is looked at in some PLACES, in the field and in the mesh. Where they differ by more
than a bend does, the cube is too large.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.diagnostics import Diagnostic
from porelang.parallel import parallel_for, workers
from porelang.solid import Solid
from porelang.tet.frame import Frame
from porelang.tet.grading import Region
from porelang.tet.lattice import Lattice
from porelang.tet.octree import Cells
from porelang.tet.tetmesh import TetMesh

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Indices = NDArray[np.int32]
Flags = NDArray[np.bool_]

#: In a cube: spread evenly along each axis too, which a grid is not (R3 of M. Roberts, The unreasonable effectiveness
#: of quasirandom sequences, 2018: parts of the powers of the root of x^4 = x + 1).
PLACES = (0.5 + np.arange(1, 13)[:, None] * 1.2207440846057596 ** -np.arange(1.0, 4.0)) % 1.0
BEND = 0.16  # cubes: a triangle whose middle is further off the surface cuts a rim off
MUCH = 0.003  # of the volume: more than that missing is told
PARTED = np.int32(-1)  # the number of what holds smaller cubes
DEEP = 0.1  # cubes: what is missed by less is a bend between vertices, or what they have moved to make up for it


@dataclass(frozen=True, slots=True)
class Missed:
    """What of a part is `missing` in a mesh, and what it has too much, `extra`, where that is more than a bend, in mm3;
    the `worst` place (3,) mm; and the `cells`, numbers (k,) of cubes that are too large, `of` how many at the surface.
    """

    missing: float
    extra: float
    worst: Floats
    cells: Ints
    of: int

    def told(self, volume: float) -> list[Diagnostic]:
        """W253 where much of the `volume` (mm3) is missing, or too much."""
        if self.missing + self.extra <= MUCH * volume:
            return []
        x, y, z = self.worst
        share = 100 * (self.missing + self.extra) / volume
        message = (
            f"the mesh lacks {self.missing:.3g} mm3 of the part and has {self.extra:.3g} mm3 too much, {share:.2g} % "
            f"of it, as at ({x:.4g}, {y:.4g}, {z:.4g}): the cubes are too large for what is there"
        )
        return [Diagnostic("W253", message, hint="take a smaller --size", severity="warning")]


def missed(
    meshes: Sequence[TetMesh],
    middles: Floats,
    lattice: Lattice,
    values: Floats,
    solid: Solid,
    region: Region | None = None,
) -> Missed:
    """Compare meshes, with triangles of these `middles` (n, 3), with the field of their part, of which the lattice's
    vertices have the `values` (n,); in a `region`, where there is one."""
    cells, frame = lattice.cells, lattice.frame
    some = near(lattice, values)
    if region is not None:
        some = some[region.meets(*cells.taken(some).boxes(frame))]
        middles = middles[region.meets(middles, middles)]
    of = len(some)
    low, high = cells.taken(some).boxes(frame)
    places = (low[:, None] + PLACES * (high - low)[:, None]).reshape(-1, 3)
    inside = (solid.value(places) < 0).reshape(of, len(PLACES))
    doubtful = np.flatnonzero(parted(lattice, values, some, inside))
    some, low, side = some[doubtful], low[doubtful], (high - low)[doubtful]
    held = covered(meshes, cells.taken(some), frame).ravel()
    differ = np.flatnonzero(inside[doubtful].ravel() != held)
    which = differ // len(PLACES)
    value, slope = solid.slope(low[which] + PLACES[differ % len(PLACES)] * side[which])
    with np.errstate(all="ignore"):
        depth = np.abs(value) / np.linalg.norm(slope, axis=1)
    deep = ~(depth < DEEP * side.min(axis=1)[which])
    share = side.prod(axis=1) / len(PLACES)
    count = [np.bincount(which[deep & (held[differ] == h)], minlength=len(some)) * share for h in (False, True)]
    total = count[0] + count[1]
    worst = low[total.argmax()] + side[total.argmax()] / 2 if len(some) else frame.lo
    wrong = np.union1d(some[total > 0], off(middles, lattice, solid))
    return Missed(float(count[0].sum()), float(count[1].sum()), worst, wrong, of)


def off(middles: Floats, lattice: Lattice, solid: Solid) -> Ints:
    """The cubes with a triangle of the surface whose middle (n, 3) is further off than a bend: it cuts a rim off."""
    value, slope = solid.slope(middles)
    with np.errstate(all="ignore"):
        depth = np.abs(value) / np.linalg.norm(slope, axis=1)
    cells = lattice.cell_at(middles)
    return np.unique(cells[(depth > BEND * lattice.cube_at(middles)) & (cells >= 0)])


def near(lattice: Lattice, values: Floats) -> Ints:
    """The cubes that a surface may pass: those at whose corners and centres a field is not so far from 0 that it cannot
    become that between them, unless it changes there twice as fast as from one of them to another."""
    around = np.concatenate([lattice.corner, lattice.centre[:, None]], axis=1)
    found = values[around]
    low, high = found.min(axis=1), found.max(axis=1)
    away = np.maximum(low, -high)
    sure = (lattice.known[around] != 0).all(axis=1)
    return np.flatnonzero(~sure & (away <= high - low))


def parted(lattice: Lattice, values: Floats, some: Ints, inside: Flags) -> Flags:
    """Which of some cubes have solid and void among their corners, centres and places (k, n): a mesh is all that these
    are elsewhere, but for a bend."""
    around = np.concatenate([lattice.corner[some], lattice.centre[some, None]], axis=1)
    solid = values[around] < 0
    return np.asarray((solid.any(axis=1) | inside.any(axis=1)) & ~(solid.all(axis=1) & inside.all(axis=1)))


def covered(meshes: Sequence[TetMesh], cells: Cells, frame: Frame) -> Flags:
    """Which of the PLACES (k, n) in cubes are within tetrahedra of the solid."""
    found = np.zeros((len(cells.level), len(PLACES)), np.bool_)
    if not len(found):
        return found
    top = int(cells.level.max())
    keys, number = _tree(cells, top)
    threads = workers()
    solids = [((mesh.vertices - frame.lo) / frame.edges, mesh.tets[mesh.phase == 0]) for mesh in meshes]
    parts = [(at, some) for at, tets in solids for some in np.array_split(tets, threads)]

    def cover(part: tuple[Floats, Indices]) -> None:  # all write into one array, but nothing except that one is held
        _cover(*part, top, keys, number, PLACES, found)

    parallel_for(cover, parts, threads)
    return found


def _tree(cells: Cells, top: int) -> tuple[Ints, Indices]:
    """A table of cubes and of those at higher levels, up to the `top`, that they lie in: keys, and the numbers of
    cubes; PARTED for what holds smaller ones."""
    keys, numbers = [], []
    for level in range(top + 1):
        mine = np.flatnonzero(cells.level == level)
        keys.append(_key(level, cells.index[mine]))
        numbers.append(mine.astype(np.int32))
        below = cells.level < level
        above = np.unique(_key(level, cells.index[below] >> (level - cells.level[below].astype(np.int64))[:, None]))
        keys.append(above)
        numbers.append(np.full(len(above), PARTED, np.int32))
    return _table(np.concatenate(keys), np.concatenate(numbers))


def _key(level: int, index: Ints) -> Ints:
    key: Ints = (((index[:, 0] << 19) | index[:, 1]) << 19 | index[:, 2]) << 5 | level
    return key


@compiled
def _slot(key: int, mask: int) -> int:
    mixed = key * 0x1E3779B97F4A7C15
    return int((mixed ^ (mixed >> 29)) & mask)


@compiled
def _table(keys: Ints, numbers: Indices) -> tuple[Ints, Indices]:
    size = 16
    while size < 2 * len(keys):
        size *= 2
    table, number = np.full(size, -1, np.int64), np.empty(size, np.int32)
    for c in range(len(keys)):
        s = _slot(keys[c], size - 1)
        while table[s] >= 0:
            s = (s + 1) & (size - 1)
        table[s], number[s] = keys[c], numbers[c]
    return table, number


@compiled
def _cover(at: Floats, tets: Indices, top: int, keys: Ints, number: Indices, places: Floats, found: Flags) -> None:
    mask = len(keys) - 1
    inverse, corner = np.empty((3, 3)), np.empty((4, 3))
    low, high = np.empty(3), np.empty(3)
    first, last = np.empty((top + 1, 3), np.int64), np.empty((top + 1, 3), np.int64)
    todo = np.empty((8 * (top + 2), 4), np.int64)
    for t in range(len(tets)):
        for c in range(4):
            corner[c] = at[tets[t, c]]
        for x in range(3):
            low[x] = min(corner[0, x], corner[1, x], corner[2, x], corner[3, x])
            high[x] = max(corner[0, x], corner[1, x], corner[2, x], corner[3, x])
            for m in range(top + 1):
                side = float(1 << m)
                first[m, x], last[m, x] = max(0, int(np.floor(low[x] / side))), int(np.floor(high[x] / side))
        solved = False
        for a in range(first[top, 0], last[top, 0] + 1):
            for b in range(first[top, 1], last[top, 1] + 1):
                for c in range(first[top, 2], last[top, 2] + 1):
                    todo[0, 0], todo[0, 1], todo[0, 2], todo[0, 3] = top, a, b, c
                    many = 1
                    while many > 0:
                        many -= 1
                        m, i, j, k = todo[many]
                        key = (((i << 19) | j) << 19 | k) << 5 | m
                        s = _slot(key, mask)
                        while keys[s] >= 0 and keys[s] != key:
                            s = (s + 1) & mask
                        if keys[s] < 0:
                            continue
                        if number[s] >= 0:
                            if not solved:
                                _inverse(corner, inverse)
                                solved = True
                            side = float(1 << m)
                            _within(corner, inverse, i * side, j * side, k * side, side, places, found[number[s]])
                            continue
                        for u in range(max(2 * i, first[m - 1, 0]), min(2 * i + 1, last[m - 1, 0]) + 1):
                            for v in range(max(2 * j, first[m - 1, 1]), min(2 * j + 1, last[m - 1, 1]) + 1):
                                for w in range(max(2 * k, first[m - 1, 2]), min(2 * k + 1, last[m - 1, 2]) + 1):
                                    todo[many, 0], todo[many, 1], todo[many, 2], todo[many, 3] = m - 1, u, v, w
                                    many += 1


@compiled
def _inverse(corner: Floats, inverse: Floats) -> None:
    """The matrix that gives the shares of the last three corners of a tetrahedron in a place, from the first one on."""
    u, v, w = corner[1] - corner[0], corner[2] - corner[0], corner[3] - corner[0]
    vw = np.array([v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]])
    wu = np.array([w[1] * u[2] - w[2] * u[1], w[2] * u[0] - w[0] * u[2], w[0] * u[1] - w[1] * u[0]])
    uv = np.array([u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]])
    det = u[0] * vw[0] + u[1] * vw[1] + u[2] * vw[2]
    inverse[0], inverse[1], inverse[2] = vw / det, wu / det, uv / det


@compiled
def _within(
    corner: Floats, inverse: Floats, x: float, y: float, z: float, side: float, places: Floats, found: Flags
) -> None:
    for n in range(len(places)):
        if not found[n]:
            p = x + places[n, 0] * side - corner[0, 0]
            q = y + places[n, 1] * side - corner[0, 1]
            r = z + places[n, 2] * side - corner[0, 2]
            a = inverse[0, 0] * p + inverse[0, 1] * q + inverse[0, 2] * r
            b = inverse[1, 0] * p + inverse[1, 1] * q + inverse[1, 2] * r
            c = inverse[2, 0] * p + inverse[2, 1] * q + inverse[2, 2] * r
            if a >= -1e-9 and b >= -1e-9 and c >= -1e-9 and a + b + c <= 1 + 1e-9:
                found[n] = True  # and never False: another thread may have found it
