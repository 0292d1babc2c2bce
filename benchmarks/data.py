"""Lookup in a sampled field against SciPy's, and the nearest of 100 000 bars, in millions of points per second."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.ndimage import map_coordinates
from timing import Case, in_turn

from porelang.backends.numpy import PIECE
from porelang.data import SampledField, Segments
from porelang.ops import grid as lookups
from porelang.ops import segments as walks
from porelang.parallel import parallel_for, workers

NODES, POINTS, BARS, WALKS = 128, 20_000_000, 100_000, 1_000_000
SIDE = 100.0  # mm
SCIPY = "SciPy map_coordinates, order 1, {}"


def data(rounds: int) -> list[dict[str, Any]]:
    """Each case with its rate; lookup also as a ratio to SciPy's in the same type and run."""
    rng, threads = np.random.default_rng(1), workers(None)
    cases: dict[str, Case] = {}
    counts: dict[str, int] = {}

    def add(name: str, count: int, case: Case) -> None:
        cases[name], counts[name] = case, count

    def lookup(grid: SampledField, points: Any, out: Any, cubic: bool) -> Case:
        function = lookups.lookup_cubic if cubic else lookups.lookup
        payload = (0, 0, 0, 0)

        def piece(start: int) -> None:
            x, y, z = points[:, start : start + PIECE]
            function(grid, x, y, z, payload, out[start : start + PIECE])

        return lambda: parallel_for(piece, range(0, points.shape[1], PIECE), threads)

    def walk(bars: Segments, pieces: list[Any], wanted: tuple[str, ...]) -> Case:
        return lambda: parallel_for(lambda p: void(walks.nearest(bars, *p, wanted)), pieces, threads)

    for dtype in (np.float32, np.float64):
        name = np.dtype(dtype).name
        values = rng.normal(size=(NODES,) * 3).astype(dtype)
        grid = SampledField.from_array(values, (0, 0, 0), 1.0)
        points = rng.uniform(0, NODES - 1, (3, POINTS)).astype(dtype)
        out = np.empty(POINTS, dtype)
        add(SCIPY.format(name), POINTS, scipy(values, points, out))
        add(f"lookup of {NODES}^3, {name}", POINTS, lookup(grid, points, out, False))
        add(f"cubic lookup of {NODES}^3, {name}", POINTS, lookup(grid, points, out, True))
    starts = rng.uniform(0, SIDE, (BARS, 3))
    bars = Segments(starts, starts + rng.normal(size=(BARS, 3)) * 2, rng.uniform(0.1, 0.4, BARS))
    for dtype in (np.float32, np.float64):
        name = np.dtype(dtype).name
        scattered = rng.uniform(-0.05 * SIDE, 1.05 * SIDE, (3, WALKS)).astype(dtype)
        pieces = [scattered[:, i : i + PIECE] for i in range(0, WALKS, PIECE)]
        add(f"nearest of {BARS:,} bars, scattered, {name}", WALKS, walk(bars, pieces, ("distance",)))
        add(f"  all that one walk finds, {name}", WALKS, walk(bars, pieces, walks.RESULTS))
        axis = np.linspace(-0.05 * SIDE, 1.05 * SIDE, round(WALKS ** (1 / 3))).astype(dtype)
        rows = [(axis[i : i + 1, None, None], axis[None, :, None], axis[None, None, :]) for i in range(len(axis))]
        add(f"  on a grid, {name}", len(axis) ** 3, walk(bars, rows, ("distance",)))
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


def scipy(values: Any, points: Any, out: Any) -> Case:
    return lambda: map_coordinates(values, points, output=out, order=1, mode="nearest")


def void(_: object) -> None:
    pass
