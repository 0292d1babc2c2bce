"""Tetrahedra with values, sampled on a regular grid: exactly what they say at each node, and by how much lookups err.

Nodes within tetrahedra have barycentric coordinates in one. The field of those at the border goes on for two steps, so
that what is looked up inside is made of what is inside; farther out, a node has the value of the nearest that is known.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import astuple, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.data import MOST_COUNTED, SampledField
from porelang.ops.grid import lookup
from porelang.parallel import parallel_for, workers
from porelang.progress import tell
from porelang.tasks.readers.asked import Asked
from porelang.tasks.readers.cells import Cells
from porelang.tasks.readers.got import Got
from porelang.tasks.readers.grid import Grid

Array = NDArray[Any]
#: The spacing unless it is given: so much of the shortest edge of a tetrahedron, in the median of all, for there walls
#: are thin; but no more nodes than that.
OF_EDGE = 0.5
NODES = 4_000_000
#: Nodes that a spacing may make: 2 GB of one component.
MOST_NODES = 250_000_000
#: Steps about the border in which distances to it are exact, and the field goes on.
REACH = 2.0
_EDGES = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
_LOOKED_AT = 200_000  # tetrahedra whose edges are measured
_SLABS = 4  # for each thread


def rasterised(asked: Asked, cells: Cells, voxel: float) -> Grid:
    """The cells of a file on a grid, every `voxel` mm, found from them where it is 0. Errors: E152."""
    return gridded(cells, _affordable(asked, cells, voxel))


def _affordable(asked: Asked, cells: Cells, voxel: float) -> float:
    """A voxel (mm), found from the cells where it is 0. Errors: E152 for one that makes too many nodes."""
    low, high = _box(cells)
    size = high - low
    step = voxel or spacing_of(cells)
    counts = np.maximum(np.ceil(size / step - 1e-9), 1)
    components = cells.values.shape[1]
    if np.prod(counts + 3) * (components + 1) > MOST_NODES or counts.max() > MOST_COUNTED - 3:
        enough = max((float(np.prod(size)) * (components + 1) / MOST_NODES) ** (1 / 3), size.max() / MOST_COUNTED)
        text = f"a voxel of {step:g} mm makes {np.prod(counts + 3):.2g} nodes of the cells of `{asked.path}`"
        raise asked.fail("E152", text, f"take one of {1.1 * enough:.2g} mm or more, or leave `voxel` out")
    return step


def gridded(cells: Cells, step: float) -> Grid:
    """The grid over the box of the cells and a layer more, its nodes on the faces of that box, `step` mm apart."""
    from porelang.tasks.readers import raster_loops as loops

    low, high = _box(cells)
    size = high - low
    counts = np.maximum(np.ceil(size / step - 1e-9), 1)
    components = cells.values.shape[1]
    spacing = size / counts
    origin = low - spacing
    nx, ny, nz = (int(n) + 3 for n in counts)
    values = np.ascontiguousarray(cells.values, np.float64)
    out = np.zeros((nx, ny, nz, components))
    inside = np.zeros((nx, ny, nz), np.bool_)
    tetrahedra = np.ascontiguousarray(cells.tetrahedra, np.int64)
    u = (cells.points - origin) / spacing
    _in_slabs(nx, 0, lambda a, b: loops.fill(u, tetrahedra, values, cells.in_cells, a, b, inside, out))
    faces, owner = border(cells.points, tetrahedra)
    reach = REACH * float(spacing.max())
    square = np.full(inside.shape, np.inf)
    nearest = np.full(inside.shape, -1, np.int32)
    points = np.ascontiguousarray(cells.points, np.float64)
    _in_slabs(nx, 1, lambda a, b: loops.near(points, faces, origin, spacing, reach, a, b, square, nearest))
    known = np.zeros(inside.shape, np.bool_)
    _in_slabs(nx, 2, lambda a, b: loops.extend(
        points, tetrahedra, faces, owner, values, cells.in_cells, origin, spacing, a, b, inside, nearest, known, out
    ))  # fmt: skip
    if not known.all():
        from scipy.ndimage import distance_transform_edt

        at = distance_transform_edt(~known, spacing, return_distances=False, return_indices=True)
        unknown = ~known
        out[unknown] = out[tuple(i[unknown] for i in at)]
    depth = np.minimum(np.sqrt(square, out=square), reach, out=square)
    np.negative(depth, out=depth, where=inside)
    grid = Grid(SampledField.from_array(out, origin.tolist(), spacing.tolist()), depth)
    got = _got(cells, grid, step, (low, high))
    return replace(grid, samples=replace(grid.samples, facts=tuple(map(float, astuple(got)))))


def _box(cells: Cells) -> tuple[Array, Array]:
    used = np.unique(cells.tetrahedra)
    return cells.points[used].min(axis=0), cells.points[used].max(axis=0)


def spacing_of(cells: Cells, nodes: int = NODES) -> float:
    """The spacing for tetrahedra of such edges, of no more nodes than some."""
    low, high = _box(cells)
    some = cells.tetrahedra[:: max(1, len(cells.tetrahedra) // _LOOKED_AT)]
    edges = [np.linalg.norm(cells.points[some[:, a]] - cells.points[some[:, b]], axis=1) for a, b in _EDGES]
    return float(max(OF_EDGE * np.median(np.min(edges, axis=0)), (np.prod(high - low) / nodes) ** (1 / 3)))


def _in_slabs(layers: int, part: int, work: Callable[[int, int], None]) -> None:
    """Work on all layers, some at a time, on all threads."""
    threads = workers()
    width = math.ceil(layers / (_SLABS * threads))
    starts = list(range(0, layers, width))
    for i in range(0, len(starts), threads):
        tell(part * len(starts) + i, 3 * len(starts))
        parallel_for(lambda a: work(a, min(a + width, layers)), starts[i : i + threads], threads)


def border(points: Array, tetrahedra: Array) -> tuple[Array, Array]:
    """The faces (f, 3) that only one tetrahedron has, and which that is (f,).

    Points at the same place are one: programs write a point once for each cell, or for each part of a mesh.
    """
    order = np.lexsort(points.T)
    here = points[order]
    new = np.ones(len(points), np.int64)
    new[1:] = (here[1:] != here[:-1]).any(axis=1)
    number = np.empty(len(points), np.int64)
    number[order] = np.cumsum(new) - 1
    faces = tetrahedra[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]].reshape(-1, 3)
    merged = np.sort(number[faces], axis=1)
    a, b, c = merged.T
    order = np.lexsort((c, a * (int(number.max()) + 1) + b))
    listed = merged[order]
    same = np.zeros(len(faces) + 1, np.bool_)
    same[1:-1] = (listed[1:] == listed[:-1]).all(axis=1)
    alone = order[~same[1:] & ~same[:-1]]
    return np.ascontiguousarray(faces[alone]), alone // 4


def _got(cells: Cells, grid: Grid, step: float, box: tuple[Array, Array]) -> Got:
    """What lookups in the samples of cells in a box have come to."""
    samples = grid.samples
    x, y, z = (np.ascontiguousarray(c) for c in cells.places.T)
    error = np.zeros(len(x))
    least_there, most_there = _ends(cells.places, cells.known)
    for k in range(samples.components):
        found = lookup(samples, x, y, z, (k, 0, 0, 0))
        error = np.maximum(error, np.maximum(least_there[:, k] - found, found - most_there[:, k]))
    worst, most = float(np.quantile(error, 0.95)), float(error.max())
    least, greatest = float(cells.known.min()), float(cells.known.max())
    found_of = (step, worst, most, least, greatest, _lost(cells, grid))
    return Got(cells.count, cells.left, *found_of, cells.corners, cells.named, *box[0], *box[1])


def _ends(places: Array, known: Array) -> tuple[Array, Array]:
    """The least and the greatest value (m, k) that is known at each place: at a jump there are several, and a lookup
    between them is none of them wrong."""
    order = np.lexsort(places.T)
    new = np.ones(len(places), np.bool_)
    new[1:] = (places[order][1:] != places[order][:-1]).any(axis=1)
    group = np.empty(len(places), np.int64)
    group[order] = np.cumsum(new) - 1
    starts = np.flatnonzero(new)
    least, most = (of.reduceat(known[order], starts, axis=0)[group] for of in (np.minimum, np.maximum))
    return least, most


def _lost(cells: Cells, grid: Grid) -> float:
    """The share of tetrahedra in whose middles the samples of their depth say that they lie outside."""
    assert grid.depth is not None
    some = cells.tetrahedra[:: max(1, len(cells.tetrahedra) // _LOOKED_AT)]
    x, y, z = (np.ascontiguousarray(c) for c in cells.points[some].mean(axis=1).T)
    away = lookup(replace(grid.samples, values=grid.depth[..., None]), x, y, z, (0, 0, 0, 0))
    return float(np.mean(away > 1e-9 * max(grid.samples.spacing)))
