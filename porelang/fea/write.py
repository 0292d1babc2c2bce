"""Results as a .vtu file, which ParaView opens: whole or not at all."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from porelang.atomic import destination, replace_path
from porelang.diagnostics import fail
from porelang.fea.solution import Solution
from porelang.fea.stress import energy_density


def write(solution: Solution, path: str | Path) -> None:
    """Write the results of a solve to a .vtu file. Errors: E113 where that cannot be written.

    Points are sites: where materials meet, a vertex is there once in each, so that stresses jump where they do. At
    points: `displacement` mm,
    `stress` MPa and `strain` (xx, yy, zz, xy, yz, xz), `von_mises`, `principal1` to 3 with `direction1` to 3, largest
    first, and `energy_density` N mm/mm3. In cells: `young`, `stress_of_tet`,
    `energy_of_tet` N mm, and `error`, each tetrahedron's part of the relative error.
    """
    if Path(path).suffix.lower() != ".vtu":
        raise fail(
            "E113", f"cannot write {path}: results of a solve go to .vtu files", hint=f"name it {Path(path).stem}.vtu"
        )
    destination(path)
    mesh = as_mesh(solution)
    with replace_path(path) as draft:
        mesh.write(draft, file_format="vtu")


def as_mesh(solution: Solution) -> Any:
    """What that file holds, as a `meshio.Mesh`."""
    import meshio

    nodes, sites = solution.nodes, solution.sites
    values, directions = solution.principal()
    at_points: dict[str, Any] = {
        "displacement": solution.at_vertices[sites.vertex],
        "stress": solution.stress,
        "strain": solution.strain,
        "von_mises": solution.von_mises,
        "energy_density": solution.energy_density,
    }
    for i in range(3):
        at_points[f"principal{i + 1}"] = values[:, i]
        at_points[f"direction{i + 1}"] = np.ascontiguousarray(directions[:, i])
    of_tets = energy_density(solution.stress_of_tets, solution.young, solution.poisson) * nodes.volumes
    in_cells = {
        "young": [solution.young],
        "stress_of_tet": [solution.stress_of_tets],
        "energy_of_tet": [of_tets],
        "error": [solution.error.of_tets],
    }
    return meshio.Mesh(nodes.points[sites.vertex], [("tetra", sites.corners)], point_data=at_points, cell_data=in_cells)
