"""Slivers: tetrahedra with an angle that stuffing does not leave among cubes of one size.

Most lie where cubes of two sizes meet, and are gone where these are halved. What is left are kites that lie flat on the
surface, with all four corners on it: two triangles of the surface on one side, two on the other. Without such a one the
surface goes along its other side, and misses a volume of nothing.
"""

from __future__ import annotations

import numpy as np

from porelang.tet.moving import poor
from porelang.tet.tetmesh import ALONE, Indices, TetMesh, boundary, neighbours

LEAST = 10.7  # degrees (Labelle & Shewchuk 2007): a dihedral angle below that, or an obtuse one as bad


def without_kites(mesh: TetMesh, beside: Indices) -> tuple[TetMesh, Indices, Indices]:
    """A mesh without the slivers that lie flat on its outer surface, its neighbours, and the slivers (k, 4) that are
    left. With the void meshed too none is left out: together the phases fill their box."""
    every = np.flatnonzero(poor(mesh.vertices, mesh.tets, np.cos(np.radians(LEAST))))
    some = every[(beside[every] == ALONE).sum(axis=1) == 2]
    if not len(some) or len(mesh.phases) > 1:
        return mesh, beside, mesh.tets[every]
    outside = beside[some] == ALONE
    corners = mesh.tets[some]
    # two faces share the edge of the corners that neither is opposite to: it goes, and that of the two others comes
    comes = np.sort(corners[outside].reshape(-1, 2), axis=1)
    triangles, _ = boundary(mesh, beside)
    there = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    new = ~np.isin(comes[:, 0] * len(mesh.vertices) + comes[:, 1], there[:, 0] * len(mesh.vertices) + there[:, 1])
    gone = np.zeros(len(mesh.tets), np.bool_)
    touched = np.zeros(len(mesh.vertices), np.bool_)
    for t, at in zip(some[new], corners[new], strict=True):
        if not touched[at].any():  # of two that touch the one may need the other
            gone[t], touched[at] = True, True
    left = mesh.tets[every[~gone[every]]]
    if gone.any():
        mesh = TetMesh(mesh.vertices, mesh.tets[~gone], mesh.phase[~gone], mesh.phases)
        beside = neighbours(mesh)
    return mesh, beside, left
