"""Tetrahedra by the direct mesher, by fTetWild, and by tpmslab where it is installed (`make bench-peers`): microseconds
for each, and the angles between faces."""

from __future__ import annotations

import json
import subprocess
import tempfile
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from peers import HERE, TPMSLAB

import porelang
from porelang.tet.tetmesh import TetMesh, dihedral_angles, volumes

#: A cylinder of a gyroid sheet, half solid: 1.5 x 1.5 x 1.5 cells, for fTetWild takes minutes for more.
CYLINDER, COARSE = "gyroid(20) |> shell(1.53) & cylinder(15, 30)", 2.5
#: A block of 3 x 3 x 6 cells, as tpmslab makes them; and the size that gives about as many tetrahedra.
BLOCK, CELLS, SAMPLES, FINE = "gyroid(25) |> shell(1.53) & box([75, 75, 150])", "3,3,6", 12, 1.8


def tetmeshers(rounds: int) -> list[dict[str, Any]]:
    """Each case with what it took: of several runs the fastest, of what takes a minute and more the only one."""
    rows = [_row("cylinder, direct", rounds, lambda: _ours(CYLINDER, COARSE))]
    if find_spec("pytetwild") is not None:
        rows.append(_row("cylinder, fTetWild", 1, lambda: _ours(CYLINDER, COARSE, mesher="ftetwild")))
    rows.append(_row("block, direct", rounds, lambda: _ours(BLOCK, FINE)))
    if TPMSLAB.python.exists():
        rows.append(_row("block, tpmslab", 1, _tpmslab))
    for row in rows:
        ours = next(r for r in rows if r["case"].split(",")[0] == row["case"].split(",")[0])
        row["/ direct, per tet"] = row["us a tet"] / ours["us a tet"]
    return rows


def _row(case: str, rounds: int, made: Callable[[], tuple[TetMesh, float]]) -> dict[str, Any]:
    runs = [made() for _ in range(rounds)]
    mesh, seconds = runs[0][0], min(taken for _, taken in runs)
    angles = dihedral_angles(mesh)
    return {
        "case": case,
        "tets": len(mesh.tets),
        "seconds": seconds,
        "us a tet": 1e6 * seconds / len(mesh.tets),
        "least angle": float(angles.min()),
        "largest angle": float(angles.max()),
        "below 10 degrees": float((angles < 10).any(axis=1).mean()),
        "mm3": float(volumes(mesh).sum()),
    }


def _ours(text: str, size: float, **more: Any) -> tuple[TetMesh, float]:
    """The tetrahedra of a program, and the seconds from its field to them, without its report."""
    made = porelang.compile(text).tet(size=size, **more)
    return made.mesh, made.report["seconds_meshing"]


def _tpmslab() -> tuple[TetMesh, float]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mesh.npz"
        command = [str(TPMSLAB.python), str(HERE / "tpmslab_block.py"), str(path), CELLS, str(SAMPLES)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        with np.load(path) as arrays:
            vertices, tets = arrays["vertices"], arrays["tets"]
    corners = vertices[tets]
    turned = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0
    tets[turned] = tets[turned][:, [0, 2, 1, 3]]
    mesh = TetMesh(vertices, tets.astype(np.int32), np.zeros(len(tets), np.int8))
    return mesh, json.loads(done.stdout.splitlines()[-1])["seconds"]
