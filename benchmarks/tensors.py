"""Principal values and directions of tensors against NumPy's `eigh` of the same, in millions of tensors per second."""

from __future__ import annotations

from typing import Any

import numpy as np
from timing import Case, in_turn

from porelang.ops.principal import principal

COUNT = 300_000
EIGH, OURS = "NumPy eigh, {}", "principal, {}"


def tensors(rounds: int) -> list[dict[str, Any]]:
    """Each case with its rate, ours also as a ratio to NumPy's in the same type and run."""
    parts = np.random.default_rng(1).normal(size=(6, COUNT))
    matrices = np.moveaxis(parts[[0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(3, 3, COUNT), -1, 0)
    cases: dict[str, Case] = {}
    for name in ("float32", "float64"):
        mine, theirs = parts.astype(name), np.ascontiguousarray(matrices.astype(name))
        cases[EIGH.format(name)] = lambda m=theirs: np.linalg.eigh(m)  # type: ignore[misc]  # a default binds now
        cases[OURS.format(name)] = lambda p=mine: principal(*p)  # type: ignore[misc]  # as above
    times = in_turn(cases, rounds)
    rows = [{"case": n, "Mtensor/s": COUNT / t.wall / 1e6, "x": ""} for n, t in times.items()]
    for row in rows:
        name = row["case"].partition(", ")[2]
        if row["case"].startswith("principal"):
            row["x"] = times[EIGH.format(name)].wall / times[row["case"]].wall
    return rows
