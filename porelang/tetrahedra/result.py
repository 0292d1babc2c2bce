"""Tetrahedra as they are handed on: arrays, a report, and how they are written and shown."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from porelang.diagnostics import Diagnostic
from porelang.html import table, title
from porelang.tet import export
from porelang.tet.patches import patches
from porelang.tet.tetmesh import TetMesh

if TYPE_CHECKING:
    import meshio
    import trimesh


@dataclass(frozen=True, eq=False, repr=False)
class Tetrahedra:
    """A part as tetrahedra in mm. `mesh` has them as arrays, `report` what `pore tet --json` says of them, `doubts`
    what is doubtful about them; `notes` are what made them, for files."""

    mesh: TetMesh
    report: dict[str, Any]
    doubts: list[Diagnostic]
    notes: Mapping[str, str]

    @property
    def vertices(self) -> NDArray[np.float64]:
        """The corners (n, 3) in mm."""
        return self.mesh.vertices

    @property
    def tets(self) -> NDArray[np.int32]:
        """The four corners (m, 4) of each tetrahedron, whose volume is positive."""
        return self.mesh.tets

    @property
    def phase(self) -> NDArray[np.int8]:
        """Of each tetrahedron (m,) the index of what it is of, into `phases`."""
        return self.mesh.phase

    @property
    def phases(self) -> tuple[str, ...]:
        """What there are tetrahedra of: "solid"; and of two also "void", or "void 1", "void 2", ..."""
        return self.mesh.phases

    def surfaces(self) -> dict[str, trimesh.Trimesh]:
        """The named surfaces, `solid_outside` and where phases meet, as meshes of triangles on the same vertices."""
        import trimesh

        found = patches(self.mesh)
        return {p.name: trimesh.Trimesh(self.mesh.vertices, p.triangles, process=False) for p in found}

    def to_meshio(self) -> meshio.Mesh:
        """The same as a `meshio.Mesh`: tetrahedra, then the triangles of the surfaces; names are `cell_sets`."""
        return export.to_meshio(self.mesh)

    def write(self, path: str | Path) -> Path:
        """Write a file, whole or not at all: .vtu .msh .inp .nas .mesh by its ending. Errors: E112, E113."""
        return export.write(self.mesh, path, self.notes)

    def __repr__(self) -> str:
        told = self.report
        angles = f"angles from {told['min_dihedral']:.3g} to {told['max_dihedral']:.4g} degrees"
        return f"<{told['tets']:,} tetrahedra of {', '.join(self.phases)}, {told['volume']:.6g} mm3, {angles}>"

    def _repr_html_(self) -> str:
        keys = ("tets", "vertices", "volume", "min_dihedral", "max_dihedral", "components", "seconds")
        rows = [(key, f"{self.report[key]:,.6g}") for key in keys]
        return title(f"tetrahedra of {self.notes['output']}") + table(("quantity", "value"), rows)
