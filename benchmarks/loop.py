"""A step of the loop on voxels, by its own multigrid and by assembled matrices with pyamg's smoothed aggregation.

Each in a process of its own, for its memory: a cylinder of random densities under a patch load, immersed.
"""

from __future__ import annotations

import json
import math
import resource
import subprocess
import sys
import time
from typing import Any

import numpy as np
import pyamg
from scipy.sparse import csr_matrix

from porelang.optimize import elasticity, element, laws, multigrid
from porelang.optimize.grid import Force, Grid, Problem, Support

TOLERANCE = 1e-8
LAW = laws.Power(element.isotropic(1000, 0.3), 0.754, 1.49)


def model(across: int) -> elasticity.Model:
    size = 150 / across
    inside = lambda p: np.maximum(np.hypot(p[:, 0], p[:, 1]) - 75, np.abs(p[:, 2]) - 150)  # noqa: E731
    grid = Grid.of(inside, (-75, -75, -150), (75, 75, 150), size)
    held = Support(lambda p: p[:, 2] < -150 + 1e-6)
    pressed = Force(lambda p: (p[:, 2] > 150 - 1e-6) & (np.hypot(p[:, 0], p[:, 1]) < 25), (0, 0, -1e4))
    return elasticity.prepare(Problem(grid, (held,), (pressed,)))


def ours(made: elasticity.Model, weights: np.ndarray) -> tuple[float, int]:
    found = elasticity.solve(made, weights, LAW.bases, tolerance=TOLERANCE)
    return found.compliance, found.iterations


def assembled(made: elasticity.Model, weights: np.ndarray) -> tuple[float, int]:
    grid = made.problem.grid
    spacing = np.array(grid.spacing)
    first, offsets = multigrid.numbering(made.cells, made.index)
    dofs = (3 * (first[:, None] + offsets)[:, :, None] + np.arange(3)).reshape(-1, 24)
    free = np.zeros(made.fixed.size, bool)
    free[dofs] = True
    free &= ~made.fixed.ravel()
    number = np.where(free, np.cumsum(free) - 1, -1)[dofs]
    one = element.stiffness(LAW.bases[0], spacing)
    entries = (weights[:, 0] * grid.fill[grid.mask])[:, None, None] * one
    rows, columns = np.broadcast_arrays(number[:, :, None], number[:, None, :])
    kept = (rows >= 0) & (columns >= 0)
    whole = csr_matrix((entries[kept], (rows[kept], columns[kept])), shape=(free.sum(),) * 2)
    x, y, z = (np.stack(np.unravel_index(np.arange(made.fixed.shape[0]), [n + 1 for n in made.cells])).T * spacing).T
    rigid = np.zeros((made.fixed.shape[0], 3, 6))
    rigid[:, range(3), range(3)] = 1
    rigid[:, 0, 3], rigid[:, 1, 3], rigid[:, 0, 4], rigid[:, 2, 4], rigid[:, 1, 5], rigid[:, 2, 5] = -y, x, z, -x, -z, y
    hierarchy = pyamg.smoothed_aggregation_solver(whole, B=rigid.reshape(-1, 6)[free])
    left: list[float] = []
    force = made.forces.ravel()[free]
    u = hierarchy.solve(force, tol=TOLERANCE, accel="cg", residuals=left)
    return float(force @ u), len(left) - 1


def child(way: str, across: int) -> None:
    made = model(across)
    weights = LAW.weights(np.random.default_rng(0).uniform(0.2, 0.8, len(made.problem.grid.weights)))
    solver = {"ours": ours, "pyamg": assembled}[way]
    if way == "ours":
        ours(model(8), LAW.weights(np.full(len(model(8).problem.grid.weights), 0.5)))  # its loops are compiled
    began, wall = time.process_time(), time.perf_counter()
    compliance, steps = solver(made, weights)
    print(json.dumps({
        "unknowns": int(3 * np.prod([n + 1 for n in made.problem.grid.shape])), "CPU s": time.process_time() - began,
        "s": time.perf_counter() - wall, "steps": steps, "compliance": compliance,
        "GB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6,
    }))  # fmt: skip


def loop(sizes: tuple[int, ...] = (24, 48)) -> list[dict[str, Any]]:
    """One solve each; pyamg only at the smallest, where it takes 10 s and 1 GB. The last row is the exponent of the
    unknowns with which the time of a step of ours grows."""
    rows: list[dict[str, Any]] = []
    for across in sizes:
        for way in ("ours", "pyamg") if across == min(sizes) else ("ours",):
            done = subprocess.run(
                [sys.executable, __file__, way, str(across)], check=True, capture_output=True, text=True
            )
            rows.append({"case": f"a step on {across} voxels across, {way}", **json.loads(done.stdout)})
    first, last = (next(r for r in rows if r["case"].startswith(f"a step on {n} ")) for n in (min(sizes), max(sizes)))
    ratio = math.log(last["CPU s"] / first["CPU s"]) / math.log(last["unknowns"] / first["unknowns"])
    return [*rows, {"case": "exponent of a step's CPU time", "by unknowns": ratio}]


if __name__ == "__main__":
    child(sys.argv[1], int(sys.argv[2]))
