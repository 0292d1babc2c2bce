"""PoreSpy's gyroid as voxels, tiled, cut to the cylinder by hand and meshed by PoreSpy."""

import numpy as np
import porespy
import specimen

PACKAGES = ("porespy", "scikit-image")
VOXELS = 26  # a period


def run() -> "porespy.tools.Results":
    cell = porespy.generators.tpms_unit_cell(VOXELS, method="schoen", skew=0.0, phi=specimen.THICKNESS / 2)
    voxels = porespy.generators.tile_tpms(cell, (5, 5, 10))
    h = specimen.PERIOD / VOXELS
    x, y = ((np.arange(n) + 0.5) * h - specimen.RADIUS for n in voxels.shape[:2])
    voxels = voxels & ((x[:, None] ** 2 + y[None, :] ** 2) <= specimen.RADIUS**2)[:, :, None]
    return porespy.tools.mesh_region(np.pad(voxels, 1), voxel_size=h)


def arrays(mesh: "porespy.tools.Results") -> "tuple[np.ndarray, np.ndarray]":
    return mesh.verts, mesh.faces
