"""Which parts of a grid can hold a surface: bricks of cells, ruled out by an enclosure of the field, coarse to fine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.grid import Index
from porelang.mesh.layers import Layers

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Enclose = Callable[[Floats, Floats], tuple[Floats, Floats]]

COARSER = 4  # bricks a side in a block that is tried first
FEW = 512  # bricks that are all looked at, as an enclosure of one box costs what that of hundreds does
AT_ONCE = 4096  # boxes given to the enclosure in one call


@dataclass(frozen=True, slots=True, eq=False)
class Brick:
    """The half-open range of layers `lo..hi`; neighbours share a layer."""

    lo: Index
    hi: Index


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """The bricks to be sampled, and whether any that was ruled out is void.

    `nearest` is the brick among those ruled out where the field comes closest to a surface by its enclosure.
    """

    bricks: list[Brick]
    void: bool
    nearest: Brick | None


def split(layers: Layers, size: int, enclose: Enclose | None = None) -> Plan:
    """Bricks of about `size` cells a side over all layers, without those whose enclosure excludes a surface.

    `enclose(lo, hi)` takes boxes, two (n, 3) arrays in mm, and gives the least and greatest value (n,) that the field
    may take in each; a NaN rules nothing out.
    """
    cells = np.array(layers.shape) - 1
    # Alike, so that there are none of a few cells: 134 cells make two bricks of 67.
    sides = -(-cells // np.maximum(1, np.rint(cells / size).astype(np.int64)))
    if enclose is None:
        return Plan(_bricks(_tile(np.zeros((1, 3), np.int64), cells[None], sides)), False, None)
    few = np.prod(-(-cells // sides)) <= FEW
    blocks = _tile(np.zeros((1, 3), np.int64), cells[None], sides if few else COARSER * sides)
    void = False
    nearest, least = None, np.inf
    for step in (None,) if few else (sides, None):
        kept, low, high = _sift(layers, blocks, enclose)
        void |= bool((low[~kept] > 0).any())
        distance = np.where(kept, np.inf, np.minimum(np.abs(low), np.abs(high)))
        if distance.size and distance.min() < least:
            least, nearest = distance.min(), _bricks(blocks[distance.argmin()][None])[0]
        blocks = blocks[kept]
        if step is not None:
            blocks = _tile(blocks[:, 0], blocks[:, 1] - 1, step)
    return Plan(_bricks(blocks), void, nearest)


def _tile(lo: Ints, hi: Ints, sides: Ints) -> Ints:
    """Blocks (n, 2, 3) of layers, with `sides` (3,) cells, that fill the ranges of cells `lo..hi` (m, 3)."""
    tiles = [np.zeros((0, 2, 3), np.int64)]
    for first, last in zip(lo, hi, strict=True):
        starts = np.meshgrid(*(np.arange(a, b, s) for a, b, s in zip(first, last, sides, strict=True)), indexing="ij")
        start = np.stack([s.ravel() for s in starts], axis=1)
        tiles.append(np.stack([start, np.minimum(start + sides, last) + 1], axis=1))
    return np.concatenate(tiles)


def _sift(layers: Layers, blocks: Ints, enclose: Enclose) -> tuple[NDArray[np.bool_], Floats, Floats]:
    """Which blocks may hold a surface, and the enclosure of the field over each."""
    lo, hi = np.empty((len(blocks), 3)), np.empty((len(blocks), 3))
    at_bound = np.zeros(len(blocks), np.bool_)
    for n, axis in enumerate(layers.axes):
        start, end = layers.grid.origin[n], layers.grid.spacing
        lo[:, n] = start + axis.node[blocks[:, 0, n]] * end
        hi[:, n] = start + axis.last[blocks[:, 1, n] - 1] * end
        at_bound |= (blocks[:, 0, n] == 0) | (blocks[:, 1, n] == len(axis))
    # The sampler may round its coordinates to float32.
    lo -= np.abs(lo) * 2.0**-23
    hi += np.abs(hi) * 2.0**-23
    low, high = np.empty(len(blocks)), np.empty(len(blocks))
    for i in range(0, len(blocks), AT_ONCE):
        low[i : i + AT_ONCE], high[i : i + AT_ONCE] = enclose(lo[i : i + AT_ONCE], hi[i : i + AT_ONCE])
    # Solid up to the bound, it still has a cap there. A comparison with NaN is false, and keeps the block.
    excluded = (low > 0) | ((high < 0) & ~at_bound)
    return ~excluded, low, high


def _bricks(blocks: Ints) -> list[Brick]:
    return [Brick(tuple(lo), tuple(hi)) for lo, hi in blocks.tolist()]
