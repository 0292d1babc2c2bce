"""Crumbs: pieces of a mesh that are pieces only because of where the samples happen to lie.

Where a wall runs out in a wedge, or is thinner than a voxel, single samples of it stand alone, and so do samples of the
void in a narrow gap. A piece that an enclosure proves to be closed off is one. Round every other small piece the field
is sampled again, finer: what is one with something outside the piece there is a crumb, what is not is a piece of the
part. Crumbs are taken out as long as they hold next to nothing; larger ones stay, and are told as torn off. Pieces of
the part that are far smaller than a voxel, as a boundary cuts them off a lattice, are slivers: they go too, counted
apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.grid import Grid
from porelang.mesh.surface import Pieces, Surface
from porelang.progress import tell
from porelang.solid import Solid

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ints = NDArray[np.int64]
#: Samples to a voxel along an axis, and voxels round a piece, from look to look: what is not open at the last is
#: closed.
LOOKS = ((4, 2), (8, 2), (16, 1))
WIDER = (2, 4, 8)  # voxels round a piece that reaches the end of the look
AT_ONCE = 4_000_000  # samples of one look at most
#: Operations on samples that all looks take together, some seconds; or as many as all samples of the grid took.
BUDGET = 4_000_000_000
EACH = 1 << 13  # samples that take as long as it takes to begin with a look
HALVINGS = 4  # of the sides of a box, to prove that no surface passes them
AROUND = 16  # nodes that looks reach beyond the grid, or less
#: Of a voxel: a piece with all sides below it is there only because a sample happened to meet it, and not a cell in a
#: thousand of its like is met.
SLIVER = 0.1
LITTLE = 0.01  # of the volume of the mesh: more than this is not taken out


@dataclass(frozen=True, slots=True)
class Settled:
    """A mesh without crumbs: how many were taken out of it and filled in it, the volume (mm3) of each kind, how many
    pieces are larger than crumbs and torn off, how many were not looked at, how many of those for want of time and not
    because they are large; and the slivers that were taken out or filled."""

    surface: Surface
    removed: int = 0
    removed_volume: float = 0.0
    filled: int = 0
    filled_volume: float = 0.0
    torn: int = 0
    unknown: int = 0
    pending: int = 0
    joined: int = 0
    alone: int = 0
    slivers: int = 0
    slivers_volume: float = 0.0


class Fate(Enum):
    """Of a piece that is not one with another: it is a piece by itself; it goes on where the mesh has nothing, further
    than was looked; it was not looked at, or not closely enough, because it is large; or for want of time."""

    ALONE = 1
    ENDLESS = 2
    UNKNOWN = 3
    PENDING = 4


def settle(surface: Surface, grid: Grid, part: Solid) -> Settled:
    """The mesh of a part on a grid without the pieces, and the voids, that a finer look finds to be none.

    `surface` is used up: its arrays are packed where something is taken out.
    """
    pieces = surface.pieces
    count = len(pieces.volume)
    if count == 1:
        return Settled(surface)
    main = int(np.argmax(pieces.volume))
    near = _Near(surface, grid, main)
    closed = _closed(pieces, near, part)
    order = [int(c) for c in np.argsort(np.abs(pieces.volume)) if c != main]
    each = len(part.formula.tape.field) or 1
    budget = max(BUDGET // each, int(np.prod(grid.shape)))
    reached: dict[int, Ints] = {}
    slivers = (pieces.high - pieces.low).max(axis=1) < SLIVER * grid.spacing
    torn, unknown, pending, alone = 0, 0, 0, 0
    for i, c in enumerate(order):
        tell(i, len(order))
        if closed[c]:
            continue
        look = _Look(near, part, c)
        found = look.joined(budget)
        budget -= look.samples
        if not isinstance(found, Fate):
            reached[c] = found
        if found is Fate.ENDLESS:
            torn += 1
            slivers[c] = False
        unknown += found is Fate.UNKNOWN or found is Fate.PENDING
        pending += found is Fate.PENDING
        alone += found is Fate.ALONE
    gone = np.zeros(count, np.bool_)
    most, taken = LITTLE * abs(surface.volume), 0.0
    for c in order:
        if c in reached:
            slivers[c] = False
            if gone[reached[c]].all():  # of what is one, one stays
                continue
        elif not slivers[c]:
            continue
        size = abs(float(pieces.volume[c]))
        if taken + size > most:
            torn += c in reached
            continue
        gone[c] = True
        taken += size
    kinds = (gone & ~slivers & ~near.void, gone & ~slivers & near.void, gone & slivers)
    (removed, specks), (filled, bubbles), last = ((int(k.sum()), float(np.abs(pieces.volume[k]).sum())) for k in kinds)
    told = (removed, specks, filled, bubbles, torn, unknown, pending, len(reached), alone, *last)
    return Settled(surface.without(gone) if gone.any() else surface, *told)


_ON = 1e-5  # of a voxel: what is nearer to a node along an axis is level with it (a vertex keeps 2^-12 from nodes)


class _Near:
    """The nodes of a grid next to the surfaces of all pieces but the `main` one: which piece each belongs to.

    `first` and `last` (n, 3) are the corners of the box of each piece, in nodes; `void` tells the voids in the solid.
    """

    def __init__(self, surface: Surface, grid: Grid, main: int) -> None:
        pieces = surface.pieces
        self.grid, self.main = grid, main
        origin = np.array(grid.origin)
        self.void = pieces.volume < 0
        self.first = np.floor((pieces.low - origin) / grid.spacing + _ON).astype(np.int64)
        self.last = np.ceil((pieces.high - origin) / grid.spacing - _ON).astype(np.int64)
        some = np.flatnonzero((pieces.label != main) & (pieces.label >= 0))
        at = (surface.vertices[some] - origin) / grid.spacing
        # the two nodes of the edge of the grid that a vertex lies on; some lie in a cell or in a cap, on no edge
        on = (np.abs(at - np.rint(at)) < _ON).sum(axis=1) == 2
        at = at[on]
        nodes = np.concatenate([np.floor(at + _ON), np.ceil(at - _ON)]).astype(np.int64)
        label = np.tile(pieces.label[some[on]].astype(np.int64), 2)
        self._mine = np.argsort(label, kind="stable")
        self._ends = np.searchsorted(label[self._mine], np.arange(len(pieces.volume) + 1))
        self._nodes = nodes
        self._by_kind = [self._sorted(nodes, label, self.void[label] == kind) for kind in (False, True)]

    def _sorted(self, nodes: Ints, label: Ints, some: Flags) -> tuple[Ints, Ints]:
        keys, first = np.unique(self._keys(nodes[some]), return_index=True)
        return keys, label[some][first]

    def _keys(self, nodes: Ints) -> Ints:
        """One number for each node (n, 3), of those round the grid too."""
        _, ny, nz = (n + 2 * AROUND for n in self.grid.shape)
        keys: Ints = ((nodes[:, 0] + AROUND) * ny + nodes[:, 1] + AROUND) * nz + nodes[:, 2] + AROUND
        return keys

    def nodes(self, piece: int) -> Ints:
        """The nodes (n, 3) next to the surface of a piece, on either side of it."""
        return self._nodes[self._mine[self._ends[piece] : self._ends[piece + 1]]]

    def owners(self, nodes: Ints, groups: Ints, void: bool) -> Ints:
        """The pieces (k,) that nodes (n, 3) belong to, all solid or all `void`: those of a group belong to one, and
        where no surface of a small piece is next to them to the main one."""
        keys, label = self._by_kind[void]
        owner = np.full(len(nodes), -1)
        if len(keys):
            wanted = self._keys(nodes)
            at = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
            owner = np.where(keys[at] == wanted, label[at], -1)
        found = np.unique(owner[owner >= 0])
        rest = np.setdiff1d(groups, groups[owner >= 0])
        return np.union1d(found, [self.main]).astype(np.int64) if len(rest) else found


def _closed(pieces: Pieces, near: _Near, part: Solid) -> Flags:
    """Which pieces (n,) are closed off: enclosures prove that no surface passes the six sides of their boxes.

    Of two pieces in one box neither is taken for closed off; of one within another's box the smaller is looked at.
    """
    closed = np.zeros(len(pieces.volume), np.bool_)
    origin, h = np.array(near.grid.origin), near.grid.spacing
    boxes = np.concatenate([near.first, near.last], axis=1)
    _, first, many = np.unique(boxes, axis=0, return_index=True, return_counts=True)
    some = np.setdiff1d(first[many == 1], [near.main])
    low, high = origin + near.first[some] * h, origin + near.last[some] * h
    owner = np.tile(some, 6)
    lo, hi = np.tile(low, (6, 1)), np.tile(high, (6, 1))
    for side in range(6):
        rows = slice(side * len(some), (side + 1) * len(some))
        axis = side // 2
        lo[rows, axis] = hi[rows, axis] = (low, high)[side % 2][:, axis]
    closed[some] = True
    for turn in range(HALVINGS + 1):
        inside = part.decided(lo, hi)
        other = np.where(near.void[owner], 1, -1)
        closed[owner[inside == -other]] = False
        left = (inside == 0) & closed[owner]
        owner, lo, hi = owner[left], lo[left], hi[left]
        if not len(owner) or turn == HALVINGS or 4 * len(owner) * len(part.formula.tape) > BUDGET // 32:
            break
        for axis in range(3):  # of the flat axis both halves are the same: one is left out
            wide = hi[:, axis] > lo[:, axis]
            middle = (lo[:, axis] + hi[:, axis]) / 2
            upper, lower = lo[wide], hi.copy()
            upper[:, axis] = middle[wide]
            lower[wide, axis] = middle[wide]
            owner = np.concatenate([owner, owner[wide]])
            lo, hi = np.concatenate([lo, upper]), np.concatenate([lower, hi[wide]])
    closed[owner] = False
    return closed


class _Look:
    """Samples round one piece. `samples` counts them, and what it took to begin."""

    def __init__(self, near: _Near, part: Solid, piece: int) -> None:
        self.near, self.part, self.void = near, part, bool(near.void[piece])
        self.samples = 0
        self.first, self.last = near.first[piece], near.last[piece]
        self.nodes = near.nodes(piece)

    def joined(self, budget: int) -> Ints | Fate:
        """The pieces (k,) that the piece is one with, or what it is; PENDING where the `budget` of samples is spent
        before it was looked at."""
        found: Ints | Fate = Fate.UNKNOWN
        for fine, margin in LOOKS:
            for wide in (margin, *(w for w in WIDER if w > margin)):
                size = int(np.prod((self.last - self.first + 2 * wide) * fine + 1))
                if size > AT_ONCE:
                    return found
                if size + EACH > budget - self.samples:
                    return Fate.PENDING if found is Fate.UNKNOWN else found
                found = self._at(fine, wide)
                if found is not Fate.ENDLESS:
                    break
            if found is not Fate.ALONE:
                break
        return found

    def _at(self, fine: int, margin: int) -> Ints | Fate:
        from scipy import ndimage

        grid = self.near.grid
        start = self.first - margin
        axes = [
            grid.origin[n] + (start[n] + np.arange((self.last[n] - start[n] + margin) * fine + 1) / fine) * grid.spacing
            for n in range(3)
        ]
        solid = self.part.on(axes)
        self.samples += solid.size + EACH
        same = ~solid if self.void else solid
        label, _ = ndimage.label(same)
        nodes = tuple(np.s_[::fine] for _ in range(3))
        coarse, _ = ndimage.label(same[nodes])  # what an edge of the grid joins is joined in the mesh
        seeds = tuple((self.nodes - start).T)
        own = np.isin(coarse, np.setdiff1d(coarse[seeds], [0]))
        one = np.setdiff1d(label[nodes][own], [0])
        others = np.setdiff1d(coarse[np.isin(label[nodes], one) & ~own], [0])
        if len(others):
            others = np.argwhere(np.isin(coarse, others))
            return self.near.owners(start + others, coarse[tuple(others.T)], self.void)
        if not len(one):  # rounding made it
            return np.array([self.near.main])
        ends = [label[0], label[-1], label[:, 0], label[:, -1], label[:, :, 0], label[:, :, -1]]
        return Fate.ENDLESS if any(np.isin(end, one).any() for end in ends) else Fate.ALONE
