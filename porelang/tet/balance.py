"""The volume of a part with curved walls: vertices leave the surface by as much as flat triangles cut off.

Vertices on a curved surface make a mesh too small where it bulges and too large where it is hollow: at ten cubes to a
period a gyroid sheet comes out 1.7 % too thick. Between its corners a triangle is off the surface by a quadratic, to
first order, the mean of which is that at the middles of its sides. So each vertex moves along the normal by the mean of
its triangles, weighted by area: what all of them take in is then what all of them cut off. Vertices on rims stay.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.branches import Branches
from porelang.progress import tell
from porelang.tet.moving import Stars, shifted
from porelang.tet.rims import unit
from porelang.tet.sharp import common

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Indices = NDArray[np.int32]
Flags = NDArray[np.bool_]

MOST = 0.15  # cubes: what is further off the surface is no bend of it
STEEP = 0.3  # the least part of the normal that lies in a plane, if a vertex is to move in that
LEAST = 13.0  # degrees: dihedral angles that this may leave, where they were no smaller before


def balance(
    at: Floats, tets: Indices, around: Stars, triangles: Indices, on: Ints, free: Flags, field: Branches, cube: Floats
) -> float:
    """Move vertices (n, 3), in place, of the surface that `triangles` (k, 3) make so that its volume is that of the
    part; the largest distance (mm) that one moved. `on` (n, 3) are the branches that each is on, -1 for none; it moves
    along the axes that are `free` (n, 3); `cube` (n,) is how large cubes are there, in mm."""
    branch = common(on, triangles)
    triangles, branch = triangles[branch >= 0], branch[branch >= 0]
    tell(0, 3)
    off, most = np.zeros(len(triangles)), MOST * cube[triangles].min(axis=1)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        off += np.clip(_outward(at[triangles[:, [a, b]]].mean(axis=1), branch, field)[0], -most, most) / 3
    tell(1, 3)
    corners = at[triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    single = (on >= 0).sum(axis=1) == 1
    some = np.unique(triangles)
    some = some[single[some]]
    _, normal = _outward(at[some], on[some, 0], field)
    way = unit(normal * free[some])
    part = np.einsum("ij,ij->i", way, normal)
    can = np.zeros(len(at), np.bool_)
    can[some] = part > STEEP
    many = can[triangles].sum(axis=1)
    share = np.where(many > 0, 3 * area * off / np.maximum(many, 1), 0.0)
    weight, total = np.zeros(len(at)), np.zeros(len(at))
    for k in range(3):
        weight += np.bincount(triangles[:, k], area, len(at))
        total += np.bincount(triangles[:, k], share, len(at))
    keep = can[some]
    some, way, part = some[keep], way[keep], part[keep]
    by = np.clip(total[some] / weight[some], -MOST * cube[some], MOST * cube[some]) / part
    tell(2, 3)
    return float(
        shifted(at, tets, around.start, around.of, some, at[some] + by[:, None] * way, np.cos(np.radians(LEAST)))
    )


def _outward(points: Floats, branch: Ints, field: Branches) -> tuple[Floats, Floats]:
    """How far (n,) outward of points the surface of their branch is, in mm, to first order; and its normals (n, 3)."""
    value, gradient = field.held(points, branch) if field.count else field.slope(points)
    with np.errstate(all="ignore"):
        off = -value / np.linalg.norm(gradient, axis=1)
    return np.nan_to_num(off, nan=0.0, posinf=0.0, neginf=0.0), unit(gradient)
