"""From cubes to tetrahedra: the lattice of corners and centres, also where cubes of two sizes meet.

Two cubes of one size share a face: round the line between their centres lie four tetrahedra, one for each edge of the
face, halved where cubes beyond the edge are smaller. A face to a cube twice as large is parted in two, along the
diagonal from the middle of the larger face, with a tetrahedron to the centre on either side. (F. Labelle & J. R.
Shewchuk, Isosurface Stuffing, 2007, section 4: the bisected and quadrisected tetrahedra of a graded octree.) At the end
of a frame a face is parted round its middle.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.tet.frame import Frame
from porelang.tet.octree import EIGHT, Cells

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Indices = NDArray[np.int32]
#: The corners of a cube, as in EIGHT, round its face at the far and the near end of an axis, counter-clockwise as seen
#: from the far end of that axis.
ROUND = np.array([
    [[sum(1 << (2 - j) for j, on in (((k) % 3, side), ((k + 1) % 3, u), ((k + 2) % 3, v)) if on)
      for u, v in ((0, 0), (1, 0), (1, 1), (0, 1))] for side in (0, 1)]
    for k in range(3)
])  # fmt: skip


class Lattice:
    """Vertices in half edges of the finest cube: `at` (n, 3) int64; `kind` (n,) is 1 of centres; tets (m, 4) int32."""

    def __init__(self, cells: Cells, frame: Frame) -> None:
        self.cells, self.frame = cells, frame
        side = 2 << cells.level.astype(np.int64)
        self.low = cells.index * side[:, None]
        corners = (self.low[:, None] + EIGHT * side[:, None, None]).reshape(-1, 3)
        self.keys, first, number = np.unique(_key(corners), return_index=True, return_inverse=True)
        self.corner = number.reshape(-1, 8).astype(np.int32)
        self.centre = (len(first) + np.arange(len(side))).astype(np.int32)
        self.levels = {int(k): np.flatnonzero(cells.level == k) for k in np.unique(cells.level)}
        self.sorted = {}
        for k, some in self.levels.items():
            key = _key(cells.index[some])
            order = np.argsort(key, kind="stable")
            self.sorted[k] = key[order], some[order]
        parts = [t for k in self.levels for axis in range(3) for t in self._across(k, axis)]
        faces, more = self._ends(len(first) + len(side))
        self.at = np.concatenate([corners[first], self.low + side[:, None] // 2, faces])
        self.kind = np.zeros(len(self.at), np.int8)
        self.kind[len(first) :] = 1
        self.tets: Indices = np.concatenate([*parts, *more, np.zeros((0, 4), np.int32)])
        #: places that cubes known to be solid, or void, alone have
        self.known = np.zeros(len(self.at), np.int8)
        for state in (1, -1):
            some = cells.known == state
            self.known[self.corner[some]] = state
            self.known[self.centre[some]] = state
        unknown = cells.known == 0
        self.known[self.corner[unknown]] = 0

    @property
    def vertices(self) -> Floats:
        return self.frame.lo + self.at * (self.frame.edges / 2)

    @property
    def held(self) -> NDArray[np.uint8]:
        """The ends of the frame in which places lie, by bits; those alone in which the part ends."""
        held = np.zeros(len(self.at), np.uint8)
        for axis in range(3):
            for end, place in enumerate((0, 2 * self.frame.counts[axis])):
                if self.frame.ends[axis, end]:
                    held[self.at[:, axis] == place] |= np.uint8(1 << (2 * axis + end))
        return held

    @property
    def rank(self) -> Ints:
        """Even places come before odd ones, as along every axis they take turns."""
        odd = ((self.at - self.kind[:, None]) >> 1).sum(axis=1) & 1
        rank: Ints = (odd << 40) + np.arange(len(self.at))
        return rank

    def cube_at(self, points: Floats) -> Floats:
        """How large cubes are at points (n, 3): their least edges (n,) mm; as the largest where there are none."""
        least, largest = float(self.frame.edges.min()), max(self.levels)
        if len(self.levels) == 1:
            return np.full(len(points), least * (1 << largest))
        found = self.cell_at(points)
        return np.where(found >= 0, least * (1 << self.cells.level[found].astype(np.int64)), least * (1 << largest))

    def cell_at(self, points: Floats) -> Ints:
        """The numbers (n,) of the cubes that points (n, 3) mm are in; -1 where there are none."""
        frame = self.frame
        index = np.floor((np.clip(points, frame.lo, frame.hi) - frame.lo) / frame.edges).astype(np.int64)
        index = np.clip(index, 0, frame.counts - 1)
        found = np.full(len(points), -1)
        for level in self.levels:
            found = np.maximum(found, self._find(level, index >> level))
        return found

    def _find(self, level: int, index: Ints) -> Ints:
        """The cubes at a level with these indices; -1 where there are none."""
        if level not in self.sorted:
            return np.full(len(index), -1)
        keys, cells = self.sorted[level]
        key = _key(index)
        at = np.minimum(np.searchsorted(keys, key), len(keys) - 1)
        return np.where((keys[at] == key) & (index >= 0).all(axis=1), cells[at], -1)

    def _across(self, level: int, axis: int) -> list[Indices]:
        """The tetrahedra across faces between cubes of a level, and from them to larger ones."""
        some = self.levels[level]
        step = np.zeros(3, np.int64)
        step[axis] = 1
        beside = self._find(level, self.cells.index[some] + step)
        mine, other = some[beside >= 0], beside[beside >= 0]
        parts = self._round(self.centre[mine], self.centre[other], self.corner[mine][:, ROUND[axis, 1]])
        if level + 1 not in self.levels:
            return parts
        for side in (0, 1):
            large = self._find(level + 1, (self.cells.index[some] + (2 * side - 1) * step) >> 1)
            mine, other = some[large >= 0], large[large >= 0]
            # of the small face that corner is the middle of the large one whose two other coordinates are odd
            index = self.cells.index[mine]
            u, v = 1 - (index[:, (axis + 1) % 3] & 1), 1 - (index[:, (axis + 2) % 3] & 1)
            middle = np.where(v == 0, u, 3 - u)
            turn = (middle[:, None] + np.arange(4)) % 4
            q = np.take_along_axis(self.corner[mine][:, ROUND[axis, side]], turn, axis=1)
            for a, b in ((1, 2), (2, 3)):
                face = [q[:, 0], q[:, a], q[:, b]]
                small, big = self.centre[mine], self.centre[other]
                below, above = (small, big) if side else (big, small)
                parts += [np.stack([below, *face], axis=1), np.stack([*face, above], axis=1)]
        return parts

    def _round(self, one: Indices, other: Indices, face: Indices) -> list[Indices]:
        """The tetrahedra between two places (n,), one before the other, and the edges of the faces (n, 4) between."""
        parts = []
        for k in range(4):
            a, b = face[:, k], face[:, (k + 1) % 4]
            half = self._middle(a, b) if len(self.levels) > 1 else np.full(len(a), -1, np.int32)
            for some, ends in ((half < 0, (a, b)), (half >= 0, (a, half)), (half >= 0, (half, b))):
                if some.any():
                    parts.append(np.stack([one[some], other[some], ends[0][some], ends[1][some]], axis=1))
        return parts

    def _middle(self, a: Indices, b: Indices) -> Indices:
        """The corner in the middle of edges; -1 where there is none."""
        key = (self.keys[a] + self.keys[b]) >> 1
        odd = (self.keys[a] ^ self.keys[b]) & ((1 << 42) | (1 << 21) | 1)  # no: a half edge has no middle
        at = np.minimum(np.searchsorted(self.keys, key), len(self.keys) - 1)
        return np.where((self.keys[at] == key) & (odd == 0), at, -1).astype(np.int32)

    def _ends(self, count: int) -> tuple[Ints, list[Indices]]:
        """The middles (k, 3) of faces at those ends of the frame in which the part ends, and the tetrahedra there."""
        middles, parts = [np.zeros((0, 3), np.int64)], []
        side = 2 << self.cells.level.astype(np.int64)
        for axis in range(3):
            for end in (0, 1):
                if not self.frame.ends[axis, end]:
                    continue
                at_end = self.low[:, axis] + side == 2 * self.frame.counts[axis] if end else self.low[:, axis] == 0
                some = np.flatnonzero(at_end)
                middle = self.low[some] + side[some, None] // 2
                middle[:, axis] = 2 * self.frame.counts[axis] if end else 0
                number = (count + np.arange(len(some))).astype(np.int32)
                count += len(some)
                middles.append(middle)
                one, other = (self.centre[some], number) if end else (number, self.centre[some])
                parts += self._round(one, other, self.corner[some][:, ROUND[axis, end]])
        return np.concatenate(middles), parts


def _key(index: Ints) -> Ints:
    key: Ints = (index[:, 0] << 42) | (index[:, 1] << 21) | index[:, 2]
    return key
