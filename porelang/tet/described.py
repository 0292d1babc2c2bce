"""What a mesh of tetrahedra is, in numbers; and how far its surface lies from that of the part."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.progress import checkpoint
from porelang.solid import Solid
from porelang.tet.patches import patches, set_name
from porelang.tet.quality import BINS, figures
from porelang.tet.tetmesh import Indices, TetMesh, components, neighbours

Floats = NDArray[np.float64]
_AT_ONCE = 1 << 18  # points that are looked at together


def described(mesh: TetMesh) -> dict[str, Any]:
    """What `pore tet --json` says of a mesh: counts, volumes (mm3), dihedral angles (degrees), areas (mm2) of its named
    surfaces, and in how many pieces each phase is. Volume and components are those of the first phase."""
    beside = neighbours(mesh)
    found = figures(mesh)
    held: dict[str, float] = found.pop("volumes")  # type: ignore[assignment]  # of the figures the only table
    piece = components(mesh, beside)
    phases = {
        set_name(name): {
            "tets": int((mesh.phase == i).sum()),
            "volume": held[name],
            "components": len(np.unique(piece[mesh.phase == i])),
        }
        for i, name in enumerate(mesh.phases)
    }
    first = phases[set_name(mesh.phases[0])]
    return found | {
        "volume": first["volume"],
        "phases": phases,
        "surfaces": {
            patch.name: {"triangles": len(patch.triangles), "area": float(_areas(mesh, patch.triangles).sum())}
            for patch in patches(mesh, beside)
        },
        "dihedral_histogram": {"degrees": BINS.tolist(), "angles": found["dihedral_histogram"]},
        "components": first["components"],
    }


def distances(mesh: TetMesh, solid: Solid) -> dict[str, float]:
    """How far the surface of the first phase lies from where the field of a part is 0, to first order (the value by the
    length of the gradient): at its vertices and the middles of its triangles, the `max` and the `rms` in mm.

    The rms counts each triangle by its area. `unknown` is the share of places where the field has no gradient.
    """
    triangles = np.concatenate([p.triangles for p in patches(mesh) if mesh.phase[p.owners[0]] == 0])
    areas = _areas(mesh, triangles)
    weights = np.bincount(triangles.ravel(), np.repeat(areas / 3, 3), len(mesh.vertices))
    corners = np.flatnonzero(weights > 0)
    places = np.concatenate([mesh.vertices[corners], mesh.vertices[triangles].mean(axis=1)])
    weights = np.concatenate([weights[corners], areas])
    off = np.concatenate([_off(solid, places[i : i + _AT_ONCE]) for i in range(0, len(places), _AT_ONCE)])
    known = np.isfinite(off)
    if not known.any():
        return {"max": float("nan"), "rms": float("nan"), "unknown": 1.0}
    rms = np.sqrt((weights * off**2)[known].sum() / weights[known].sum())
    return {"max": float(off[known].max()), "rms": float(rms), "unknown": 1 - float(known.mean())}


def _off(solid: Solid, places: Floats) -> Floats:
    checkpoint()
    with np.errstate(all="ignore"):
        value, slope = solid.slope(places)
        return np.asarray(np.abs(value) / np.linalg.norm(slope, axis=1))


def _areas(mesh: TetMesh, triangles: Indices) -> Floats:
    corners = mesh.vertices[triangles]
    found: Floats = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    return found
