"""Where surfaces meet: points on two or three branches of a field at once, found by Newton's method.

A step is the shortest that solves the equations' tangent planes (two planes: a line is met squarely). A point counts
only if the whole field is 0 there, so that the rim is the part's and not hidden in it, and if the branches cross.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

STEPS = 16
NEAR = 1e-9  # voxels: a point this near to all its surfaces has arrived
EVEN = 0.1  # the least part of an edge on either side of a rim, so that edges from one vertex cross it apart
HAIR = 1e-5  # voxels: how far beside a point its branch is looked up
NUDGE = 1e-7  # voxels: how far inside branches are followed
ASKEW = np.array([0.48, 0.36, 0.8])  # no axis, no diagonal: a direction along which few fields tie
REACH = 3.0  # voxels: how far beyond a chamfer the rim of a thin wedge may be
CROSSING = np.sin(np.radians(1.0)) ** 2  # surfaces that meet at less are one surface to a mesh of flat triangles


class Branched(Protocol):
    """A field, and its smooth branches by number; see `porelang.analysis.branches`."""

    count: int

    def value(self, points: Floats) -> Floats: ...
    def slope(self, points: Floats) -> tuple[Floats, Floats]: ...
    def of(self, points: Floats) -> Ints: ...
    def held(self, points: Floats, numbers: Ints) -> tuple[Floats, Floats]: ...


def unit(vectors: Floats) -> Floats:
    """Vectors (n, 3) at length 1; 0 where there is no direction."""
    with np.errstate(all="ignore"):
        directions = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.where(np.isfinite(directions), directions, 0.0)


def branch_of(points: Floats, field: Branched, voxel: float) -> Ints:
    """The branch of points on or near the surface, told a hair inside the solid: exactly on it a distance may tie."""
    beside = points + HAIR * voxel * ASKEW
    value, gradient = field.slope(beside)
    with np.errstate(all="ignore"):
        depth = np.nan_to_num(value / np.linalg.norm(gradient, axis=1), posinf=0.0, neginf=0.0)
    depth = np.clip(depth, -0.5 * voxel, 0.5 * voxel) + 10 * HAIR * voxel
    return field.of(beside - depth[:, None] * unit(gradient))


def off_surface(points: Floats, branch: Ints, field: Branched, voxel: float) -> Floats:
    """The distances (n,) of points on or near a branch from the surface of the whole field, to first order.

    The field's own gradient may be a sum of two there, or 0, where a distance ties: that of the branch is sound, a hair
    beside.
    """
    value = field.value(points)
    gradient = field.held(points + HAIR * voxel * ASKEW, branch)[1]
    with np.errstate(all="ignore"):
        off: Floats = np.abs(value) / np.sqrt(np.einsum("ij,ij->i", gradient, gradient))
    off[value == 0] = 0.0
    return off


def on_surface(points: Floats, branch: Ints, field: Branched, voxel: float) -> Flags:
    """Whether points that are on a branch are on the surface of the whole field, not hidden behind another branch."""
    on: Flags = off_surface(points, branch, field, voxel) <= 1e-6 * voxel
    return on


def meet(start: Floats, branches: Ints, field: Branched, voxel: float, reach: float = REACH) -> tuple[Floats, Flags]:
    """The points near `start` (n, 3) where all of their branches (n, k) are 0, and which were found; k is 1, 2 or 3.

    The branches are followed to a hair inside, and the rest is one straight step: a branch may be a distance without a
    sign, which has no slope where it is 0.
    """
    at = start + NUDGE * voxel * ASKEW
    sure = np.zeros(len(at), np.bool_)
    todo = np.arange(len(at))
    inside = 3 * NUDGE * voxel
    for _ in range(STEPS):
        off, normal = _distances(at[todo], branches[todo], field)
        off += inside
        arrived = np.abs(off).max(axis=1, initial=0.0) < NEAR * voxel
        crossing = _independence(normal) > CROSSING
        off[arrived] = -inside
        sure[todo[arrived & crossing]] = True
        todo, off, normal = todo[crossing], off[crossing], normal[crossing]
        if not len(todo):
            break
        gram = np.einsum("nki,nli->nkl", normal, normal)
        step = -np.einsum("nki,nk->ni", normal, np.linalg.solve(gram, off[:, :, None])[:, :, 0])
        length = np.linalg.norm(step, axis=1)
        step *= np.minimum(1.0, voxel / np.maximum(length, 1e-300))[:, None]
        at[todo] += step
        left = ~sure[todo] & (np.linalg.norm(at[todo] - start[todo], axis=1) <= reach * voxel)
        todo = todo[left]
    found = np.flatnonzero(sure)
    sure[found] = on_surface(at[found], branches[found, 0], field, voxel)
    return at, sure


def _distances(at: Floats, branches: Ints, field: Branched) -> tuple[Floats, Floats]:
    """The distances (n, k) to branches, to first order, and their unit normals (n, k, 3)."""
    off = np.empty(branches.shape)
    normal = np.empty((*branches.shape, 3))
    for k in range(branches.shape[1]):
        value, gradient = field.held(at, branches[:, k])
        with np.errstate(all="ignore"):
            off[:, k] = value / np.linalg.norm(gradient, axis=1)
        normal[:, k] = unit(gradient)
    return np.nan_to_num(off, nan=np.inf), normal


def _independence(normal: Floats) -> Floats:
    """The squared sine of the angle between two normals, or the squared volume that three span."""
    gram = np.einsum("nki,nli->nkl", normal, normal)
    independence: Floats = np.linalg.det(gram)
    return independence


def rim(ends: Floats, branches: Ints, field: Branched, voxel: float) -> tuple[Floats, Flags]:
    """Where edges (n, 2, 3) of the mesh, whose ends are on the two branches (n, 2), cross the rim; which do.

    Unfolded flat along the rim, the edge is straight: it crosses between the feet of its ends in the ratio of their
    distances. So edges that do not cross one another cross the rim in order, and no triangle turns over.
    """
    count = len(ends)
    feet, known = meet(ends.reshape(-1, 3), np.repeat(branches, 2, axis=0), field, voxel)
    feet, known = feet.reshape(count, 2, 3), known.reshape(count, 2)
    away = np.where(known, np.linalg.norm(ends - feet, axis=2), np.inf)
    both: Flags = np.asarray(known.all(axis=1))
    with np.errstate(all="ignore"):
        part = np.where(both, away[:, 0] / (away[:, 0] + away[:, 1]), 0.5)
    part = np.clip(np.nan_to_num(part, nan=0.5), EVEN, 1 - EVEN)[:, None]
    base = np.where(both[:, None, None], feet, ends)
    start = base[:, 0] + part * (base[:, 1] - base[:, 0])
    return meet(start, branches, field, voxel)
