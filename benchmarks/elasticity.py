"""Elasticity: assembly and solve of a gyroid block, and assembly by scikit-fem beside it.

Each size runs in a process of its own, which tells its peak of memory. The last row is the exponent of the unknowns
with which the time of a solve grows.
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

#: Cubes along the edges of the box from which the block is cut, for some 100 000 and 700 000 unknowns of order 2.
SIZES = (18, 36)


def block(cubes: int) -> tuple[Any, Any]:
    """The cubes of a box of 40 mm whose centres lie in a gyroid of 20 mm, six tetrahedra each, in one piece."""
    from itertools import permutations

    from scipy.ndimage import label

    axis = (np.arange(cubes) + 0.5) * 4 * np.pi / cubes
    x, y, z = np.meshgrid(axis, axis, axis, indexing="ij")
    solid = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x) < 0
    pieces, _ = label(solid)
    solid = pieces == np.argmax(np.bincount(pieces[solid]))
    number = np.arange((cubes + 1) ** 3).reshape((cubes + 1,) * 3)
    low = number[:-1, :-1, :-1][solid]
    side = cubes + 1
    steps = (side * side, side, 1)
    tets = np.concatenate([low[:, None] + np.cumsum((0, *s)) for s in permutations(steps)])
    used, tets = np.unique(tets, return_inverse=True)
    points = np.stack(np.unravel_index(used, number.shape), axis=1) * 40 / cubes
    tets = tets.reshape(-1, 4).astype(np.int32)
    corners = points[tets]
    wrong = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0
    tets[wrong] = tets[wrong][:, [1, 0, 2, 3]]
    return points, tets


def measured(cubes: int, peer: bool) -> dict[str, Any]:
    """One row, in this process: ours, or the peer's assembly."""
    from types import SimpleNamespace

    from porelang.fea import Force, Problem, Support, solve
    from porelang.progress import watching

    def problem(points: Any, tets: Any) -> Problem:
        push = Force(lambda p: p[:, 2] > 40 - 1e-9, (0.0, 20.0, -100.0))
        return Problem(
            SimpleNamespace(vertices=points, tets=tets), 2000.0, 0.3,
            supports=(Support(lambda p: p[:, 2] < 1e-9),), loads=(push,),
        )  # fmt: skip

    points, tets = block(cubes)
    if peer:
        import skfem
        from skfem.models.elasticity import lame_parameters, linear_elasticity

        begin = time.perf_counter()
        basis = skfem.Basis(skfem.MeshTet(points.T, tets.T), skfem.ElementVector(skfem.ElementTetP2()), intorder=2)
        linear_elasticity(*lame_parameters(2000.0, 0.3)).assemble(basis)
        row = {"unknowns": int(basis.N), "assembly s": time.perf_counter() - begin}
    else:
        solve(problem(*block(8)))  # loops are compiled
        seen: dict[str, float] = {}
        ends: dict[str, float] = {}

        def report(what: str, done: int, total: int) -> None:
            seen.setdefault(what, time.perf_counter())
            ends[what] = time.perf_counter()

        begin, cpu = time.perf_counter(), time.process_time()
        with watching(report):
            found = solve(problem(points, tets))
        whole = time.perf_counter() - begin
        row = {
            "unknowns": found.unknowns, "assembly s": ends["assembling"] - begin,
            "solve s": ends["solving"] - ends["assembling"], "stress s": begin + whole - ends["solving"],
            "CPU s": time.process_time() - cpu,
            "iterations": found.iterations, "residual": found.residual,
        }  # fmt: skip
    row["peak MB"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3)
    return row


def elasticity(rounds: int = 1) -> list[dict[str, Any]]:
    """Rows of ours and of the peer for each size, taken in turn, the quickest of the rounds."""
    rows = []
    for cubes in SIZES:
        for name, peer in (("porelang", False), ("scikit-fem, assembly alone", True)):
            runs = [_alone(cubes, peer) for _ in range(rounds)]
            best = min(runs, key=lambda r: r.get("solve s", 0) + r["assembly s"])
            rows.append({"case": f"{name}, {best['unknowns'] / 1000:.0f} k", **best})
    ours = [r for r in rows if "solve s" in r]
    ratio = math.log(ours[-1]["solve s"] / ours[0]["solve s"]) / math.log(ours[-1]["unknowns"] / ours[0]["unknowns"])
    return [*rows, {"case": "exponent of the solve's time", "by unknowns": ratio}]


def _alone(cubes: int, peer: bool) -> dict[str, Any]:
    done = subprocess.run(
        [sys.executable, __file__, str(cubes), *(["peer"] if peer else [])], capture_output=True, text=True, check=True
    )
    row: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return row


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(json.dumps(measured(int(sys.argv[1]), len(sys.argv) > 2)))
    else:
        for row in elasticity():
            print("  ".join(f"{v:.3g} {k}" if isinstance(v, float) else f"{v} {k}" for k, v in row.items()))
