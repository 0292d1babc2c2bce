"""What walls in mm cost: a shell of a lattice's true distance against one of its raw values, in the same run."""

from __future__ import annotations

from typing import Any

import numpy as np
from timing import Case, in_turn

import porelang

SHELLS = {
    "raw": "gyroid(10) |> shell(1.5) & cylinder(20, 30)",
    "metric": "metric(gyroid(10)) |> shell(1.6mm) & cylinder(20, 30)",
}
POINTS = 1_000_000
VOXEL = 0.3  # mm


def metric(rounds: int) -> list[dict[str, Any]]:
    points = np.random.default_rng(0).uniform(-20, 20, (POINTS, 3))
    programs = {name: porelang.compile(text) for name, text in SHELLS.items()}
    single = {name: program.field(dtype="f32", threads=1) for name, program in programs.items()}
    cases: dict[str, Case] = {}
    for name, program in programs.items():
        cases[f"{name}, a million points, 1 thread"] = lambda name=name: single[name](points)
        cases[f"{name}, mesh"] = lambda program=program: program.mesh("part", voxel=VOXEL)
    times = in_turn(cases, rounds)
    rows = []
    for case, t in times.items():
        raw = times[case.replace("metric", "raw")]
        rows.append({"case": case, "s": t.wall, "CPU s": t.cpu, "/ raw, CPU": t.cpu / raw.cpu})
    return rows
