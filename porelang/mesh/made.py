"""A mesh as it is asked for: its voxel, its crumbs, its vertices and rims, its promises, and what is to be said of
it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from porelang.analysis.box import Box
from porelang.backends.numpy import Dtype
from porelang.diagnostics import Diagnostic, PoreError, fail
from porelang.field import Backend, Bounds, checked_bounds, number_type, rounding_doubts
from porelang.mesh.crossed import crossed
from porelang.mesh.crumbs import Settled, settle
from porelang.mesh.doubts import Coarse, crossed_doubts, explained, hopeless, lost_doubts, torn_doubts, volume_doubts
from porelang.mesh.enclosed import material
from porelang.mesh.mend import kept_sound
from porelang.mesh.part import grid_of, refine, surface_of
from porelang.mesh.surface import Surface
from porelang.program import Design
from porelang.progress import activity
from porelang.solid import Solid
from porelang.walls import Chosen, chosen

AUTO = "auto"
#: Pieces of a mesh that are told one by one.
LISTED = 20


@dataclass(frozen=True, slots=True)
class Made:
    """A sound mesh, what is to be reported of it, and what is doubtful about it (warnings)."""

    surface: Surface
    facts: dict[str, Any]
    doubts: list[Diagnostic]


def make(
    design: Design,
    name: str | None = None,
    voxel: float | str | None = None,
    resolution: int | None = None,
    bounds: Bounds | None = None,
    backend: Backend = "numpy",
    dtype: Dtype = "f32",
    smooth: bool = False,
    sharp: bool = False,
    simplify: float | None = None,
    force: bool = False,
    folder: Path | None = None,
) -> Made:
    """The surface of an output on a grid, without crumbs, refined, sound.

    The voxel is the one given (mm), or so that `resolution` of them lie along the longest side; where neither is given,
    or `voxel` is "auto", it is found from the walls and gaps. Errors: those of `grid_of` and `surface_of`; E111 where
    all lies between the samples; E118 where the mesh has lost more than a fifth of the part, unless `force`; E119 where
    it is not sound.
    """
    number = isinstance(simplify, int | float | np.number) and not isinstance(simplify, bool)
    if simplify is not None and not (number and 0 < simplify < math.inf):
        raise fail("E114", f"{simplify!r} is no deviation to simplify within", hint="give a number of mm above 0")
    if isinstance(voxel, str) and voxel == AUTO and resolution is None:
        voxel = None
    choice: Chosen | None = None
    if voxel is None and resolution is None:
        box = checked_bounds(bounds) if bounds is not None else design.bounds(name)
        choice = chosen(Solid(design.of(name), box))
        voxel = choice.voxel
    placed = grid_of(design, name, voxel, resolution, bounds)  # type: ignore[arg-type]  # which refuses a text
    part = Solid(design.of(name), placed.cut)
    whole, spacing = Box(*placed.cut), placed.grid.spacing
    dtype = number_type(design.of(name), whole, spacing, backend, dtype)
    try:
        surface = surface_of(design, name, placed, backend, dtype, folder=folder)
    except PoreError as error:
        if error.diagnostics[0].code != "E111":
            raise
        raise explained(error, placed.grid, part) from None
    if not (force or smooth or sharp) and hopeless(part, surface.volume):  # before the longer looks
        volume_doubts(design, name, bounds, surface.volume, part, Coarse(spacing, None, surface.volume))
    with activity("looking at pieces"):
        settled = settle(surface, placed.grid, part)
    raw = surface = settled.surface
    held, facts = raw.volume, {**_found(settled, choice, spacing), "dtype": dtype}
    refined = smooth or sharp or simplify is not None
    if refined:
        done = refine(surface, design, name, placed, smooth=smooth, sharp=sharp, deviation=simplify)
        surface = done.surface
        facts |= done.facts
    surface = kept_sound(surface, spacing, refined)
    # The mesh is judged as it will be written: rims that are cut sharp give back what a coarse voxel lost.
    coarse = Coarse(spacing, simplify, held)
    doubts = volume_doubts(design, name, bounds, surface.volume, part, coarse, force)
    if not doubts:  # of a mesh that lost much of its volume no more is said
        doubts += lost_doubts(design, name, raw, surface, placed.grid, part)
    doubts += rounding_doubts(design.of(name), whole, spacing, backend, dtype)
    doubts += torn_doubts(design, name, settled, placed.grid)
    if refined:
        crossing = crossed(surface)
        facts["crossed"] = int(crossing.sum())
        doubts += crossed_doubts(design, name, surface, crossing)
    return Made(surface, facts, doubts)


def _found(settled: Settled, choice: Chosen | None, voxel: float) -> dict[str, Any]:
    """The pieces of a mesh, what was taken out of it, and its voxel."""
    pieces = settled.surface.pieces
    holds = material(settled.surface)  # of a solid without the voids in it
    order = np.argsort(-np.abs(holds))
    solids = [int(i) for i in order if pieces.volume[i] >= 0]
    voids = [int(i) for i in order if pieces.volume[i] < 0]

    def told(which: list[int]) -> list[dict[str, Any]]:
        return [
            {"volume": abs(float(holds[i])), "bounds": [pieces.low[i].tolist(), pieces.high[i].tolist()]}
            for i in which[:LISTED]
        ]

    facts: dict[str, Any] = {
        "voxel": voxel,
        "components": len(order),
        "solids": len(solids),
        "voids": len(voids),
        "solid_pieces": told(solids),
        "closed_voids": told(voids),
        "crumbs": {
            "removed": settled.removed,
            "removed_volume": settled.removed_volume,
            "filled": settled.filled,
            "filled_volume": settled.filled_volume,
            "torn": settled.torn,
            "unknown": settled.unknown,
            "pending": settled.pending,
            "slivers": settled.slivers,
            "slivers_volume": settled.slivers_volume,
        },
    }
    if choice is not None:
        facts |= {"wall": choice.wall, "gap": choice.gap, "voxel_for_wall": choice.wanted}
    return facts
