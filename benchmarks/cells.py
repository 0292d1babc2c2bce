"""Unit cells: six load cases and three of heat, by resolution; steps show whether the preconditioner holds."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from porelang.unitcell.effective import conducted, homogenized
from porelang.unitcell.fractions import fractions

#: The half thickness, in values of the gyroid, of sheets of density 0.1 and 0.3, and the finest grid.
SHEETS, GRIDS = {"sheet 0.1": 0.154, "sheet 0.3": 0.464}, (32, 64)


def cells() -> list[dict[str, Any]]:
    rows = []
    for name, t in SHEETS.items():
        for n in GRIDS:
            x = np.pi * (np.arange(2 * n) + 0.5) / n
            a, b, c = np.meshgrid(x, x, x, indexing="ij", sparse=True)
            density = fractions(np.abs(np.sin(a) * np.cos(b) + np.sin(b) * np.cos(c) + np.sin(c) * np.cos(a)) - t, 2)
            density[0, 1 : n // 2] *= 1 - 1e-6  # no symmetry: all six cases
            homogenized(density[:8, :8, :8], (1, 1, 1))  # the loops are compiled
            wall, cpu = time.perf_counter(), time.process_time()
            stiff = homogenized(density, (1, 1, 1))
            wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
            heat = time.process_time()
            conducted(density, (1, 1, 1))
            rows.append({"case": f"{name}, {n}^3, {stiff.solved} cases", "s": wall, "CPU s": cpu, "steps": stiff.steps,
                         "heat CPU s": time.process_time() - heat})  # fmt: skip
    return rows
