"""Tetrahedra to a grid, and a blur, of 128^3 nodes, against what one would write with SciPy."""

from __future__ import annotations

from itertools import permutations
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import LinearNDInterpolator
from scipy.ndimage import gaussian_filter
from timing import Case, in_turn

from porelang.tasks import blur
from porelang.tasks.readers.asked import Asked
from porelang.tasks.readers.cells import TETRA, Block, cells
from porelang.tasks.readers.raster import rasterised

Array = NDArray[Any]
NODES, CUBES, SIDE = 128, 28, 40.0
SIGMA = 2.0  # steps


def sampling(rounds: int) -> list[dict[str, Any]]:
    """Each case with its seconds, and how many times as long as ours SciPy takes."""
    points, tetrahedra = mesh()
    values = points[:, 0] ** 2 + points[:, 1]
    asked = Asked("mesh.vtu", "values", None, "")
    step = SIDE / (NODES - 3)  # the grid has a layer more on each side
    axis = np.linspace(-SIDE / 2, SIDE / 2, NODES)
    nodes = tuple(np.meshgrid(axis, axis, axis, indexing="ij"))
    weights = blur.gaussian(SIGMA)
    radius = len(weights) // 2
    inner = np.random.default_rng(1).normal(size=(NODES,) * 3)
    whole = np.pad(inner, radius, mode="edge")
    tets = f"{len(tetrahedra):,} tetrahedra"
    listed = [Block(TETRA, tetrahedra, np.arange(len(tetrahedra)))]
    cases: dict[str, Case] = {
        f"{tets}, porelang": lambda: rasterised(
            asked, cells(asked, points, listed, values[:, None], in_cells=False), step
        ),
        f"{tets}, SciPy LinearNDInterpolator": lambda: LinearNDInterpolator(points, values)(nodes),
        "blur, porelang": lambda: blur.averaged(whole[..., None], weights),
        "blur, SciPy gaussian_filter": lambda: gaussian_filter(inner, SIGMA, mode="nearest"),
    }  # fmt: skip
    times = in_turn(cases, rounds)
    rows: list[dict[str, Any]] = []
    for name, taken in times.items():
        ours = times[f"{name.rpartition(',')[0]}, porelang"]
        row = {"case": name, "s": taken.wall, "CPU s": taken.cpu}
        rows.append({**row, "/ porelang, wall": taken.wall / ours.wall, "/ porelang, CPU": taken.cpu / ours.cpu})
    return rows


def mesh() -> tuple[Array, Array]:
    """Cubes of six tetrahedra each, their corners moved by up to 15 % of an edge."""
    n = CUBES + 1
    places = np.stack(np.meshgrid(*[np.arange(float(n))] * 3, indexing="ij"), -1).reshape(-1, 3)
    inner = ((places > 0) & (places < CUBES)).all(axis=1)
    places[inner] += np.random.default_rng(1).uniform(-0.15, 0.15, (int(inner.sum()), 3))
    corner = np.stack(np.meshgrid(*[np.arange(CUBES)] * 3, indexing="ij"), -1).reshape(-1, 3) @ [n * n, n, 1]
    made = []
    for order in permutations((n * n, n, 1)):
        made.append(corner[:, None] + np.cumsum([0, *order]))
    return places * (SIDE / CUBES) - SIDE / 2, np.concatenate(made)
