"""From an output of a design to triangles: bounds, grid, bricks that may hold surface, samples, mesh."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from porelang.analysis.bounds import box_test, overflows
from porelang.analysis.box import Box, block
from porelang.analysis.branches import Branches
from porelang.analysis.enclose import F32, F64
from porelang.backends.numpy import Dtype, NumpyField
from porelang.diagnostics import PoreError, fail
from porelang.field import Backend, Bounds, checked_bounds, make_field, number_type
from porelang.formula import Formula
from porelang.ir import node
from porelang.mesh import Grid, Surface, extract, project
from porelang.mesh.grid import Point
from porelang.mesh.layers import clip
from porelang.mesh.sharpen import sharpen
from porelang.mesh.simplify import simplify
from porelang.parallel import workers
from porelang.program import Design
from porelang.progress import activity
from porelang.walls import RESOLUTION


@dataclass(frozen=True, slots=True)
class Placed:
    """The grid that an output is sampled on, and the box that its surface is cut at."""

    grid: Grid
    cut: tuple[Point, Point]


def grid_of(
    design: Design,
    name: str | None = None,
    voxel: float | None = None,
    resolution: int | None = None,
    bounds: Bounds | None = None,
) -> Placed:
    """Where an output is sampled: at the `voxel` (mm), or with `resolution` samples along the longest side.

    Where `bounds` are given the part is cut flat at them; else they are found from the program.
    Errors: E100-E103 about the output, E107 about bounds.
    """
    box = checked_bounds(bounds) if bounds is not None else design.bounds(name)
    if voxel is None and resolution is None:
        resolution = RESOLUTION
    grid = Grid.cover(box.lo, box.hi, voxel, resolution)
    if bounds is not None:
        return Placed(grid, (box.lo, box.hi))
    # The part ends of itself: its surface is not to be cut by a plane through it.
    h = grid.spacing
    lo, hi = tuple(a - h for a in box.lo), tuple(b + h for b in box.hi)
    cut = ((lo[0], lo[1], lo[2]), (hi[0], hi[1], hi[2]))
    return Placed(Grid.cover(*cut, spacing=h), cut)


def surface_of(
    design: Design,
    name: str | None = None,
    placed: Placed | None = None,
    backend: Backend = "numpy",
    dtype: Dtype | None = None,
    *,
    threads: int | None = None,
    prune: bool = True,
    folder: Path | None = None,
) -> Surface:
    """The closed surface of an output on a grid (that of `grid_of` if none is given), in mm, outward.

    Sampled in `dtype`; where none is given in float32, or where that does not do in float64 (`number_type`).
    `prune` rules out bricks that hold no surface before they are sampled; the triangles are the same without. What
    does not fit the memory goes to files without names in `folder`.
    Errors: E100-E103 about the output, E110, E111, E114 about the field on the grid.
    """
    return surface_in(design, design.of(name), placed or grid_of(design, name), backend, dtype, threads, prune, folder)


def surface_in(
    design: Design,
    formula: Formula,
    placed: Placed,
    backend: Backend = "numpy",
    dtype: Dtype | None = None,
    threads: int | None = None,
    prune: bool = True,
    folder: Path | None = None,
) -> Surface:
    """The closed surface of a formula of a design on a grid: see `surface_of`."""
    dtype = dtype or number_type(formula, Box(*placed.cut), placed.grid.spacing, backend, "f32")
    field = make_field(formula, design.program.ranges, backend, dtype, threads=1)
    precision = F32 if field.backend == "glsl" or dtype == "f32" else F64
    try:
        with activity("meshing"):
            return extract(
                placed.grid,
                placed.cut,
                field.on_grid(placed.grid.axes()).block,
                box_test(formula, precision) if prune else None,
                field=NumpyField(formula.taken, dtype, 1).at,
                threads=workers(threads),
                folder=folder,
            )
    except PoreError as error:
        if error.diagnostics[0].code == "E110" and precision is F32 and overflows(formula, *placed.cut):
            what = error.diagnostics[0].message
            raise fail(
                "E110",
                f"{what}: values there are too large for float32, which ends at {F32.huge:.1e}",
                hint="use --backend numpy, which takes float64 where it has to",
            ) from None
        raise


@dataclass(frozen=True, slots=True)
class Refined:
    """A surface that was refined, and what is to be said about it."""

    surface: Surface
    facts: dict[str, float | int]


def refine(
    surface: Surface,
    design: Design,
    name: str | None,
    placed: Placed,
    *,
    smooth: bool = False,
    sharp: bool = False,
    deviation: float | None = None,
) -> Refined:
    """A meshed output with its vertices on the field, its rims sharp, and no more triangles than `deviation` (mm) asks.

    `sharp` includes `smooth`: what is cut are edges between points on the surface. `placed` is what it was meshed on.
    """
    facts: dict[str, float | int] = {}
    with activity("refining"):
        if smooth or sharp:
            raw, layers = surface.vertices, clip(placed.grid, *placed.cut)
            formula = design.of(name)
            field = Branches(formula)
            smoothed = project.smooth(surface, field.slope, layers)
            surface = smoothed.surface
            facts |= {"off_surface": smoothed.off, "kept": smoothed.kept}
            if sharp:
                if project.capped(raw, layers).any():  # caps are surfaces too, and have rims
                    field = Branches(formula.with_roots(node("max", formula.root, block(Box(*placed.cut)))))
                sharpened = sharpen(surface, raw, layers, field)
                surface = sharpened.surface
                facts |= {"off_surface": sharpened.off, "kept": sharpened.kept}
                facts |= {"rim_edges": sharpened.rims, "corners": sharpened.corners}
        if deviation is not None:
            simplified = simplify(surface, deviation, threads=workers())
            facts |= {"triangles_before": len(surface.faces), "deviation": simplified.deviation}
            surface = simplified.surface
    return Refined(surface, facts)


def _printable(name: str) -> str:
    """A name whose bytes are no text, as they are written elsewhere: `\\xff`."""
    return "".join(f"\\x{ord(c) & 0xFF:02x}" if "\ud800" <= c <= "\udfff" else c for c in name)


def notes_of(design: Design, name: str | None) -> dict[str, str]:
    """What made a mesh, for its file: program, SHA-256 of its text, output, and every param in base units."""
    source = design.program.source
    made = {
        "program": _printable(Path(source.name).name),
        "sha256": hashlib.sha256(source.text.encode()).hexdigest(),
        "output": design.program.output(name),
    }
    return made | {f"param.{param}": repr(value) for param, value in design.settings.items()}
