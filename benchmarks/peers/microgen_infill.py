"""microgen's infill of a cylinder, at as many samples a period as the others."""

import logging

import numpy as np
import pyvista
import specimen
from microgen import Infill
from microgen.shape.surface_functions import gyroid

PACKAGES = ("microgen", "vtk")
logging.disable()


def run() -> "pyvista.PolyData":
    cylinder = pyvista.Cylinder(
        radius=specimen.RADIUS, height=specimen.HEIGHT, direction=(0, 0, 1), resolution=200
    ).triangulate()
    samples = round(specimen.PERIOD / specimen.SPACING[2])
    return Infill(
        obj=cylinder, surface_function=gyroid, cell_size=specimen.PERIOD, offset=specimen.THICKNESS, resolution=samples
    ).sheet


def arrays(mesh: "pyvista.PolyData") -> "tuple[np.ndarray, np.ndarray]":
    mesh = mesh.extract_surface().triangulate()
    return np.asarray(mesh.points), np.asarray(mesh.faces).reshape(-1, 4)[:, 1:]
