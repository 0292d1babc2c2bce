"""Lookup in a sampled field against SciPy's, and the nearest of 100 000 bars, in millions of points per second.

Fields are called as a person calls them: with points (n, 3), through all the checks.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.ndimage import map_coordinates
from timing import Case, in_turn

from porelang.conformance.samples import BARS, GRID
from porelang.data import Data, SampledField, Segments
from porelang.field import Field, make_field
from porelang.formula import Formula
from porelang.ir import Node, X, Y, Z, node

NODES, POINTS, COUNT, WALKS = 128, 20_000_000, 100_000, 1_000_000
SIDE = 100.0  # mm
SCIPY = "SciPy map_coordinates, order 1, {}"
TYPES = {"float32": "f32", "float64": "f64"}
NEAREST = ("distance", "dx", "dy", "dz", "nx", "ny", "nz", "along", "radius", "length", "index")


def data(rounds: int) -> list[dict[str, Any]]:
    """Each case with its rate; lookup also as a ratio to SciPy's in the same type and run."""
    rng = np.random.default_rng(1)
    cases: dict[str, Case] = {}
    counts: dict[str, int] = {}

    def add(name: str, count: int, case: Case) -> None:
        cases[name], counts[name] = case, count

    values = rng.normal(size=(NODES,) * 3)
    points = rng.uniform(0, NODES - 1, (POINTS, 3))
    for name in TYPES:
        grid = SampledField.from_array(values.astype(name), (0, 0, 0), 1.0)
        here = points.astype(name)
        add(SCIPY.format(name), POINTS, scipy(grid.values[..., 0], np.ascontiguousarray(here.T)))
        for kind in ("lookup", "lookup_cubic"):
            field = made([node(kind, GRID, X, Y, Z, value=(0, 0, 0, 0))], grid, name)
            add(f"{kind} of {NODES}^3, {name}", POINTS, at(field, here))
    starts = rng.uniform(0, SIDE, (COUNT, 3))
    bars = Segments(starts, starts + rng.normal(size=(COUNT, 3)) * 2, rng.uniform(0.1, 0.4, COUNT))
    scattered = rng.uniform(-0.05 * SIDE, 1.05 * SIDE, (WALKS, 3))
    axis = np.linspace(-0.05 * SIDE, 1.05 * SIDE, round(WALKS ** (1 / 3)))
    for name in TYPES:
        found = [node("nearest", BARS, X, Y, Z, value=result) for result in NEAREST]
        nearest = made(found[:1], bars, name)
        add(f"nearest of {COUNT:,} bars, scattered, {name}", WALKS, at(nearest, scattered.astype(name)))
        add(f"  all that one walk finds, {name}", WALKS, at(made(found, bars, name), scattered.astype(name)))
        add(f"  on a grid, {name}", len(axis) ** 3, on_grid(nearest, axis))
    times = in_turn(cases, rounds)
    rows_ = [
        {"case": n, "Mpoint/s": counts[n] / t.wall / 1e6, "Mpoint/CPU s": counts[n] / t.cpu / 1e6}
        for n, t in times.items()
    ]
    for row in rows_:
        kind = str(row["case"]).rpartition(" ")[2]
        if "lookup" in str(row["case"]):
            row["/ SciPy, wall"] = times[SCIPY.format(kind)].wall / times[str(row["case"])].wall
            row["/ SciPy, CPU"] = times[SCIPY.format(kind)].cpu / times[str(row["case"])].cpu
    return rows_


def made(roots: list[Node], read: Data, name: str) -> Field:
    """The field of roots that read data, in a type by NumPy's name."""
    formula = Formula(tuple(roots), {GRID if isinstance(read, SampledField) else BARS: read})
    return make_field(formula, {}, "numpy", TYPES[name])  # type: ignore[arg-type]  # a str that is f32 or f64


def at(field: Field, points: Any) -> Case:
    return lambda: field(points)


def on_grid(field: Field, axis: Any) -> Case:
    return lambda: field.on_grid([axis] * 3).all()


def scipy(values: Any, points: Any) -> Case:
    return lambda: map_coordinates(values, points, order=1, mode="nearest")
