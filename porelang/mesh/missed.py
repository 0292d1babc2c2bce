"""Whole pieces that a mesh has nothing of: balls, voids and bars that lie between its samples.

Where thin walls run out something always falls between the samples; a piece by itself is another thing, however small.
Cells where the part was found to have something (`lost`, and here also next to the mesh) are sampled again, finer: what
hangs together there, reaches no end of the look and meets no node of the grid is a piece, or a void, that is missing.

A gap is the third thing: where the mesh has closed it two bodies are one. Its sides run parallel, and it has a width
that most of what is as narrow has; where surfaces meet, in wedges and round points of contact, there are all widths
down to 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.grid import Grid
from porelang.mesh.lost import BLOCK, PARALLEL, STEPS, Lost, followed, undecided
from porelang.mesh.surface import AT_ONCE, Surface
from porelang.solid import Solid, onto
from porelang.walls import least

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ints = NDArray[np.int64]
CELLS = 1 << 27  # of a grid: next to the mesh of a larger one nothing is looked for
MOST = 3 << 13  # blocks, and cells, that are enclosed: of more, as many by chance stand for all
NEIGHBOURS = 2.9  # voxels: cells that are nearer are looked at together
FAR, LONG = 1.2, 6  # blocks from the mesh, and voxels: how far rims and fragments are from it, and how long there
MARGIN, FINE = 2, 8  # voxels round them, and samples to a voxel
AGAIN = 32  # samples to a voxel round what seems to be a piece
TILE = 4  # voxels: what is larger is looked at in parts
LEAST = 8  # samples of FINE: less is where a wedge runs out
#: Less is a corner that something cut off a lattice: of an ellipsoid this is 1, a box 0.89, a prism 0.77, any
#: tetrahedron 0.64 (whatever its sides).
ROUND = 0.7
SAMPLES = 1 << 19  # of one look at most
LOOKS = 24
SCAN = 24  # distances at which the other side of a gap is looked for
AROUND = 4  # places looked at round each
NARROW = 0.05  # voxels: what is narrower is a seam of faces that touch, or of balls that touch in a point
MANY = 12  # cells of a gap: fewer are no gap, but where something runs out


@dataclass(frozen=True, slots=True)
class Missed:
    """Pieces that a mesh has nothing of: where their middles are (n, 3) mm, which are `solid` (or voids), how wide each
    is where it is narrowest (mm). There may be more, as in cells that the mesh passes nothing is looked for. And gaps
    that it has closed."""

    middle: Floats
    solid: Flags
    across: Floats
    gaps: tuple[Gap, ...]


@dataclass(frozen=True, slots=True)
class Gap:
    """A gap that a mesh has closed: a place in it, how wide it is where it is narrowest, and how long at least (mm)."""

    at: Floats
    width: float
    length: float


def missed(surface: Surface, grid: Grid, part: Solid, found: Lost) -> Missed:
    """The pieces of a part that its mesh on a grid has nothing of, where it was `found` to lack something or next to
    the mesh."""
    points, solid = found.points, found.solid
    if np.prod(grid.shape) <= CELLS:
        at, kinds, _, _ = followed(beside(surface, grid, part), grid, part)
        points, solid = np.concatenate([points, at]), np.concatenate([solid, kinds])
    pieces: list[tuple[Floats, bool, float]] = []
    looks = 0
    for kind in (True, False):
        some = points[solid == kind]
        groups = groups_of(some, grid.spacing)
        for group in range(int(groups.max(initial=-1)) + 1):
            if looks >= LOOKS:
                break
            looks += 1
            at = some[groups == group]
            for middle, across in _alone(grid, part, at.min(axis=0), at.max(axis=0), kind):
                if all(np.abs(middle - other).max() > grid.spacing / 4 for other, _, _ in pieces):
                    pieces.append((middle, kind, across))
    return Missed(
        np.array([p[0] for p in pieces]).reshape(-1, 3),
        np.array([p[1] for p in pieces], np.bool_),
        np.array([p[2] for p in pieces], np.float64),
        _gaps(points[~solid], grid, part),
    )


def _gaps(points: Floats, grid: Grid, part: Solid) -> tuple[Gap, ...]:
    """The gaps, longer than rims and fragments are, that hold some points (n, 3) mm in cells without a surface."""
    if len(points) < MANY:
        return ()
    # followed from the middles of cells they may all be as far from a line of contact, where the width is that of none
    points = np.repeat(points, AROUND, axis=0)
    aside = np.random.default_rng(0).uniform(-grid.spacing, grid.spacing, points.shape)
    points = onto(part, points + aside, STEPS, grid.spacing)
    points = points[np.isfinite(points).all(axis=1)]
    width, facing, _ = part.walls(points, BLOCK * grid.spacing, SCAN, void=True)
    across = (facing < PARALLEL) & (width < grid.spacing)
    points, width = points[across], width[across]
    groups, found = _joined(points, grid.spacing), []
    for group in np.flatnonzero(np.bincount(groups) >= AROUND * MANY):
        mine, some = points[groups == group], width[groups == group]
        length, narrow = float(np.ptp(mine, axis=0).max()), least(np.sort(some), len(some))
        if narrow is not None and narrow > NARROW * grid.spacing and length > LONG * grid.spacing:
            found.append(Gap(mine[int(np.abs(some - narrow).argmin())], narrow, length))
    return tuple(found)


def far_and_long(found: Lost, grid: Grid) -> bool:
    """Whether what a mesh lacks goes on, away from the mesh, for longer than rims and fragments do: as threads and
    plates."""
    far = found.points[found.away > FAR * BLOCK * grid.spacing]
    groups = _joined(far, grid.spacing)
    return any(
        float(np.ptp(far[groups == group], axis=0).max()) > LONG * grid.spacing
        for group in np.flatnonzero(np.bincount(groups) > LONG)
    )


def beside(surface: Surface, grid: Grid, part: Solid) -> Ints:
    """Cells of the grid (n, 3) that enclosures leave open and that lie in blocks which the mesh passes, or next to such
    blocks, but that it does not pass itself."""
    shape = np.array(grid.shape)
    blocks = -(-shape // BLOCK)
    near, passed = np.zeros(blocks * BLOCK, np.bool_), np.zeros(blocks, np.bool_)
    for i in range(0, len(surface.vertices), AT_ONCE):
        at = (surface.vertices[i : i + AT_ONCE] - np.array(grid.origin)) / grid.spacing + 1e-5
        index = np.clip(at.astype(np.int64), 0, shape - 1)
        near[tuple(index.T)] = True
        passed[tuple((index // BLOCK).T)] = True
    _wider(near, after=False)  # the cells round a vertex on an edge of the grid
    _wider(passed)
    cells, steps = np.argwhere(passed), np.argwhere(np.ones((2, 2, 2)))
    for side in (2, 1):
        cells = (2 * cells[:, None] + steps).reshape(-1, 3)
        lower, upper = cells * side, (cells + 1) * side - 1
        away = ~(near[tuple(lower.T)] & near[tuple(upper.T)]) & (lower < shape - 1).all(axis=1)
        if side == 1:
            away = ~near[tuple(cells.T)] & away
        cells = cells[away]
        if len(cells) > MOST:
            cells = cells[np.random.default_rng(side).permutation(len(cells))[:MOST]]
        cells = undecided(cells, side, grid, part)
    return cells


def _wider(flags: Flags, after: bool = True) -> None:
    """Set what is before something set along any axes, and what is `after` it."""
    for axis in range(3):
        rows = np.moveaxis(flags, axis, 0)
        before = rows.copy()
        rows[:-1] |= before[1:]
        if after:
            rows[1:] |= before[:-1]


def groups_of(points: Floats, voxel: float) -> Ints:
    """The number (n,) of the group of each point, in the order in which they come; a rim goes on and on, and is looked
    at in parts."""
    if not len(points):
        return np.zeros(0, np.int64)
    tiles = np.column_stack([_joined(points, voxel), points // (TILE * voxel)])
    groups = np.unique(tiles, axis=0, return_inverse=True)[1].ravel()
    order = np.full(groups.max() + 1, len(points))
    np.minimum.at(order, groups, np.arange(len(points)))
    ranked: Ints = np.argsort(np.argsort(order))[groups]
    return ranked


def _joined(points: Floats, voxel: float) -> Ints:
    """The number (n,) of the group of each point, of those that are joined by steps of a few voxels."""
    if not len(points):
        return np.zeros(0, np.int64)
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(NEIGHBOURS * voxel, output_type="ndarray")
    links = coo_array((np.ones(len(pairs), np.bool_), tuple(pairs.T)), shape=(len(points), len(points)))
    groups: Ints = connected_components(links, directed=False)[1].astype(np.int64)
    return groups


def _alone(grid: Grid, part: Solid, lo: Floats, hi: Floats, solid: bool) -> list[tuple[Floats, float]]:
    """The middle and the least width of every piece between two corners (mm) that meets no node of the grid."""
    from scipy import ndimage

    h, origin = grid.spacing, np.array(grid.origin)
    first = np.floor((lo - origin) / h).astype(np.int64) - MARGIN
    last = np.ceil((hi - origin) / h).astype(np.int64) + MARGIN
    if np.prod((last - first) * FINE + 1) > SAMPLES:
        return []
    axes = [origin[n] + (first[n] + np.arange((last[n] - first[n]) * FINE + 1) / FINE) * h for n in range(3)]
    label, boxes, alone = _labelled(part, axes, solid)
    nodes = np.unique(label[::FINE, ::FINE, ::FINE])
    out = []
    for piece in np.setdiff1d(alone, nodes):
        box = boxes[piece - 1]
        if np.count_nonzero(label[box] == piece) < LEAST:
            continue
        low = np.array([axes[n][box[n].start] for n in range(3)]) - h / 4
        high = np.array([axes[n][box[n].stop - 1] for n in range(3)]) + h / 4
        counts = np.ceil((high - low) / h * AGAIN).astype(np.int64) + 1
        if np.prod(counts) > SAMPLES:
            continue
        finer = [np.linspace(low[n], high[n], counts[n]) for n in range(3)]
        again, _, closed = _labelled(part, finer, solid)
        if not len(closed):
            continue
        sizes = ndimage.sum_labels(np.ones(again.shape), again, closed)
        mine = np.argwhere(again == closed[int(np.argmax(sizes))])
        if len(mine) < np.count_nonzero(again) / 2:  # of what is here the most goes on beyond
            continue
        if _roundness(mine, counts, high - low) < ROUND:
            continue
        low, high = (np.array([finer[n][i] for n, i in enumerate(end)]) for end in (mine.min(axis=0), mine.max(axis=0)))
        out.append(((low + high) / 2, float((high - low).min() + h / AGAIN)))
    return out


def _roundness(nodes: Ints, counts: Ints, size: Floats) -> float:
    """The volume of the nodes (n, 3) of a grid, as a part of that of the ellipsoid with their moments of inertia."""
    step = size / (counts - 1)
    moments = np.cov(nodes * step, rowvar=False, bias=True) + np.diag(step**2) / 12
    return float(len(nodes) * np.prod(step) / (4 / 3 * np.pi * 5**1.5 * np.sqrt(np.linalg.det(moments))))


def _labelled(part: Solid, axes: list[Floats], solid: bool) -> tuple[NDArray[np.int32], list[tuple[slice, ...]], Ints]:
    """What hangs together on the nodes of three axes, by number; the box of each, and the numbers of those that reach
    no end."""
    from scipy import ndimage

    label, count = ndimage.label(part.on(axes) == solid)
    ends = [label[0], label[-1], label[:, 0], label[:, -1], label[:, :, 0], label[:, :, -1]]
    open_ = np.unique(np.concatenate([end.ravel() for end in ends]))
    return label, ndimage.find_objects(label), np.setdiff1d(np.arange(1, count + 1), open_)
