"""Gaps of a part that its tetrahedra have closed: a slit narrower than a cube lies between the cube's corners."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.diagnostics import Diagnostic
from porelang.solid import Solid
from porelang.tet.tetmesh import TetMesh
from porelang.walls import Thinnest, gaps_at, on_surface, rounded

Floats = NDArray[np.float64]
#: Cubes to a gap that is to be there.
_TWO = 2


def closed_gap(part: Solid, mesh: TetMesh, size: float) -> Thinnest | None:
    """The narrowest gaps of a part, if they are narrower than cubes of a size (mm) and tetrahedra lie in their middle;
    `at` is that place (3,), mm. Where surfaces meet in wedges there are all widths down to 0, and that is no gap."""
    found = gaps_at(part, on_surface(part), size)
    if found is None:
        return None
    _, slope = part.slope(found.at[None])
    middle = found.at + found.wall / 2 * slope[0] / np.linalg.norm(slope[0])
    return Thinnest(found.wall, middle) if _holds(mesh, middle) else None


def closed(part: Solid, mesh: TetMesh, size: float) -> list[Diagnostic]:
    """W254 where the narrowest gaps are closed, with a place."""
    found = closed_gap(part, mesh, size)
    if found is None:
        return []
    x, y, z = found.at
    return [
        Diagnostic(
            "W254",
            f"gaps {found.wall:.3g} mm wide, as at ({x:.4g}, {y:.4g}, {z:.4g}), lie within cubes of {size:.3g} mm and "
            "are closed: what is on both sides of them is joined",
            hint=f"take a --size of {rounded(found.wall / _TWO)} mm, or make the gap wider, or leave it out",
            severity="warning",
        )
    ]


def _holds(mesh: TetMesh, at: Floats) -> bool:
    """Whether a place (3,) lies in a tetrahedron of the solid."""
    corners = mesh.vertices[mesh.tets[mesh.phase == 0]]
    some = corners[((corners.min(axis=1) <= at) & (at <= corners.max(axis=1))).all(axis=1)]
    if not len(some):
        return False
    edges = (some[:, 1:] - some[:, :1]).transpose(0, 2, 1)
    parts = np.linalg.solve(edges, (at - some[:, 0])[..., None])[..., 0]
    return bool(((parts >= -1e-9).all(axis=1) & (parts.sum(axis=1) <= 1 + 1e-9)).any())
