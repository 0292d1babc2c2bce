"""The phase of graded cells on 128^3 samples against the obvious formulation: a Poisson equation for each of its three
components, by SciPy's discrete cosine transform on that grid (unweighted). It ends there where cells keep the axes;
where they may turn, it begins at what that found, and takes some thirty steps, of which one is timed: the rotations
nearest to its Jacobian by NumPy's singular values, and the three equations for them.

Ours has the weights, is measured and looked at for folds, and is interpolated from a coarser grid, as it is much
smoother than the lattice. Beside the times stands by how much 95 % of the cells miss their size w.
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
#: Rotations of no angle, everywhere.
UPRIGHT = np.eye(3)[..., None, None, None]


def period(x: Values, y: Values, z: Values) -> Values:
    """From 1.8 to 4 mm: two samples a cell make a grid of 128 nodes along each side."""
    return 2.9 + 1.1 * np.sin(x / 25) * np.cos(y / 30 + z / 40)


def inside(x: Values, y: Values, z: Values) -> Values:
    return np.maximum(np.maximum(np.abs(x), np.abs(y)), np.abs(z)) - SIDE / 2


def by_scipy(rows: Values = UPRIGHT) -> Values:
    """The phase (3, n, n, n) whose gradients are nearest to the `rows` (3, 3, n, n, n) of rotations over the period."""
    axis, step = np.linspace(-SIDE / 2, SIDE / 2, NODES, retstep=True)
    turn = np.pi * np.arange(NODES) / (NODES - 1)
    along = (2 - 2 * np.cos(turn)) / step**2
    eigenvalues = along[:, None, None] + along[:, None] + along
    eigenvalues[0, 0, 0] = 1.0
    wanted = rows / period(*np.meshgrid(axis, axis, axis, indexing="ij", sparse=True)) / step
    out = []
    for component in wanted:
        right = np.zeros((NODES,) * 3)
        for a in range(3):
            if not component[a].any():
                continue
            values, sum_ = np.moveaxis(component[a], a, 0), np.moveaxis(right, a, 0)
            flow = (values[1:] + values[:-1]) / 2
            sum_[0] += 2 * -flow[0]  # half a cell belongs to the nodes at the ends
            sum_[-1] += 2 * flow[-1]
            sum_[1:-1] += flow[:-1] - flow[1:]
        out.append(idctn(dctn(right, type=1) / eigenvalues, type=1))
    return np.stack(out)


def turned_by_scipy(phase: Values) -> Values:
    """One step of the local-global iteration from a phase (3, n, n, n)."""
    slopes = np.stack([np.stack(np.gradient(u, SIDE / (NODES - 1))) for u in phase])
    u, _, v = np.linalg.svd(np.moveaxis(slopes, (0, 1), (-2, -1)))
    return by_scipy(np.moveaxis(u @ v, (-2, -1), (0, 1)))


def missed(phase: Values, step: float) -> float:
    """By how much 95 % of the cells miss their size w, at the nodes within."""
    slopes = np.stack([np.gradient(u, step) for u in phase])[..., 2:-2, 2:-2, 2:-2]
    axes = np.meshgrid(*[np.linspace(-SIDE / 2, SIDE / 2, NODES)[2:-2]] * 3, indexing="ij")
    return float(np.quantile(np.abs(1 / (np.sqrt((slopes**2).sum(1)) * period(*axes)) - 1), 0.95))


def phases(rounds: int) -> list[dict[str, Any]]:
    """Each way with its seconds, as a ratio to SciPy's, and what it misses."""
    low, high = (-SIDE / 2,) * 3, (SIDE / 2,) * 3
    ours: dict[bool, Any] = {}
    theirs: dict[bool, Values] = {}

    def solved(free: bool) -> None:
        ours[free] = find(period, inside, low, high, free)

    def by_peer(free: bool) -> None:
        theirs[free] = turned_by_scipy(theirs[False]) if free else by_scipy()

    peers = {
        False: "SciPy dctn, cells that keep the axes",
        True: "NumPy svd and SciPy dctn, one step of cells that turn",
    }
    rows = []
    for free, peer in peers.items():
        name = "phase, free" if free else "phase, fixed"
        times = in_turn({peer: lambda free=free: by_peer(free), name: lambda free=free: solved(free)}, rounds)
        grid, told = ours[free]
        off = (missed(theirs[free], SIDE / (NODES - 1)), told.off_95)
        kept = (f"{NODES}^3", f"kept on {grid.shape}")
        rows += [
            {
                "case": f"{name}, {on}",
                "s": t.wall,
                "CPU s": t.cpu,
                "/ SciPy": t.wall / times[peer].wall,
                "95 % miss by": by,
            }
            for (name, t), by, on in zip(times.items(), off, kept, strict=True)
        ]
    return rows
