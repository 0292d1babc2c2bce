"""Foams and trusses on a grid against what one would write with NumPy and SciPy, in millions of voxels per second.

The foam's rival knows all sites (a k-d tree over them, the eight nearest of each voxel, the least distance from the
planes between); the truss's folds coordinates into a cell and takes the least distance from each bar that can matter.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from timing import Case, in_turn

import porelang
from porelang.ops.strut_cells import CELLS

SIDE, CELL, SEED, RIVAL = 256, 20.0, 3, 96
FOAM, TRUSS = f"voronoi_cells({CELL}, 0.8, {SEED})", f'truss("octet", {CELL}, 0.6)'


def porosities(rounds: int) -> list[dict[str, Any]]:
    """Each on a grid of SIDE^3 voxels of 0.5 mm, its rival on RIVAL^3, which takes as long."""
    cases: dict[str, Case] = {}
    counts: dict[str, int] = {}

    def add(name: str, count: int, case: Case) -> None:
        cases[name], counts[name] = case, count**3

    add("closed foam", SIDE, ours(FOAM))
    add("  k-d tree, 8 nearest, planes", RIVAL, lambda: tree_foam(axes(RIVAL)))
    add("octet truss", SIDE, ours(TRUSS))
    add("  NumPy, bar by bar", RIVAL, lambda: folded_truss(axes(RIVAL)))
    times = in_turn(cases, rounds)
    rows: list[dict[str, Any]] = [
        {"case": n, "Mvoxel/s": counts[n] / t.wall / 1e6, "Mvoxel/CPU s": counts[n] / t.cpu / 1e6}
        for n, t in times.items()
    ]
    for row, rival in zip(rows[::2], rows[1::2], strict=True):
        row["of its rival, CPU"] = row["Mvoxel/CPU s"] / rival["Mvoxel/CPU s"]
    return rows


def axes(count: int) -> NDArray[np.float32]:
    return (np.arange(count, dtype=np.float32) + 0.3) * 0.5 * SIDE / count


def ours(text: str) -> Case:
    field = porelang.compile(text).field("part", dtype="f32")
    x = axes(SIDE)

    def run() -> object:
        return field.on_grid([x, x, x]).block((0, 0, 0), (SIDE,) * 3)

    return run


def tree_foam(x: NDArray[np.float32]) -> object:
    """The same foam, of sites that are known: those of all cells that the box may see."""
    count = int(np.ceil(0.5 * SIDE / CELL)) + 2
    cells = np.stack(np.meshgrid(*[np.arange(-2, count)] * 3, indexing="ij"), -1).reshape(-1, 3)
    sites = np.random.default_rng(SEED).random(cells.shape) + cells
    tree = cKDTree(sites * CELL)
    at = np.stack(np.meshgrid(x, x, x, indexing="ij"), -1).reshape(-1, 3).astype(np.float64)
    _, near = tree.query(at, 8, workers=-1)
    r = tree.data[near] - at[:, None]
    square = (r * r).sum(-1)
    apart = np.sqrt(((r[:, 1:] - r[:, :1]) ** 2).sum(-1))
    return ((square[:, 1:] - square[:, :1]) / (2 * apart)).min(1) - 0.4


def folded_truss(x: NDArray[np.float32]) -> object:
    """The same truss: each bar of the cell and of its neighbours in turn, over folded coordinates."""
    u = (x / CELL - np.rint(x / CELL)).astype(np.float32)
    p = np.stack(np.meshgrid(u, u, u, indexing="ij"), -1)
    least = np.full(p.shape[:3], np.inf, np.float32)
    for a, b in bars():
        way = b - a
        t = np.clip(((p - a) @ way) / (way @ way), 0, 1)
        q = p - a - t[..., None] * way
        least = np.minimum(least, np.sqrt((q * q).sum(-1)))
    return least * CELL - 0.6


def bars() -> list[tuple[NDArray[np.float32], NDArray[np.float32]]]:
    """Bars of an octet cell and of its neighbours, of those that reach the folded cell, -1/2 to 1/2."""
    out = []
    for start, end in CELLS["octet"].bars:
        for shift in np.stack(np.meshgrid(*[np.arange(-1, 2)] * 3, indexing="ij"), -1).reshape(-1, 3):
            a, b = (np.asarray(v, np.float32) + shift.astype(np.float32) for v in (start, end))
            if (np.minimum(a, b) <= 0.5).all() and (np.maximum(a, b) >= -0.5).all():
                out.append((a, b))
    return out
