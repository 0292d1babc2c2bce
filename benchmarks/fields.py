"""Field evaluation on the specimen's samples in float32, in Mvoxel per second."""

from __future__ import annotations

import sys
from typing import Any

from peers import specimen
from timing import Case, in_turn

import porelang
from porelang.gpu import GpuMissing, shared_gpu

PROGRAM = """
param w = 30mm in 10mm..60mm
out sheet = gyroid(w) |> shell(1.53) & cylinder(75, 300)
out twisted = gyroid(w) |> twist(0.01) & cylinder(75, 300)
"""
VOXELS = specimen.SHAPE[0] * specimen.SHAPE[1] * specimen.SHAPE[2]
BY_HAND, DENSE, OURS = (
    "sheet, NumPy by hand, separable",
    "sheet, NumPy by hand, dense",
    "sheet, porelang NumPy, 1 thread",
)


def fields(rounds: int) -> list[dict[str, Any]]:
    program, grid = porelang.compile(PROGRAM), specimen.axes()
    single = {o: program.field(o, dtype="f32", threads=1) for o in ("sheet", "twisted")}
    cases: dict[str, Case] = {
        BY_HAND: lambda: specimen.separable(grid),
        DENSE: lambda: specimen.dense(grid),
        OURS: lambda: single["sheet"].on_grid(grid).all(),
        "sheet, porelang NumPy, all threads": lambda: program.field("sheet", dtype="f32").on_grid(grid).all(),
        "twisted, porelang NumPy, 1 thread": lambda: single["twisted"].on_grid(grid).all(),
    }
    pid = None
    try:
        gpu = shared_gpu()
        pid = gpu.pid
        for output in ("sheet", "twisted"):
            field = program.field(output, backend="glsl", dtype="f32").on_grid(grid)
            cases[f"{output}, porelang GLSL on {gpu.info.renderer.split(' ')[0]}"] = field.all
    except GpuMissing as error:
        print(error, file=sys.stderr)
    times = in_turn(cases, rounds, pid)
    rows = [
        {"case": n, "Mvoxel/s": VOXELS / t.wall / 1e6, "Mvoxel/CPU s": VOXELS / t.cpu / 1e6} for n, t in times.items()
    ]
    rate = {row["case"]: row for row in rows}
    for row in rows:
        if row["case"].startswith("sheet"):
            row["/ by hand, CPU"] = row["Mvoxel/CPU s"] / rate[BY_HAND]["Mvoxel/CPU s"]
            row["/ dense by hand, wall"] = row["Mvoxel/s"] / rate[DENSE]["Mvoxel/s"]
    return rows
