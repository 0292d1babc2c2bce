"""NumPy by hand and scikit-image's marching cubes."""

import numpy as np
import specimen
from skimage.measure import marching_cubes

PACKAGES = ("scikit-image", "numpy")


def run() -> "tuple[np.ndarray, ...]":
    values = specimen.separable(specimen.axes())
    return marching_cubes(values, 0.0, spacing=specimen.SPACING, gradient_direction="ascent")


def arrays(mesh: "tuple[np.ndarray, ...]") -> "tuple[np.ndarray, np.ndarray]":
    return mesh[0], mesh[1]
