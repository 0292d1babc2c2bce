"""Crumbs: pieces of a mesh that are pieces only because of where the samples happen to lie.

Where a wall runs out in a wedge, or is thinner than a voxel, single samples of it stand alone, and so do samples of the
void in a narrow gap. Round every small piece the field is sampled again, finer: what is one with something outside the
piece there is a crumb, what is not is a piece of the part. Crumbs are taken out as long as they hold next to nothing;
larger ones stay, and are told as torn off.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.grid import Grid
from porelang.mesh.solid import Solid
from porelang.mesh.surface import Surface
from porelang.progress import tell

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
#: Samples to a voxel along an axis, and voxels round a piece, from look to look: what is not open at the last is
#: closed.
LOOKS = ((4, 2), (8, 2), (16, 1))
WIDER = (2, 4, 8)  # voxels round a piece that reaches the end of the look
AT_ONCE = 4_000_000  # samples of one look at most
BUDGET = 30_000_000  # samples of all looks, or as many as the grid has
LITTLE = 0.01  # of the volume of the mesh: more than this is not taken out


@dataclass(frozen=True, slots=True)
class Settled:
    """A mesh without crumbs: how many were taken out of it and filled in it, the volume (mm3) of each kind, how many
    pieces are larger than crumbs and torn off, and how many were not looked at."""

    surface: Surface
    removed: int = 0
    removed_volume: float = 0.0
    filled: int = 0
    filled_volume: float = 0.0
    torn: int = 0
    unknown: int = 0


def settle(surface: Surface, grid: Grid, part: Solid) -> Settled:
    """The mesh of a part on a grid without the pieces, and the voids, that a finer look finds to be none.

    `surface` is used up: its arrays are packed where something is taken out.
    """
    pieces = surface.pieces
    count = len(pieces.volume)
    if count == 1:
        return Settled(surface)
    main = int(np.argmax(pieces.volume))
    order = [int(c) for c in np.argsort(np.abs(pieces.volume)) if c != main]
    vertices = _by_piece(surface, main)
    budget = max(BUDGET, int(np.prod(grid.shape)))
    reached: dict[int, Ints] = {}
    torn, unknown = 0, 0
    for i, c in enumerate(order):
        tell(i, len(order))
        look = _Look(grid, part, vertices(c), void=bool(pieces.volume[c] < 0))
        found = look.joined(budget)
        budget -= look.samples
        if found is None:
            unknown += 1
        elif found is ENDLESS:
            torn += 1
        elif len(found):
            reached[c] = _owners(found, pieces.low, pieces.high, c, main)
    gone = np.zeros(count, np.bool_)
    most, taken = LITTLE * abs(surface.volume), 0.0
    for c in order:
        if c not in reached or gone[reached[c]].all():  # of what is one, one stays
            continue
        size = abs(float(pieces.volume[c]))
        if taken + size > most:
            torn += 1
            continue
        gone[c] = True
        taken += size
    solid, void = gone & (pieces.volume >= 0), gone & (pieces.volume < 0)
    told = (
        int(solid.sum()), float(pieces.volume[solid].sum()), int(void.sum()), abs(float(pieces.volume[void].sum())),
        torn, unknown,
    )  # fmt: skip
    return Settled(surface.without(gone) if gone.any() else surface, *told)


def _by_piece(surface: Surface, main: int) -> Callable[[int], Floats]:
    """The vertices of each piece but the main one."""
    label = surface.pieces.label
    some = np.flatnonzero((label != main) & (label >= 0))
    some = some[np.argsort(label[some], kind="stable")]
    ends = np.searchsorted(label[some], np.arange(len(surface.pieces.volume) + 1))
    return lambda c: surface.vertices[some[ends[c] : ends[c + 1]]]


def _owners(nodes: Floats, low: Floats, high: Floats, mine: int, main: int) -> Ints:
    """The pieces (k,) that nodes (n, 3) may belong to: those whose boxes they lie in, or else the main one."""
    found: set[int] = set()
    for at in nodes:
        holding = np.flatnonzero((low < at).all(axis=1) & (at < high).all(axis=1))
        others = [int(c) for c in holding if c not in (mine, main)]
        found |= set(others) if others else {main}
    return np.array(sorted(found), np.int64)


#: Of a look: the piece goes on where the mesh has nothing, further than was looked; and: it is a piece by itself.
ENDLESS, ALONE = np.zeros((0, 3)), np.zeros((0, 3))
_NAMED = 64  # nodes that a piece is one with
_ON = 1e-5  # of a voxel: what is nearer to a node along an axis is level with it (a vertex keeps 2^-12 from nodes)


class _Look:
    """Samples round one piece, given by its vertices; `void` if it is a void in the solid. `samples` counts them."""

    def __init__(self, grid: Grid, part: Solid, vertices: Floats, void: bool) -> None:
        self.grid, self.part, self.void = grid, part, void
        self.samples = 0
        at = (vertices - np.array(grid.origin)) / grid.spacing
        self.first = np.floor(at.min(axis=0) + _ON).astype(np.int64)
        self.last = np.ceil(at.max(axis=0) - _ON).astype(np.int64)
        # the two nodes of the edge of the grid that a vertex lies on; some lie in a cell or in a cap, on no edge
        level = np.abs(at - np.rint(at)) < _ON
        at = at[level.sum(axis=1) == 2]
        self.nodes = np.unique(np.concatenate([np.floor(at + _ON), np.ceil(at - _ON)]).astype(np.int64), axis=0)

    def joined(self, budget: int) -> Floats | None:
        """Nodes of the grid, (n, 3) mm, that the piece is one with and that are not its own; ALONE, or ENDLESS; None
        where the `budget` of samples is too small to tell."""
        found: Floats | None = None
        for fine, margin in LOOKS:
            for wide in (margin, *(w for w in WIDER if w > margin)):
                size = int(np.prod((self.last - self.first + 2 * wide) * fine + 1))
                if size > min(AT_ONCE, budget - self.samples):
                    return found
                found = self._at(fine, wide)
                if found is not ENDLESS:
                    break
            if found is not ALONE:
                break
        return found

    def _at(self, fine: int, margin: int) -> Floats:
        from scipy import ndimage

        start = self.first - margin
        axes = [
            self.grid.origin[n] + (start[n] + np.arange((self.last[n] - start[n] + margin) * fine + 1) / fine)
            * self.grid.spacing
            for n in range(3)
        ]  # fmt: skip
        solid = self.part.on(axes)
        self.samples += solid.size
        same = ~solid if self.void else solid
        label, _ = ndimage.label(same)
        nodes = tuple(np.s_[::fine] for _ in range(3))
        coarse, _ = ndimage.label(same[nodes])  # what an edge of the grid joins is joined in the mesh
        seeds = tuple((self.nodes - start).T)
        own = np.isin(coarse, np.setdiff1d(coarse[seeds], [0]))
        one = np.setdiff1d(label[nodes][own], [0])
        others = np.argwhere(np.isin(label[nodes], one) & ~own)
        if len(others):
            some = others[:: max(1, len(others) // _NAMED)]
            return np.stack([axes[n][fine * some[:, n]] for n in range(3)], axis=1)
        if not len(one):  # rounding made it
            beside: Floats = np.array([self.grid.origin]) + (self.first - 1) * self.grid.spacing
            return beside
        ends = [label[0], label[-1], label[:, 0], label[:, -1], label[:, :, 0], label[:, :, -1]]
        return ENDLESS if any(np.isin(end, one).any() for end in ends) else ALONE
