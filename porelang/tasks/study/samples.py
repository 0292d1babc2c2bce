"""The result of a study in elements as samples on a grid, whose spacing follows the elements."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from porelang.data import SampledField
from porelang.ops.grid import lookup
from porelang.ops.studies import COMPONENTS
from porelang.tasks.readers.cells import Cells
from porelang.tasks.readers.raster import gridded, spacing_of
from porelang.tet.tetmesh import TetMesh

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
#: Nodes of the grid: of eighteen numbers each, 60 MB.
NODES = 800_000
#: A share of lookups, that miss by less than what is said.
_MOST = 0.95
#: What is never below 0, nor where it goes on beyond the part as inside.
_POSITIVE = [COMPONENTS.index(name) for name in ("von_mises", "energy")]


def sampled(mesh: TetMesh, values: Floats) -> tuple[SampledField, float, float, float]:
    """Samples of values (n, `COMPONENTS`) at the vertices of a mesh, and how far outside of it nodes lie; the spacing
    in mm; by how much lookups of the first component miss the elements, `_MOST` of them by less, and which share of the
    others shares a cell with a jump of the material, where one value stands for two.

    They are in float32, as shaders read them.
    """
    middles = mesh.vertices[mesh.tets].mean(axis=1)
    places = np.concatenate([mesh.vertices, middles])
    known = np.concatenate([values, values[mesh.tets].mean(axis=1)])
    tets = mesh.tets.astype(np.int64)
    cells = Cells(mesh.vertices, tets, values, False, places, known, len(tets), 0, 0, True)
    step = spacing_of(cells, NODES)
    whole = gridded(cells, step).part(masked=True)
    kept = np.ascontiguousarray(whole.values, np.float32)
    kept[..., _POSITIVE] = np.maximum(kept[..., _POSITIVE], 0)
    found = replace(whole, values=kept)
    x, y, z = (np.ascontiguousarray(c) for c in places.T)
    missed = np.abs(lookup(found, x, y, z, (COMPONENTS.index("von_mises"), 0, 0, 0)) - known[:, 0])
    off = float(np.quantile(missed, _MOST))
    return found, step, off, float(_beside_jumps(mesh, places[missed >= off], step).mean())


def _beside_jumps(mesh: TetMesh, places: Floats, step: float) -> Flags:
    """Which places (n, 3) share a cell of a grid with a jump: there two vertices of the mesh are at one place."""
    from scipy.spatial import cKDTree

    vertices, count = np.unique(mesh.vertices, axis=0, return_counts=True)
    jumps = vertices[count > 1]
    if not len(jumps):
        return np.zeros(len(places), bool)
    reach = 3**0.5 * step
    return np.asarray(cKDTree(jumps).query(places, distance_upper_bound=reach)[0] <= reach)
