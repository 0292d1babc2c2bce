"""Meshes: time and memory against VTK's flying edges, and what pruning saves. Run as `python benchmarks/mesh.py`.

Every case runs in turn, round after round, in one process; VTK is measured where it is installed. Nothing is asserted.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import porelang
from porelang.surface import mesh_output

SHAPE = (133, 133, 261)
TAU = np.float32(2 * np.pi / 30)
SHEET = "gyroid(30) |> shell(1.53) & cylinder(75, 300)"
SPARSE = "gyroid(4) |> shell(1.53) & cylinder(9, 50)"
SPARSE_BOX = (-25.0, -25.0, -25.5, 25.0, 25.0, 25.5)  # the cylinder fills a tenth of it


def by_hand() -> Any:
    """The sheet on the grid, every sine on its own axis."""
    axes = [np.linspace(-h, h, n).astype(np.float32) for h, n in zip((76, 76, 151), SHAPE, strict=True)]
    x, y, z = axes[0][:, None, None], axes[1][None, :, None], axes[2][None, None, :]
    (sx, cx), (sy, cy), (sz, cz) = ((np.sin(TAU * a), np.cos(TAU * a)) for a in (x, y, z))
    sheet = np.abs(sx * cy + sy * cz + sz * cx) - np.float32(1.53 / 2)
    return np.maximum(sheet, np.maximum(np.sqrt(x * x + y * y) - np.float32(75), np.abs(z) - np.float32(150)))


def flying_edges() -> Any:
    import vtk  # type: ignore[import-not-found]  # only where it is installed
    from vtk.util.numpy_support import numpy_to_vtk  # type: ignore[import-not-found]

    values = by_hand()
    image = vtk.vtkImageData()
    image.SetDimensions(*SHAPE[::-1])
    image.GetPointData().SetScalars(numpy_to_vtk(values.ravel()))
    edges = vtk.vtkFlyingEdges3D()
    edges.SetInputData(image)
    edges.SetValue(0, 0.0)
    edges.ComputeNormalsOff()
    edges.Update()
    return edges.GetOutput()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--size", type=int, default=512, help="samples along the longest side of the sparse box")
    options = parser.parse_args()
    sparse = porelang.compile(SPARSE)

    def pruned(on: bool) -> Callable[[], Any]:
        return lambda: mesh_output(sparse, resolution=options.size, bounds=SPARSE_BOX, prune=on)

    cases: dict[str, tuple[int, Callable[[], Any]]] = {
        "file to mesh, bounds found": (options.rounds, lambda: mesh_output(porelang.compile(SHEET), voxel=1.15)),
        "NumPy by hand + VTK": (options.rounds, flying_edges),
        f"sparse {options.size}^3, pruned": (1, pruned(True)),
        f"sparse {options.size}^3, all of it": (1, pruned(False)),
    }
    try:
        import vtk  # noqa: F401
    except ImportError:
        del cases["NumPy by hand + VTK"]
    times: dict[str, list[float]] = {name: [] for name in cases}
    for turn in range(options.rounds):
        for name, (rounds, case) in cases.items():
            if turn < rounds:
                start = time.perf_counter()
                case()
                times[name].append(time.perf_counter() - start)
    for name, taken in times.items():
        print(f"{name:<32}{statistics.median(taken):8.3f} s")


if __name__ == "__main__":
    main()
