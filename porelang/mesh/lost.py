"""What a mesh has nothing of: features of the part that lie between its samples.

Blocks of the grid are halved where an enclosure leaves open whether the surface passes, down to cells of one voxel;
blocks of four voxels that the mesh passes through, and what is next to them, are left out. In every other cell the
field is followed towards its surface: where it reaches a point of the other sign than the samples round it have, the
part has something there that the mesh has not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.grid import Grid
from porelang.mesh.surface import AT_ONCE, Surface
from porelang.solid import Solid, onto

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ints = NDArray[np.int64]
BLOCK = 4  # voxels
MOST = 1 << 17  # blocks that are enclosed at a time: of more, as many by chance stand for all
FOLLOWED = 1 << 14  # cells in which the surface is looked for
STEPS = 6
BEYOND = (1e-6, 1e-3, 0.03)  # voxels beyond the surface where a point of the other sign is looked for
PARALLEL = -0.9  # cosine between the outward directions of the two sides of a wall
SCAN = 24  # distances at which the other side of a wall is looked for


@dataclass(frozen=True, slots=True)
class Lost:
    """Points (n, 3) mm, each in a cell of the grid that the mesh has nothing of, where the part is `solid` (or void)
    and the samples round it are not; how thick its wall is there (mm, NaN where it is none whose sides run parallel),
    and how far the mesh is (mm). Each point stands for `each` cells."""

    points: Floats
    solid: Flags
    thick: Floats
    away: Floats
    each: float


def lost(surface: Surface | None, grid: Grid, part: Solid) -> Lost:
    """What the mesh of a part on a grid has nothing of; without a mesh, what there is at all."""
    passed = _passed(surface, grid)
    cells, each = _open(passed, grid, part)
    h = grid.spacing
    at, solid, cells, share = followed(cells, grid, part)
    thick, facing, _ = part.walls(at, 4 * h, SCAN)
    thick[~(solid & (facing < PARALLEL))] = np.nan
    return Lost(at, solid, thick, _away(passed, cells, h), each * share)


def followed(cells: Ints, grid: Grid, part: Solid) -> tuple[Floats, Flags, Ints, float]:
    """Points (n, 3) mm of the other sign than the samples round them, one for each of the cells (n, 3) that the mesh
    does not pass where such a point is found; which are solid, the cells, and how many cells each stands for."""
    share = max(1.0, len(cells) / FOLLOWED)
    if share > 1:
        cells = cells[np.random.default_rng(0).permutation(len(cells))[:FOLLOWED]]
    h = grid.spacing
    corner = np.array(grid.origin) + cells * h
    # the corners of a cell that nothing passes have one sign: one that lies in the part's box tells it
    here = part.holds(np.clip(corner, part.lo, part.hi))
    at = onto(part, corner + h / 2, STEPS, h)
    _, slope = part.slope(at)
    with np.errstate(all="ignore"):
        out = slope / np.linalg.norm(slope, axis=1)[:, None]
        stayed = np.asarray((np.abs(at - corner - h / 2) < 1.5 * h).all(axis=1))
    other = np.zeros(len(at), np.bool_)
    for beyond in BEYOND:
        tried = at + np.where(here, beyond, -beyond)[:, None] * h * out
        other |= stayed & part.within(tried) & (part.holds(tried) != here)
    return at[other], ~here[other], cells[other], share


def _passed(surface: Surface | None, grid: Grid) -> Flags:
    """Which blocks of the grid hold vertices of the mesh."""
    passed = np.zeros(-(-np.array(grid.shape) // BLOCK), np.bool_)
    if surface is not None:
        for i in range(0, len(surface.vertices), AT_ONCE):
            at = (surface.vertices[i : i + AT_ONCE] - np.array(grid.origin)) / (BLOCK * grid.spacing)
            index = np.clip(at.astype(np.int64), 0, np.array(passed.shape) - 1)
            passed[tuple(index.T)] = True
    return passed


def _open(passed: Flags, grid: Grid, part: Solid) -> tuple[Ints, float]:
    """The cells of the grid away from the mesh, (n, 3), that enclosures leave open; and how many each stands for."""
    shape, each = np.array(grid.shape), 1.0
    side = 1 << int(shape.max() - 1).bit_length()
    blocks = np.zeros((1, 3), np.int64)
    while side > 1 and len(blocks):
        parts = 4 if side % 4 == 0 and len(blocks) * 64 <= MOST and side != 2 * BLOCK else 2
        if len(blocks) * parts**3 > MOST:
            kept = MOST // parts**3
            each *= len(blocks) / kept
            blocks = blocks[np.random.default_rng(side).permutation(len(blocks))[:kept]]
        side //= parts
        steps = np.stack(np.meshgrid(*[np.arange(parts)] * 3, indexing="ij"), -1).reshape(-1, 3)
        blocks = (parts * blocks[:, None] + steps).reshape(-1, 3)
        blocks = blocks[(blocks * side < shape - 1).all(axis=1)]
        if side == BLOCK:
            blocks = blocks[~passed[tuple(blocks.T)]]
        if side == 1:
            for step in np.stack(np.meshgrid(*[(-1, 0, 1)] * 3, indexing="ij"), -1).reshape(-1, 3):
                beside = np.clip(blocks + step, 0, shape - 1) // BLOCK
                blocks = blocks[~passed[tuple(beside.T)]]
        blocks = undecided(blocks, side, grid, part)
    return blocks, each


def undecided(blocks: Ints, side: int, grid: Grid, part: Solid) -> Ints:
    """Of blocks of `side` cells (n, 3) those that enclosures prove neither solid nor void, within the part's box."""
    lo = np.maximum(np.array(grid.origin) + blocks * side * grid.spacing, part.lo)
    hi = np.minimum(np.array(grid.origin) + (blocks + 1) * side * grid.spacing, part.hi)
    some = np.asarray((lo < hi).all(axis=1))
    blocks, lo, hi = blocks[some], lo[some], hi[some]
    if not len(blocks):
        return blocks
    low, high = part.enclosed(lo, hi)
    return blocks[~((low > 0) | (high < 0))]


def _away(passed: Flags, cells: Ints, h: float) -> Floats:
    """How far cells are from the blocks that the mesh passes, in mm, to a block."""
    if not passed.any():
        return np.full(len(cells), np.inf)
    from scipy import ndimage

    distance = np.asarray(ndimage.distance_transform_edt(~passed))
    found: Floats = distance[tuple((cells // BLOCK).T)] * BLOCK * h
    return found
