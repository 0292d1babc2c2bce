"""Crossings that linear interpolation misplaces, put where the field says: by its values, on their edges of the grid.

Between two samples of a smooth field the line errs by the square of the voxel. Where the greater of two takes over on
the edge it errs by up to a voxel, and whole faces move with it: in `max(lattice, cube)` the samples in the solid are
those of the cube, far flatter than the lattice, and every wall ends at the sample before it. So an edge is looked at
where the lines through the samples on either side of it do not agree with it about the crossing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.mesh.crossing import between
from porelang.mesh.grid import Index
from porelang.mesh.layers import Layers, Values
from porelang.mesh.march import ALONG, PLACED

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
#: The field (n,) at points (n, 3) in mm.
At = Callable[[Floats], NDArray[Any]]
#: Functions of one number: values of some of them at places.
Between = Callable[[Floats, Ints], Floats]
#: Of an edge: lines that differ by less agree. What is left is a part of this of the voxel, along rims alone.
AGREE = 0.1
#: Of the difference between an edge's samples: a jump of the slope that is less passes for the bend of a smooth field.
SMOOTH = 0.25
#: Of the same: a bend of a smooth field by which a line errs by a sixteenth of the voxel and more, where it is uneven
#: by that part of itself, as in exp(10 r). An even one is that of an edge along the surface: the vertex is near all the
#: same.
CURVED, UNEVEN = 1.0, 0.25
#: The same for the third difference, which of a jump of the field is twice the jump.
JUMP = 1.0
#: Layers of samples that are looked at beyond a block.
MARGIN = 2
#: Of the smaller of two samples: which values are 0 where no branch is seen to cross; and evaluations at most for one.
NEAR, STEPS = 0.02, 6
#: Of the difference between an edge's samples: a crossing where the field is further from 0 is looked for again.
OFF = 0.01
#: Of a voxel: how far beside a crossing its branch is looked for. What is left is what a slope bends over that.
BESIDE = 0.04
_HUGE = 1e300


@dataclass(frozen=True, slots=True, eq=False)
class Around:
    """The samples of a block of layers from `lo` on, and of `MARGIN` more on every side if there are: from `begin`."""

    values: Values
    begin: Index
    lo: Index

    @property
    def frame(self) -> tuple[int, int, int, int, int]:
        """The place of the block's first node in the samples, and the sides of these along y and z: for `march`."""
        i, j, k = (a - b for a, b in zip(self.lo, self.begin, strict=True))
        return i, j, k, self.values.shape[1], self.values.shape[2]


class Block(NamedTuple):
    """Of a block of samples with these `sides`, which `begin` at a layer: its own layers from `lo`, of a `whole`."""

    sides: Ints
    begin: Ints
    lo: Ints
    whole: Ints


class Limits(NamedTuple):
    """What `AGREE`, `SMOOTH`, `CURVED` and `JUMP` say."""

    agree: float
    smooth: float
    curved: float
    jump: float


def mend(
    vertices: Floats, faces: NDArray[np.int32], edges: Ints, around: Around, layers: Layers, least: Floats, field: At
) -> None:
    """Move the vertices (n, 3) of a block along their `edges` (n,), as `march` gives them, where that is called for.

    `least` (3, n) is how near to the nodes of the block a vertex comes, as a part of the edge that starts there.
    """
    seats = np.zeros((3, max(layers.shape)))
    for n, along in enumerate(layers.axes):
        seats[n, : len(along)] = along.at
    block = Block(np.array(around.values.shape), np.array(around.begin), np.array(around.lo), np.array(layers.shape))
    values = np.ascontiguousarray(around.values).ravel()
    which, rows = suspects(values, block, edges, seats, least, Limits(AGREE, SMOOTH, CURVED, JUMP))
    if not len(which):
        return
    axis, points = edges[which] & 3, vertices[which]
    a, b, start, length, first, slope, room = rows.T

    def value(share: Floats, some: Ints) -> Floats:
        place = points[some]
        place[np.arange(len(some)), axis[some]] = start[some] + share * length[some]
        found = np.asarray(field(place), np.float64)
        return np.clip(np.where(np.isnan(found), a[some], found), -_HUGE, _HUGE)

    share = np.empty(len(which))
    plain, foreseen = np.flatnonzero(slope == 0), np.flatnonzero(slope)
    ends = np.zeros(len(plain)), np.ones(len(plain))
    near = NEAR * np.minimum(np.abs(a), np.abs(b))[plain]
    share[plain], _ = between(lambda x, k: value(x, plain[k]), *ends, a[plain], b[plain], near, STEPS)
    share[foreseen] = _along(
        lambda x, k: value(x, foreseen[k]), a[foreseen], b[foreseen], first[foreseen], slope[foreseen]
    )
    share = np.clip(share, room, 1 - room)
    _correct(value, share, a, b)
    vertices[which, axis] = start + np.clip(share, room, 1 - room) * length
    _recentre(vertices, faces, edges)


def _along(field: Between, a: Floats, b: Floats, first: Floats, slope: Floats) -> Floats:
    """Where functions with the values `a` at 0 and `b` at 1 are 0, each near `first` on a branch with a known `slope`,
    which is that of the end where it was seen: of 1 if the slope is positive, else of 0.

    Newton's method with that slope, from the side on which the branch is. On the other side a small value tells
    nothing, as there another branch takes over, which may be flat: from there the way goes back in growing steps.
    """
    ahead = slope > 0
    way = np.where(ahead, 1.0, -1.0)
    steep = np.abs(slope) * np.sign(b - a)
    low, high = np.zeros(len(a)), np.ones(len(a))
    out, at = first.copy(), np.clip(first + BESIDE * way, 0.0, 1.0)
    stride = np.full(len(a), BESIDE)
    todo = np.arange(len(a))
    for _ in range(STEPS if len(todo) else 0):
        value = field(at[todo], todo)
        mine = (value < 0) == (np.where(ahead, b, a)[todo] < 0)
        step = np.where(mine, -value / steep[todo], stride[todo] * way[todo])
        above = (value < 0) == (b[todo] < 0)
        high[todo], low[todo] = np.where(above, at[todo], high[todo]), np.where(above, low[todo], at[todo])
        stride[todo] *= np.where(mine, 1.0, 3.0)
        to = at[todo] + step
        out[todo] = np.clip(to, low[todo], high[todo])
        at[todo] = np.where((to > low[todo]) & (to < high[todo]), to, (low[todo] + high[todo]) / 2)
        todo = todo[~(mine & (np.abs(step) <= 2 * BESIDE))]
        if not len(todo):
            break
    return out


def _correct(field: Between, share: Floats, a: Floats, b: Floats) -> None:
    """Look again for crossings at which the field is not nearly 0, where a third branch had a part in the foreseen."""
    found = field(share, np.arange(len(share)))
    wrong = np.flatnonzero(np.abs(found) > OFF * np.abs(b - a))
    value, at, one, other = found[wrong], share[wrong], a[wrong], b[wrong]
    below = (value < 0) == (one < 0)
    ends = np.where(below, at, 0.0), np.where(below, 1.0, at)
    values = np.where(below, value, one), np.where(below, other, value)
    near = NEAR * np.minimum(np.abs(one), np.abs(other))
    share[wrong], _ = between(lambda x, k: field(x, wrong[k]), *ends, *values, near, 2 * STEPS)  # they are few


def _recentre(vertices: Floats, faces: NDArray[np.int32], edges: Ints) -> None:
    """Put the vertices within cells back in the middle of the loops that their fans span."""
    for v in np.flatnonzero(edges < 0):
        end = start = -1 - int(edges[v])
        while end < len(faces) and faces[end, 2] == v:
            end += 1
        vertices[v] = vertices[faces[start:end, 0]].mean(axis=0)


@compiled
def suspects(
    values: NDArray[Any], block: Block, edges: Ints, seats: Floats, least: Floats, limits: Limits
) -> tuple[Ints, Floats]:
    """The vertices whose crossing by the line between the two samples of their edge is not that of the line before the
    edge, or of the line after it, where that is more than the bend of a smooth field; and what is known of these edges:
    the samples, where it starts (mm), its length, where on it the crossing should be, the slope there (negative if its
    branch is the one before the edge; 0 if none was found), the least distance from a node (shares of the length).

    Where the slope jumps on the edge the second differences at its two ends, together, hold the jump, and those next to
    them do not: of a smooth field they hold the same to third order. A bend that no line follows counts as well.
    Vertices on caps stay. `values` are in one row.
    """
    out, rows, many = np.empty(len(edges), np.int64), np.empty((64, 7)), 0
    sides, begin, lo, whole = block
    agree, smooth, curved, jump = limits
    steps = np.array([sides[1] * sides[2], sides[2], 1])
    for v in range(len(edges)):
        edge = edges[v]
        if edge < 0:
            continue
        axis, here, node = edge & 3, edge >> 2 & ALONG, edge >> PLACED
        layer = here + begin[axis]
        if layer == 0 or layer == whole[axis] - 2:
            continue
        step = steps[axis]
        # the layers next to the bounds are nearer than a voxel
        first, last = min(layer - 2, here), min(whole[axis] - 3 - layer, sides[axis] - 1 - here)
        a, b = float(values[node]), float(values[node + step])
        rise = b - a
        wrong = first < 0 or last < 1
        if not wrong:
            before, after = a, b
            if first >= 1:  # |a / rise - a / rise before| <= agree
                before = float(values[node - step])
                wrong = not (abs(a * (a - before - rise)) <= agree * abs(rise * (a - before)))
            if last >= 2:
                after = float(values[node + 2 * step])
                wrong = wrong or not (abs(b * (after - b - rise)) <= agree * abs(rise * (after - b)))
            if wrong and first >= 2 and last >= 3:
                one, other = before - 2 * a + b, a - 2 * b + after
                far = float(values[node - 2 * step]) - 2 * before + a + b - 2 * after
                far += float(values[node + 3 * step])
                bend = abs(one + other)
                bent = not bend <= smooth * abs(rise) + abs(far) or (
                    bend > curved * abs(rise) and abs(one - other) > UNEVEN * bend
                )
                wrong = bent or not abs(one - other) <= jump * abs(rise)
        if not wrong:
            continue
        if many == len(rows):
            longer = np.empty((2 * many, 7))
            for r in range(many):
                for n in range(7):
                    longer[r, n] = rows[r, n]
            rows = longer
        a, b = min(max(a, -_HUGE), _HUGE), min(max(b, -_HUGE), _HUGE)
        start, length = seats[axis, layer], seats[axis, layer + 1] - seats[axis, layer]
        # of the greater of two that rise the first to cross counts, of the lesser the last
        found, slope, left, right = -1.0, 0.0, 0.0, 0.0  # the slope is negative if the branch is before the edge
        if layer >= 2 and here >= 1:
            left = (a - values[node - step]) / (start - seats[axis, layer - 1]) * length
            if left * (b - a) > 0 and abs(a) < abs(left):
                found, slope = -a / left, -abs(left)
        if layer + 2 < whole[axis] - 1 and here + 2 < sides[axis]:
            right = (values[node + 2 * step] - b) / (seats[axis, layer + 2] - start - length) * length
            root = 1 - b / right if right * (b - a) > 0 and abs(b) < abs(right) else -1.0
            if root > 0 and (found < 0 or (root < found) == ((right - left) * (b - a) > 0)):
                found, slope = root, abs(right)
        out[many] = v
        rows[many, 0], rows[many, 1], rows[many, 2], rows[many, 3] = a, b, start, length
        rows[many, 4] = found if found > 0 else 0.5
        rows[many, 5] = min(max(slope, -_HUGE), _HUGE) if found > 0 else 0.0
        rows[many, 6] = least[axis, layer - lo[axis]]
        many += 1
    return out[:many], rows[:many]
