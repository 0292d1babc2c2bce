"""Vertices moved onto the field: Newton's method along the gradient, with no triangle turned over.

Marching cubes places a vertex by linear interpolation, off by up to the square of the voxel. A few steps
p -= f g / |g|^2 bring it to rounding; the error of the surface between the vertices stays that of flat triangles.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.grid import Point
from porelang.mesh.surface import Surface

Floats = NDArray[np.float64]
#: The field (n,) and its gradient (n, 3) at points (n, 3) in mm, all float64.
Slope = Callable[[Floats], tuple[Floats, Floats]]

STEPS = 12
AT_ONCE = 2**17


@dataclass(frozen=True, slots=True)
class Smoothed:
    """A surface whose vertices were moved onto the field; `off` is the largest distance (mm, f over its slope) that is
    left at a vertex, and `kept` counts the vertices that stayed, as a triangle would have turned over."""

    surface: Surface
    off: float
    kept: int


def smooth(surface: Surface, slope: Slope, voxel: float, box: tuple[Point, Point] | None = None) -> Smoothed:
    """Move every vertex onto the field, by half a `voxel` (mm) at most; those on the caps of `box` stay on them."""
    held = on_caps(surface.vertices, box)
    moved = surface.vertices.copy()
    for i in range(0, len(moved), AT_ONCE):
        moved[i : i + AT_ONCE] = onto(moved[i : i + AT_ONCE], slope, voxel, held[i : i + AT_ONCE])
    away = _doubled(moved)
    if box is not None:
        away |= (((moved <= box[0]) | (moved >= box[1])) & ~held).any(axis=1)
    moved[away] = surface.vertices[away]
    kept = _unturned(surface, moved, away)
    off = 0.0
    for i in range(0, len(moved), AT_ONCE):
        value, gradient = slope(moved[i : i + AT_ONCE])
        gradient[held[i : i + AT_ONCE]] = 0.0
        steep = np.linalg.norm(gradient, axis=1)
        with np.errstate(all="ignore"):
            distance = np.abs(value) / steep
        off = max(off, float(distance[np.isfinite(distance)].max(initial=0.0)))
    return Smoothed(Surface(moved, surface.faces), off, kept)


def on_caps(points: Floats, box: tuple[Point, Point] | None) -> NDArray[np.bool_]:
    """Along which axes (n, 3) points lie exactly on a bound of the box."""
    if box is None:
        return np.zeros(points.shape, np.bool_)
    lo, hi = np.array(box[0]), np.array(box[1])
    caps: NDArray[np.bool_] = (points == lo) | (points == hi)
    return caps


def onto(points: Floats, slope: Slope, voxel: float, held: NDArray[np.bool_] | None = None) -> Floats:
    """Points (n, 3) after Newton steps towards the surface; where a step brings a point no nearer it is halved.

    At the rim of a max or min the slopes on either side differ, and a step may land beyond it: the next one goes back.
    A point ends no more than half a `voxel` from where it began, and does not move along the axes where it is `held`.
    """
    at = points.copy()
    value, gradient = slope(at)
    todo = np.arange(len(at))
    damp = np.ones(len(at))
    for _ in range(STEPS):
        if held is not None:
            gradient[held[todo]] = 0.0
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


def _unturned(surface: Surface, moved: Floats, back: NDArray[np.bool_]) -> int:
    """Put vertices of `moved` back until no triangle is turned over or vanishes, beside those that are `back` already;
    how many are back in all."""
    old = surface.normals()
    size = np.einsum("ij,ij->i", old, old)
    todo = np.arange(len(old))
    while True:
        new = Surface(moved, surface.faces[todo]).normals()
        # Below a thousandth of its old area a triangle may vanish in a file of 32-bit numbers.
        wrong = todo[np.einsum("ij,ij->i", new, old[todo]) <= 1e-3 * size[todo]]
        bad = np.unique(surface.faces[wrong])
        bad = bad[~back[bad]]
        if not len(bad):
            return int(back.sum())
        back[bad] = True
        moved[bad] = surface.vertices[bad]
        todo = np.flatnonzero(back[surface.faces].any(axis=1))
