"""The phase of graded cells on 128^3 samples against the obvious formulation: a Poisson equation for each of its three
components, by SciPy's discrete cosine transform on that grid, whose cells keep the axes (and are unweighted).

Ours has the weights, is measured and looked at for folds, and is interpolated from a coarser grid, as it is much
smoother than the lattice. Beside the times stands by how much the number of cells per mm misses 1/w, for 95 % of them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dctn, idctn
from timing import in_turn

from porelang.tasks.phase.find import find

NODES, SIDE = 128, 100.0  # mm
Values = NDArray[np.float64]


def period(x: Values, y: Values, z: Values) -> Values:
    """From 1.8 to 4 mm: two samples a cell make a grid of 128 nodes along each side."""
    return 2.9 + 1.1 * np.sin(x / 25) * np.cos(y / 30 + z / 40)


def inside(x: Values, y: Values, z: Values) -> Values:
    return np.maximum(np.maximum(np.abs(x), np.abs(y)), np.abs(z)) - SIDE / 2


def by_scipy() -> Values:
    """The phase (3, n, n, n) whose gradient is nearest to 1/w along each axis."""
    axis, step = np.linspace(-SIDE / 2, SIDE / 2, NODES, retstep=True)
    turn = np.pi * np.arange(NODES) / (NODES - 1)
    along = (2 - 2 * np.cos(turn)) / step**2
    eigenvalues = along[:, None, None] + along[:, None] + along
    eigenvalues[0, 0, 0] = 1.0
    between = (axis[1:] + axis[:-1]) / 2
    out = []
    for a in range(3):
        places = np.meshgrid(*(between if i == a else axis for i in range(3)), indexing="ij", sparse=True)
        flow = np.moveaxis(1 / period(*places) / step, a, 0)
        right = np.zeros((NODES,) * 3)
        right[1:] += flow
        right[:-1] -= flow
        right[[0, -1]] *= 2  # half a cell belongs to the nodes at the ends
        spectrum = dctn(np.moveaxis(right, 0, a), type=1) / eigenvalues
        out.append(idctn(spectrum, type=1))
    return np.stack(out)


def missed(phase: Values, step: float) -> float:
    """By how much 95 % of the numbers of cells per mm miss 1/w, at the nodes within."""
    slopes = np.stack([np.gradient(u, step) for u in phase])[..., 2:-2, 2:-2, 2:-2]
    axes = np.meshgrid(*[np.linspace(-SIDE / 2, SIDE / 2, NODES)[2:-2]] * 3, indexing="ij")
    return float(np.quantile(np.abs(np.sqrt((slopes**2).sum(1)) * period(*axes) - 1), 0.95))


def phases(rounds: int) -> list[dict[str, Any]]:
    """Each way with its seconds, as a ratio to SciPy's, and what it misses."""
    low, high = (-SIDE / 2,) * 3, (SIDE / 2,) * 3
    ours: dict[bool, Any] = {}

    def solved(free: bool) -> None:
        ours[free] = find(period, inside, low, high, free)

    name = f"SciPy dctn, {NODES}^3, cells that keep the axes"
    cases = {name: by_scipy, "phase, fixed": lambda: solved(False), "phase, free": lambda: solved(True)}
    times = in_turn(cases, rounds)
    off = {name: missed(by_scipy(), SIDE / (NODES - 1))}
    off |= {f"phase, {'free' if free else 'fixed'}": told.off_95 for free, (_, told) in ours.items()}
    nodes = {f"phase, {'free' if free else 'fixed'}": grid.shape for free, (grid, _) in ours.items()}
    return [
        {"case": f"{n}{f', kept on {nodes[n]}' if n in nodes else ''}", "s": t.wall, "CPU s": t.cpu,
         "/ SciPy": t.wall / times[name].wall, "95 % miss by": off[n]}
        for n, t in times.items()
    ]  # fmt: skip
