"""`make bench`: how fast fields are evaluated and meshed, as medians and ratios within one run.

Competitors run in turn, round after round, so that what else the machine does falls on all of them alike. CPU seconds
include those of the process that the GL driver runs in. Nothing here is asserted: read the ratios.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import porelang
from porelang import device
from porelang.ir import order
from porelang.surface import mesh_output

SHAPE = (133, 133, 261)
VOXELS = SHAPE[0] * SHAPE[1] * SHAPE[2]
TAU = np.float32(2 * np.pi / 30)
PROGRAM = """
param w = 30mm in 10mm..60mm
out sheet = gyroid(w) |> shell(1.53) & cylinder(75, 300)
out twisted = gyroid(w) |> twist(0.01) & cylinder(75, 300)
"""
Axes = list[np.ndarray[Any, np.dtype[np.float32]]]


def axes() -> Axes:
    return [np.linspace(-h, h, n).astype(np.float32) for h, n in zip((76, 76, 151), SHAPE, strict=True)]


def by_hand_separable(grid: Axes) -> Any:
    """The sheet as someone who knows NumPy well writes it: every sine on its own axis."""
    x, y, z = grid[0][:, None, None], grid[1][None, :, None], grid[2][None, None, :]
    sx, cx, sy, cy = np.sin(TAU * x), np.cos(TAU * x), np.sin(TAU * y), np.cos(TAU * y)
    sz, cz = np.sin(TAU * z), np.cos(TAU * z)
    sheet = np.abs(sx * cy + sy * cz + sz * cx) - np.float32(1.53 / 2)
    return np.maximum(sheet, np.maximum(np.sqrt(x * x + y * y) - np.float32(75), np.abs(z) - np.float32(150)))


def by_hand_chunked(grid: Axes) -> Any:
    """The sheet on dense coordinates, two layers at a time, so that all buffers stay in the cache."""
    out = np.empty(SHAPE, np.float32)
    for i in range(0, SHAPE[0], 2):
        x, y, z = np.meshgrid(grid[0][i : i + 2], grid[1], grid[2], indexing="ij")
        g = np.sin(TAU * x) * np.cos(TAU * y) + np.sin(TAU * y) * np.cos(TAU * z) + np.sin(TAU * z) * np.cos(TAU * x)
        sheet = np.abs(g) - np.float32(1.53 / 2)
        out[i : i + 2] = np.maximum(
            sheet, np.maximum(np.sqrt(x * x + y * y) - np.float32(75), np.abs(z) - np.float32(150))
        )
    return out


def cpu_of(pid: int) -> float:
    """CPU seconds that another process has used (0 where the system does not tell)."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def measure(cases: dict[str, Callable[[], Any]], rounds: int, pid: int | None = None) -> dict[str, tuple[float, float]]:
    """Median wall and CPU seconds of each case, run in turn."""
    walls: dict[str, list[float]] = {name: [] for name in cases}
    cpus: dict[str, list[float]] = {name: [] for name in cases}
    for case in cases.values():
        case()
    for _ in range(rounds):
        for name, case in cases.items():
            wall, cpu = time.perf_counter(), time.process_time() + (cpu_of(pid) if pid else 0.0)
            case()
            walls[name].append(time.perf_counter() - wall)
            cpus[name].append(time.process_time() + (cpu_of(pid) if pid else 0.0) - cpu)
    return {name: (statistics.median(walls[name]), statistics.mean(cpus[name])) for name in cases}


def fields(rounds: int) -> list[dict[str, Any]]:
    """Field evaluation on 133 x 133 x 261 points in float32, in Mvoxel per second."""
    program, grid = porelang.compile(PROGRAM), axes()
    single = {o: program.field(o, dtype="f32", threads=1) for o in ("sheet", "twisted")}
    cases: dict[str, Callable[[], Any]] = {
        "sheet, NumPy by hand, separable": lambda: by_hand_separable(grid),
        "sheet, NumPy by hand, chunked dense": lambda: by_hand_chunked(grid),
        "sheet, porelang NumPy, 1 thread": lambda: single["sheet"].on_grid(grid).all(),
        "sheet, porelang NumPy, all threads": lambda: program.field("sheet", dtype="f32").on_grid(grid).all(),
        "twisted, porelang NumPy, 1 thread": lambda: single["twisted"].on_grid(grid).all(),
    }
    pid = None
    try:
        gpu = device.gpu()
        pid = gpu.pid
        for output in ("sheet", "twisted"):
            field = program.field(output, backend="glsl", dtype="f32").on_grid(grid)
            cases[f"{output}, porelang GLSL on {gpu.info.renderer.split(' ')[0]}"] = field.all
    except porelang.PoreError as error:
        print(error, file=sys.stderr)
    times = measure(cases, rounds, pid)
    return [{"case": n, "Mvoxel/s": VOXELS / w / 1e6, "Mvoxel/CPU s": VOXELS / c / 1e6} for n, (w, c) in times.items()]


def meshes(rounds: int) -> list[dict[str, Any]]:
    """File to mesh of the specimen on about 133 x 133 x 261 nodes, and compilation, in seconds."""
    program = porelang.compile(PROGRAM)
    many = "\n".join(
        f"let s{i} = sphere({3 + i % 5}) |> translate([{i % 40 * 10}, {i // 40 * 10}, {i % 7}])" for i in range(2000)
    )
    many += "\n" + " | ".join(f"s{i}" for i in range(2000))
    cases: dict[str, Callable[[], Any]] = {
        "mesh the sheet, voxel 1.15 mm, NumPy": lambda: mesh_output(program, "sheet", voxel=1.15),
        "compile the sheet": lambda: porelang.compile(PROGRAM).solid("sheet"),
        "compile 2000 spheres": lambda: order([porelang.compile(many).solid()]),
    }
    try:
        from skimage.measure import marching_cubes
    except ImportError:
        pass
    else:
        cases["scikit-image on samples by hand"] = lambda: marching_cubes(by_hand_separable(axes()), 0.0)
    return [{"case": n, "seconds": w, "CPU s": c} for n, (w, c) in measure(cases, max(3, rounds // 3)).items()]


def starts(rounds: int) -> list[dict[str, Any]]:
    """Process start to the end of `pore check`, in seconds."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "specimen.pore"
        path.write_text(PROGRAM)

        def run(*command: str) -> Callable[[], Any]:
            return lambda: subprocess.run([sys.executable, *command], check=True, capture_output=True)

        cases = {
            "python -c pass": run("-c", "pass"),
            "import numpy": run("-c", "import numpy"),
            "pore check specimen.pore": run("-m", "porelang", "check", str(path)),
        }
        return [{"case": n, "seconds": w} for n, (w, _) in measure(cases, rounds).items()]


def main() -> None:
    parser = argparse.ArgumentParser(prog="benchmarks", description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    results = {"fields": fields(options.rounds), "meshes": meshes(options.rounds), "starts": starts(options.rounds)}
    if options.json:
        print(json.dumps({"machine": platform.platform(), "cores": os.cpu_count(), **results}, indent=1))
        return
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}, NumPy {np.__version__}")
    for title, rows in results.items():
        print(f"\n{title}")
        for row in rows:
            numbers = "  ".join(f"{v:9.3g} {k}" for k, v in row.items() if k != "case")
            print(f"  {row['case']:<44}{numbers}")
    rate = {row["case"]: row for row in results["fields"]}
    hand, ours = rate["sheet, NumPy by hand, separable"], rate["sheet, porelang NumPy, 1 thread"]
    print(f"\nporelang / by hand, separable, per CPU second: {ours['Mvoxel/CPU s'] / hand['Mvoxel/CPU s']:.2f}")
    for name, row in rate.items():
        if "sheet, porelang GLSL" in name:
            chunked = rate["sheet, NumPy by hand, chunked dense"]["Mvoxel/s"]
            print(f"GLSL / chunked NumPy by hand, wall: {row['Mvoxel/s'] / chunked:.2f}")


if __name__ == "__main__":
    main()
