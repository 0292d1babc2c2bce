"""Whether samples join what is apart in a part: two pieces with a narrow gap between them, two voids with a thin wall.

Where something of the part lies between samples that are all of the other sign, and next to the mesh too, the part is
sampled again, finer. Two nodes of the grid that are neighbours, and so one in the mesh, and that no way joins there,
are parted by it: perhaps they are one further away, and perhaps they are not. Ways keep off the surface by a step of
the finer samples, so that a gap may be as narrow as it likes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.grid import Grid
from porelang.mesh.lost import followed
from porelang.mesh.missed import CELLS, beside, groups_of
from porelang.mesh.surface import Surface
from porelang.solid import Solid

Floats = NDArray[np.float64]
LOOKS = 24  # of more, as many by chance
#: Cells round the mesh (of more, as many by chance), samples along an edge, and steps towards the least of them.
EDGES, ALONG, CLOSER = 1 << 16, 7, 24
#: Samples to a voxel, and voxels round the place: what is parted at the first look is looked at again, from further.
FINE, MARGINS = 8, (2, 5)
SAMPLES = 1 << 21  # of one look at most
OFF = 0.87  # steps from the surface, half the diagonal of a cell: what is further off has nothing else in its cell


def parted(surface: Surface, grid: Grid, part: Solid) -> bool:
    """Whether nodes of the grid that the mesh of a part joins are apart in the part, as far as is seen near them."""
    if np.prod(grid.shape) > CELLS:
        return False
    points, solid, _, _ = followed(beside(surface, grid, part), grid, part)
    more, kinds = _on_edges(surface, grid, part)
    points, solid = np.concatenate([points, more]), np.concatenate([solid, kinds])
    for kind in (False, True):
        some = points[solid == kind]
        groups = groups_of(some, grid.spacing)
        order = np.random.default_rng(0).permutation(int(groups.max(initial=-1)) + 1)
        for group in order[:LOOKS]:
            at = some[groups == group]
            lo, hi = at.min(axis=0), at.max(axis=0)
            if all(_between(grid, part, lo, hi, kind, margin) for margin in MARGINS):
                return True
    return False


def _on_edges(surface: Surface, grid: Grid, part: Solid) -> tuple[Floats, NDArray[np.bool_]]:
    """Points (n, 3) mm on edges of the grid round the mesh whose two nodes are of the other sign; which are solid."""
    cells = np.unique(
        np.floor((surface.vertices - np.array(grid.origin)) / grid.spacing + 1e-5).astype(np.int64), axis=0
    )
    if len(cells) > EDGES:
        cells = cells[np.random.default_rng(1).permutation(len(cells))[:EDGES]]
    nodes = np.array(grid.origin) + cells * grid.spacing
    found, kinds = [], []
    for axis in np.eye(3):
        ends = nodes[:, None] + np.linspace(0, grid.spacing, ALONG)[:, None] * axis
        inner = part.within(ends[:, 0]) & part.within(ends[:, -1])
        values = part.value(ends[inner].reshape(-1, 3)).reshape(-1, ALONG)
        some = (values[:, 0] < 0) == (values[:, -1] < 0)
        start, values = nodes[inner][some], values[some]
        side = np.where(values[:, 0] < 0, -1.0, 1.0)  # above 0 is what both nodes are
        values = values * side[:, None]
        nearest = values[:, 1:-1].argmin(axis=1) + 1
        least = values[np.arange(len(values)), nearest]
        near = least <= np.abs(np.diff(values, axis=1)).max(axis=1, initial=0.0)
        start, side, t, least = start[near], side[near], nearest[near] / (ALONG - 1.0), least[near]
        step = 1 / (ALONG - 1)
        for _ in range(CLOSER):  # towards the least value, by steps to both sides that get shorter
            step *= 0.7
            for tried in (t - step, t + step):
                value = side * part.value(start + (tried * grid.spacing)[:, None] * axis)
                lower = (value < least) & (tried > 0) & (tried < 1)
                t, least = np.where(lower, tried, t), np.where(lower, value, least)
        other = (least < 0) | ((least == 0) & (side < 0))
        found.append(start[other] + (t[other] * grid.spacing)[:, None] * axis)
        kinds.append(side[other] > 0)
    return np.concatenate(found), np.concatenate(kinds)


def _between(grid: Grid, part: Solid, lo: Floats, hi: Floats, solid: bool, margin: int) -> bool:
    """Whether something `solid`, or void, between two corners (mm) parts neighbouring nodes of the other kind."""
    from scipy import ndimage

    h, origin = grid.spacing, np.array(grid.origin)
    first = np.floor((lo - origin) / h).astype(np.int64) - margin
    last = np.ceil((hi - origin) / h).astype(np.int64) + margin
    if np.prod((last - first) * FINE + 1) > SAMPLES:
        return False
    axes = [origin[n] + (first[n] + np.arange((last[n] - first[n]) * FINE + 1) / FINE) * h for n in range(3)]
    values = part.values_on(axes) if solid else -part.values_on(axes)
    with np.errstate(all="ignore"):
        steep = np.sqrt(sum(np.square(along) for along in np.gradient(values)))
        label, _ = ndimage.label(values > OFF * steep)
    inner = slice(margin * FINE, -margin * FINE)
    nodes = label[inner, inner, inner][::FINE, ::FINE, ::FINE]
    for axis in range(3):
        rows = np.moveaxis(nodes, axis, 0)
        one, other = rows[:-1], rows[1:]
        if np.any((one > 0) & (other > 0) & (one != other)):
            return True
    return False
