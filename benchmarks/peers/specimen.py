"""The part that all peers mesh: the gyroid sheet of porosity 0.5 in a cylinder, on 133 x 133 x 261 samples, by hand."""

import numpy as np

SHAPE = (133, 133, 261)
PERIOD, THICKNESS, RADIUS, HEIGHT = 30.0, 1.53, 75.0, 300.0
TAU = np.float32(2 * np.pi / PERIOD)
SPACING = tuple(2 * h / (n - 1) for h, n in zip((76.0, 76.0, 151.0), SHAPE, strict=True))


def axes() -> "list[np.ndarray]":
    return [np.linspace(-h, h, n).astype(np.float32) for h, n in zip((76, 76, 151), SHAPE, strict=True)]


def separable(grid: "list[np.ndarray]") -> "np.ndarray":
    """The field as someone who knows NumPy well writes it: every sine on its own axis."""
    x, y, z = grid[0][:, None, None], grid[1][None, :, None], grid[2][None, None, :]
    (sx, cx), (sy, cy), (sz, cz) = ((np.sin(TAU * a), np.cos(TAU * a)) for a in (x, y, z))
    sheet = np.abs(sx * cy + sy * cz + sz * cx) - np.float32(THICKNESS / 2)
    return np.maximum(sheet, np.maximum(np.sqrt(x * x + y * y) - np.float32(75), np.abs(z) - np.float32(150)))


def dense(grid: "list[np.ndarray]") -> "np.ndarray":
    """The field on dense coordinates, two layers at a time, so that all buffers stay in the cache."""
    out = np.empty(SHAPE, np.float32)
    for i in range(0, SHAPE[0], 2):
        x, y, z = np.meshgrid(grid[0][i : i + 2], grid[1], grid[2], indexing="ij")
        g = np.sin(TAU * x) * np.cos(TAU * y) + np.sin(TAU * y) * np.cos(TAU * z) + np.sin(TAU * z) * np.cos(TAU * x)
        cylinder = np.maximum(np.sqrt(x * x + y * y) - np.float32(75), np.abs(z) - np.float32(150))
        out[i : i + 2] = np.maximum(np.abs(g) - np.float32(THICKNESS / 2), cylinder)
    return out
