"""Cubes that cover a part: an octree, pruned by what an enclosure of the field says of boxes, balanced two to one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.progress import tell
from porelang.tet.frame import Frame

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]
#: What is known of boxes (n, 3) .. (n, 3) mm: 1 all solid, -1 all void, 0 not known.
Decided = Callable[[Floats, Floats], NDArray[np.int8]]
#: The edges (n,) mm that cubes may have at points (n, 3) mm; or the same everywhere.
Sizes = Callable[[Floats], Floats] | float
#: Cubes by level and indices (n, 3).
Parted = Sequence[tuple[int, Ints]]

TESTED = 2  # levels above the finest: smaller boxes cost more to enclose than their nodes to evaluate
COARSEST = 5  # levels above the finest at which one begins
ALMOST = 0.9  # of an edge: what is allowed to be as large as that is as large
AROUND = 1.01  # finest cubes round a box that is tested: no tetrahedron reaches further out of its cube
_NONE = np.zeros((0, 3), np.int64)
EIGHT = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), -1).reshape(8, 3)
NEAR = np.array([d for d in np.ndindex(3, 3, 3) if d != (1, 1, 1)]) - 1
PLACES = np.stack(np.meshgrid(*[np.arange(3)] * 3, indexing="ij"), -1).reshape(27, 3) / 2


@dataclass(frozen=True, slots=True)
class Cells:
    """Cubes of an octree: `index` (n, 3) counts cubes of their own `level` (n,), whose edges are 2^level of the finest;
    `known` (n,) is 1 where a cube and what lies round it is all solid, -1 where it is all void, else 0."""

    index: Ints
    level: NDArray[np.int8]
    known: NDArray[np.int8]

    def boxes(self, frame: Frame) -> tuple[Floats, Floats]:
        """From where to where (mm) they reach."""
        side = frame.edges * (1 << self.level.astype(np.int64))[:, None]
        low = frame.lo + self.index * side
        return low, low + side

    def taken(self, some: Flags | Ints) -> Cells:
        """Some of them."""
        return Cells(self.index[some], self.level[some], self.known[some])


def uniform(frame: Frame, decided: Decided, whole: bool = False) -> Cells:
    """All cubes of a frame that a part may reach, or the `whole` frame, of one size."""
    top = _top(frame)
    index = _grid(-(-frame.counts // (1 << top)))
    known = np.zeros(len(index), np.int8)
    for level in range(top, -1, -1):
        if level >= TESTED or level == top:
            open_ = np.flatnonzero(known == 0)
            known[open_] = decided(*_boxes(frame, index[open_], level))
            if not whole:
                index, known = index[known >= 0], known[known >= 0]
        if level:
            index, known = _children(index), np.repeat(known, 8)
            inside = ((index << (level - 1)) < frame.counts).all(axis=1)
            index, known = index[inside], known[inside]
        tell(top - level, top + 1)
    return Cells(index, np.zeros(len(index), np.int8), known)


def graded(
    frame: Frame,
    decided: Decided,
    sizes: Sizes,
    surface: float,
    coarsest: int,
    whole: bool = False,
    parted: Parted = (),
    least: int = 1,
) -> Cells:
    """Cubes that fill a frame: in the part (and in the void, where the `whole` is wanted) as large as `sizes` allow,
    and where its surface may be no larger than `surface` (mm), from the finest up to 2^coarsest times that; those that
    are to be `parted` are split; neighbours differ by a factor of two at most. Below the level `least` nothing is asked
    about boxes."""
    top = max(coarsest, min(_top(frame), COARSEST))
    within = [_key(np.concatenate([some >> (level - at) for at, some in parted if at <= level] or [_NONE]))
              for level in range(top + 1)]  # fmt: skip
    nodes: list[Ints] = [np.zeros((0, 3), np.int64)] * (top + 1)
    split: list[Ints] = [np.zeros((0, 3), np.int64)] * (top + 1)
    nodes[top] = _grid(-(-frame.counts // (1 << top)))
    for level in range(top, 0, -1):
        asked = level >= least or level == top
        known = decided(*_boxes(frame, nodes[level], level)) if asked else np.zeros(len(nodes[level]), np.int8)
        known = np.where(whole & (known < 0), 1, known)
        wanted = (known >= 0) & (level > coarsest)
        rest = np.flatnonzero(~wanted & (known >= 0))
        if len(rest):
            allowed = _least(frame, nodes[level][rest], level, sizes)
            allowed = np.where(known[rest] == 0, np.minimum(allowed, surface), allowed)
            wanted[rest] = allowed < frame.edges.min() * (1 << level) * ALMOST
        wanted |= (((nodes[level] + 1) << level) > frame.counts).any(axis=1)
        wanted |= np.isin(_key(nodes[level]), within[level])
        split[level] = nodes[level][wanted]
        children = _children(split[level])
        nodes[level - 1] = children[((children << (level - 1)) < frame.counts).all(axis=1)]
        tell(top - level, top)
    for level in range(1, top):  # what is split has neighbours of its own size: their parents are split
        beside = (split[level][:, None] + NEAR).reshape(-1, 3)
        beside = beside[((beside >= 0) & ((beside << level) < frame.counts)).all(axis=1)]
        split[level + 1] = _unique(np.concatenate([split[level + 1], beside >> 1]))
    index, levels = [], []
    present = nodes[top]
    for level in range(top, -1, -1):
        is_split = np.isin(_key(present), _key(split[level])) if level else np.zeros(len(present), np.bool_)
        index.append(present[~is_split])
        levels.append(np.full(len(index[-1]), level, np.int8))
        children = _children(present[is_split])
        present = children[((children << max(level - 1, 0)) < frame.counts).all(axis=1)] if level else children
    return Cells(np.concatenate(index), np.concatenate(levels), np.zeros(sum(map(len, index)), np.int8))


def _top(frame: Frame) -> int:
    return int(np.clip(np.ceil(np.log2(frame.counts.max())) - 1, 0, COARSEST))


def _grid(counts: Ints) -> Ints:
    grid: Ints = np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), -1).reshape(-1, 3)
    return grid


def _children(index: Ints) -> Ints:
    children: Ints = (2 * index[:, None] + EIGHT).reshape(-1, 3)
    return children


def _boxes(frame: Frame, index: Ints, level: int) -> tuple[Floats, Floats]:
    """The boxes of cubes, with what tetrahedra reach round them."""
    lo = frame.lo + frame.edges * ((index << level) - AROUND)
    return lo, lo + frame.edges * ((1 << level) + 2 * AROUND)


def _least(frame: Frame, index: Ints, level: int, sizes: Sizes) -> Floats:
    """The least of the sizes at 27 places of each cube."""
    if isinstance(sizes, float):
        return np.full(len(index), sizes)
    at = frame.lo + frame.edges * ((index[:, None] + PLACES) * (1 << level))
    least: Floats = sizes(at.reshape(-1, 3)).reshape(len(index), 27).min(axis=1)
    return least


def _key(index: Ints) -> Ints:
    key: Ints = (index[:, 0] << 42) | (index[:, 1] << 21) | index[:, 2]
    return key


def _unique(index: Ints) -> Ints:
    return index[np.unique(_key(index), return_index=True)[1]]
