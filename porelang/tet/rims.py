"""Where surfaces meet: the points next to vertices at which two or three branches of a field are 0 at once.

As for meshes of triangles (`porelang.mesh.rims`): a step is the shortest that solves the tangent planes of all; a point
counts only if the whole field is 0 there, and if the surfaces cross. A vertex that is held in planes stays in them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.branches import Branches

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

STEPS = 12
NEAR = 1e-8  # cubes: a point this near to all its surfaces has arrived
HAIR = 1e-5  # cubes: how far beside a point its branch is looked up
INSIDE = 1e-2  # cubes: how far before a plane in which the part ends, which may be a branch too
NUDGE = 1e-7  # cubes: how far inside branches are followed, as a distance may have no slope where it is 0
ON = 1e-5  # cubes
ASKEW = np.array([0.48, 0.36, 0.8])  # no axis, no diagonal: a direction along which few fields tie
CROSSING = np.sin(np.radians(3.0)) ** 2  # surfaces that meet at less are one surface to flat triangles


def unit(vectors: Floats) -> Floats:
    """Vectors (n, 3) at length 1; 0 where there is no direction."""
    with np.errstate(all="ignore"):
        directions = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.where(np.isfinite(directions), directions, 0.0)


def branch_of(points: Floats, field: Branches, cube: Floats) -> Ints:
    """The branch of points (n, 3) on or near the surface, told a hair inside the solid: exactly on it a distance may
    tie. `cube` (n,) is how large cubes are there, in mm."""
    beside = points + HAIR * cube[:, None] * ASKEW
    value, gradient = field.slope(beside)
    with np.errstate(all="ignore"):
        depth = np.nan_to_num(value / np.linalg.norm(gradient, axis=1), posinf=0.0, neginf=0.0)
    depth = np.clip(depth, -0.5 * cube, 0.5 * cube) + 10 * HAIR * cube
    return field.of(beside - depth[:, None] * unit(gradient))


def meet(
    start: Floats, branches: Ints, free: Floats, field: Branches, cube: Floats, reach: float
) -> tuple[Floats, Flags]:
    """The points near `start` (n, 3) where all of their branches (n, k; -1: none) are 0, and which were found, within
    `reach` cubes, which are `cube` (n,) mm large there. `free` (n, 3) is 0 along the axes that a point keeps its place
    on."""
    at = start.copy()
    sure = np.zeros(len(at), np.bool_)
    todo = np.arange(len(at))
    nudge = NUDGE * cube[:, None] * ASKEW
    for _ in range(STEPS):
        large = cube[todo]
        off, normal = _distances(at[todo] + nudge[todo] * free[todo], branches[todo], free[todo], field)
        gram = np.einsum("nki,nli->nkl", normal, normal)
        none = branches[todo] < 0
        for k in range(branches.shape[1]):
            gram[none[:, k], k, k] = 1.0
            off[none[:, k], k] = 0.0
        crossing = np.linalg.det(gram) > CROSSING
        past = 3 * NUDGE * large[:, None] * ~none
        arrived = np.abs(off + past).max(axis=1, initial=0.0) < NEAR * large
        sure[todo[arrived & crossing]] = True
        go = crossing & ~arrived
        todo, off, normal, gram, large = todo[go], off[go] + past[go], normal[go], gram[go], large[go]
        if not len(todo):
            break
        step = -np.einsum("nki,nk->ni", normal, np.linalg.solve(gram, off[:, :, None])[:, :, 0])
        length = np.linalg.norm(step, axis=1)
        at[todo] += step * np.minimum(1.0, large / np.maximum(length, 1e-300))[:, None]
        todo = todo[np.linalg.norm(at[todo] - start[todo], axis=1) <= reach * cube[todo]]
    found = np.flatnonzero(sure)
    sure[found] = _on(at[found], branches[found, 0], field, cube[found])
    sure &= np.linalg.norm(at - start, axis=1) <= reach * cube
    return at, sure


def _on(points: Floats, branch: Ints, field: Branches, cube: Floats) -> Flags:
    """Whether points that are on a branch are on the surface of the whole field, not hidden behind another."""
    value = field.value(points)
    gradient = field.held(points + HAIR * cube[:, None] * ASKEW, branch)[1]
    with np.errstate(all="ignore"):
        off = np.abs(value) / np.linalg.norm(gradient, axis=1)
    on: Flags = (off <= ON * cube) | (value == 0)
    return on


def _distances(at: Floats, branches: Ints, free: Floats, field: Branches) -> tuple[Floats, Floats]:
    """The distances (n, k) to branches, to first order, and their normals (n, k, 3) over the axes that are free."""
    off, normal = np.zeros(branches.shape), np.zeros((*branches.shape, 3))
    for k in range(branches.shape[1]):
        some = np.flatnonzero(branches[:, k] >= 0)
        value, gradient = field.held(at[some], branches[some, k])
        gradient = gradient * free[some]
        with np.errstate(all="ignore"):
            off[some, k] = value / np.linalg.norm(gradient, axis=1)
        normal[some, k] = unit(gradient)
    return np.nan_to_num(off, nan=1e300, posinf=1e300, neginf=-1e300), normal
