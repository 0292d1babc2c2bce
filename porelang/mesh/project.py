"""Vertices moved onto the field: Newton's method along the gradient, with no triangle turned over.

Marching cubes places a vertex by linear interpolation, off by up to the square of the voxel. A few steps
p -= f g / |g|^2 bring it to rounding; the error of the surface between the vertices stays that of flat triangles.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.crossed import crossed
from porelang.mesh.crossing import crossings
from porelang.mesh.layers import Layers
from porelang.mesh.surface import Surface

Floats = NDArray[np.float64]
#: The field (n,) and its gradient (n, 3) at points (n, 3) in mm, all float64.
Slope = Callable[[Floats], tuple[Floats, Floats]]

STEPS = 12
LEAST = 1e-9  # voxels: what is nearer than this is on the surface
GRADIENT, EDGE, STAY = range(3)  # the ways of a vertex
AT_ONCE = 2**17


@dataclass(frozen=True, slots=True)
class Smoothed:
    """A surface whose vertices were moved onto the field; `off` is the largest distance (mm, f over its slope) that is
    left at a vertex, and `kept` counts the vertices that stayed, as a triangle would have turned over."""

    surface: Surface
    off: float
    kept: int


def smooth(surface: Surface, slope: Slope, layers: Layers) -> Smoothed:
    """Move every vertex onto the field, by half a voxel at most; those on caps of `layers` stay on them.

    Where a step along the gradient would turn a triangle over, the vertex moves along its edge of the grid instead.
    """
    raw, voxel = surface.vertices, layers.grid.spacing
    on_cap = capped(raw, layers)
    moved = raw.copy()
    free = np.flatnonzero(~on_cap)
    for i in range(0, len(free), AT_ONCE):
        some = free[i : i + AT_ONCE]
        moved[some] = onto(raw[some], slope, voxel)
    away = _doubled(moved) | (capped(moved, layers) & ~on_cap)
    away |= distances(moved, slope) > LEAST * voxel  # between two surfaces a step may find no way down
    way = np.where(on_cap | away, EDGE, GRADIENT)
    on_edge = np.zeros(len(raw), np.bool_)

    def follow(some: NDArray[np.int64]) -> None:
        place, sure = crossings(raw[some], layers, lambda points: slope(points)[0])
        moved[some] = place
        on_edge[some] = sure

    follow(np.flatnonzero(way == EDGE))
    _turn_back(surface, moved, way, follow)
    _uncross(surface, moved, way, follow)
    goal = ~on_cap
    goal[on_edge] = True
    off = np.minimum(distances(moved, slope), voxel)  # of an edge of the grid, however flat the field is
    return Smoothed(
        Surface(moved, surface.faces), float(off[goal].max(initial=0.0)), int((goal & (off > LEAST * voxel)).sum())
    )


def capped(points: Floats, layers: Layers) -> NDArray[np.bool_]:
    """The points (n, 3) on, or beyond, the box that the surface was cut at."""
    out = np.zeros(len(points), np.bool_)
    for axis, at in zip(layers.axes, points.T, strict=True):
        out |= (at <= axis.lo) | (at >= axis.hi)
    return out


def distances(points: Floats, slope: Slope) -> Floats:
    """The distances (n,) of points from the field's surface, to first order; 0 where the field has no slope."""
    off = np.zeros(len(points))
    for i in range(0, len(points), AT_ONCE):
        value, gradient = slope(points[i : i + AT_ONCE])
        with np.errstate(all="ignore"):
            off[i : i + AT_ONCE] = np.abs(value) / np.sqrt(np.einsum("ij,ij->i", gradient, gradient))
    off[~np.isfinite(off)] = 0.0
    return off


def onto(points: Floats, slope: Slope, voxel: float) -> Floats:
    """Points (n, 3) after Newton steps towards the surface; where a step brings a point no nearer it is halved.

    At the rim of a max or min the slopes on either side differ, and a step may land beyond it: the next one goes back.
    A point ends no more than half a `voxel` from where it began.
    """
    at = points.copy()
    value, gradient = slope(at)
    todo = np.arange(len(at))
    damp = np.ones(len(at))
    for _ in range(STEPS):
        steep = np.einsum("ij,ij->i", gradient, gradient)
        with np.errstate(all="ignore"):
            step = -(damp[todo] * value / steep)[:, None] * gradient
        length = np.linalg.norm(step, axis=1)
        usable = (length > 1e-13 * voxel) & np.isfinite(length)
        todo, value, gradient, step, length = (a[usable] for a in (todo, value, gradient, step, length))
        if not len(todo):
            break
        step *= np.minimum(1.0, 0.5 * voxel / length)[:, None]
        tried = at[todo] + step
        there, slope_there = slope(tried)
        better = np.abs(there) < np.abs(value)
        better &= np.linalg.norm(tried - points[todo], axis=1) <= 0.5 * voxel
        at[todo[better]] = tried[better]
        value[better], gradient[better] = there[better], slope_there[better]
        damp[todo] = np.where(better, 1.0, damp[todo] / 2)
    return at


def _doubled(points: Floats) -> NDArray[np.bool_]:
    """The points (n, 3) that would lie on another in a file of 32-bit numbers."""
    _, which, count = np.unique(points.astype(np.float32), axis=0, return_inverse=True, return_counts=True)
    doubled: NDArray[np.bool_] = count[which.ravel()] > 1
    return doubled


def _uncross(
    surface: Surface, moved: Floats, way: NDArray[np.int64], follow: Callable[[NDArray[np.int64]], None]
) -> None:
    """Send vertices of `moved` another `way` until the mesh runs through itself no more than it did.

    Newton's method may carry the vertices of two sheets, less than a voxel apart, past each other. On its edge of the
    grid each stays between the samples that tell the sheets apart.
    """
    some: NDArray[np.int64] | None = None
    while some is None or len(some):
        now = Surface(moved, surface.faces)
        bad = np.unique(surface.faces[crossed(now, some)])
        bad = bad[way[bad] != STAY]
        if not len(bad):
            return
        before = moved.copy()
        way[bad] += 1
        follow(bad[way[bad] == EDGE])
        stay = bad[way[bad] == STAY]
        moved[stay] = surface.vertices[stay]
        _turn_back(surface, moved, way, follow)
        some = np.flatnonzero((moved != before).any(axis=1)[surface.faces].any(axis=1))


def _turn_back(
    surface: Surface, moved: Floats, way: NDArray[np.int64], follow: Callable[[NDArray[np.int64]], None]
) -> None:
    """Send vertices of `moved` another `way` until no triangle is turned over or vanishes.

    From the gradient to their edge of the grid (`follow` moves them), and from there back to where they were.
    """
    old = surface.normals()
    size = np.einsum("ij,ij->i", old, old)
    todo = np.arange(len(old))
    while len(todo):
        new = Surface(moved, surface.faces[todo]).normals()
        # Below a thousandth of its old area a triangle may vanish in a file of 32-bit numbers.
        wrong = surface.faces[todo[np.einsum("ij,ij->i", new, old[todo]) <= 1e-3 * size[todo]]]
        first = (way[wrong] == GRADIENT).any(axis=1)
        change = np.zeros(len(moved), np.bool_)
        for some, now in ((wrong[first], GRADIENT), (wrong[~first], EDGE)):
            bad = np.unique(some)
            bad = bad[way[bad] == now]
            change[bad] = True
            way[bad] = now + 1
            if now == GRADIENT:
                follow(bad)
            else:
                moved[bad] = surface.vertices[bad]
        todo = np.flatnonzero(change[surface.faces].any(axis=1))
