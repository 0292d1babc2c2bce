"""Tetrahedra: straight from the field, with rims sharp or not, of one phase or both; in seconds and CPU seconds."""

from __future__ import annotations

from typing import Any

from timing import Case, in_turn

import porelang
from porelang.solid import Solid
from porelang.tet.direct import direct
from porelang.tet.quality import figures

SHEET = "gyroid(50) |> shell(1.53) & cylinder(75, 300)"
BLOCK = "gyroid(50) |> shell(1.53)"
BOUNDS = ((-75.0, -75.0, -150.0), (75.0, 75.0, 150.0))


def tets(rounds: int) -> list[dict[str, Any]]:
    """A gyroid sheet of 3 x 3 x 6 cells, in a cylinder and in a block, of about a million tetrahedra and of fewer; with
    and without sharp rims."""
    solids = {"cylinder": solid(SHEET, None), "block": solid(BLOCK, BOUNDS)}
    asked: dict[str, tuple[Solid, float, dict[str, Any]]] = {
        "cylinder, 3.125 mm": (solids["cylinder"], 3.125, {}),
        "cylinder, rims chamfered": (solids["cylinder"], 3.125, {"sharp": False}),
        "block, 3.57 mm": (solids["block"], 3.57, {}),
        "block, both phases": (solids["block"], 3.57, {"phases": ("solid", "void")}),
        "cylinder, 3.125 mm at the surface alone": (solids["cylinder"], 12.5, {"surface_size": 3.125}),
        "cylinder, 6.25 mm": (solids["cylinder"], 6.25, {}),
    }

    def case(part: Solid, size: float, more: dict[str, Any]) -> Case:
        return lambda: direct(part, size, **more)

    times = in_turn({name: case(*of) for name, of in asked.items()}, rounds)
    rows = []
    for name, (part, size, more) in asked.items():
        mesh, facts = direct(part, size, **more)
        found = figures(mesh)
        rows.append({
            "case": name, "seconds": times[name].wall, "CPU s": times[name].cpu, "tets": found["tets"],
            "tets / CPU s": len(mesh.tets) / times[name].cpu, "smallest angle": found["min_dihedral"],
            "largest": found["max_dihedral"], "dropped": facts["dropped_volume_fraction"],
        })  # fmt: skip
    return rows


def solid(text: str, bounds: Any) -> Solid:
    design = porelang.compile(text).design()
    return Solid(design.of("part"), bounds or design.bounds("part"))
