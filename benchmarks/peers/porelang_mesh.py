"""porelang, from the text to the mesh, with the bounds found from the program."""

import numpy as np

import porelang
from porelang.mesh import Surface
from porelang.mesh.part import grid_of, surface_of

PACKAGES = ("porelang", "numpy")
PROGRAM = "gyroid(30) |> shell(1.53) & cylinder(75, 300)"
VOXEL = 1.15  # 133 x 133 x 263 samples


def run() -> Surface:
    design = porelang.compile(PROGRAM).design()
    return surface_of(design, placed=grid_of(design, voxel=VOXEL))


def arrays(mesh: Surface) -> "tuple[np.ndarray, np.ndarray]":
    return mesh.vertices, mesh.faces
