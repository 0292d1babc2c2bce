"""The named surfaces of a mesh of tetrahedra: where each phase ends outside, and where two phases meet."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.tet.tetmesh import ALONE, FACES, Indices, TetMesh, neighbours


@dataclass(frozen=True, slots=True)
class Patch:
    """Triangles (k, 3) that turn their fronts away from a phase; the tetrahedra (k,) of that phase that they belong to,
    and opposite which corner (0-3) of theirs they lie. `name` is `solid_outside`, or `solid_void` where two meet."""

    name: str
    triangles: Indices
    owners: Indices
    sides: NDArray[np.int8]


def set_name(text: str) -> str:
    """A name as every format has it: letters, digits and underscores."""
    return re.sub(r"\W+", "_", text, flags=re.ASCII)


def patches(mesh: TetMesh, beside: Indices | None = None) -> list[Patch]:
    """The surfaces of a mesh, first where its phases end, then where they meet; those that have triangles.

    A triangle between two phases is in one of them: it turns from the phase that comes first in `phases` to the other.
    `beside` are the mesh's `neighbours`, where they are known.
    """
    beside = neighbours(mesh) if beside is None else beside
    names = [set_name(name) for name in mesh.phases]
    there = np.where(beside >= 0, mesh.phase[np.maximum(beside, 0)], np.int8(-1))
    here = np.broadcast_to(mesh.phase[:, None], there.shape)
    found = [_patch(mesh, f"{name}_outside", (beside == ALONE) & (here == i)) for i, name in enumerate(names)]
    for i, name in enumerate(names):
        found += [_patch(mesh, f"{name}_{names[j]}", (here == i) & (there == j)) for j in range(i + 1, len(names))]
    return [patch for patch in found if len(patch.triangles)]


def _patch(mesh: TetMesh, name: str, which: NDArray[np.bool_]) -> Patch:
    owner, side = np.nonzero(which)
    triangles = np.take_along_axis(mesh.tets[owner], FACES[side], axis=1)
    return Patch(name, triangles, owner.astype(np.int32), side.astype(np.int8))
