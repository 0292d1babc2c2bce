"""From a program's output to triangles: bounds, grid, bricks that may hold surface, samples, mesh."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from porelang.analysis.bounds import box_test
from porelang.analysis.box import Box
from porelang.analysis.branches import Branches
from porelang.analysis.enclose import F32, F64
from porelang.backends.numpy import Dtype, workers
from porelang.diagnostics import fail
from porelang.ir import node
from porelang.mesh import Grid, Surface, extract, project
from porelang.mesh.grid import Point
from porelang.mesh.layers import clip
from porelang.mesh.sharpen import sharpen
from porelang.mesh.simplify import simplify
from porelang.program import FARTHEST, Backend, Program, make_field
from porelang.settings import Setting, settle

#: Samples along the longest side where neither a voxel nor a resolution is asked for.
RESOLUTION = 128
Bounds = tuple[float, float, float, float, float, float]


def mesh_output(
    program: Program,
    name: str | None = None,
    voxel: float | None = None,
    resolution: int | None = None,
    bounds: Bounds | None = None,
    backend: Backend = "numpy",
    dtype: Dtype = "f32",
    settings: Mapping[str, Setting] | None = None,
    *,
    threads: int | None = None,
    prune: bool = True,
    folder: Path | None = None,
    progress: Callable[[int, int], None] | None = None,
    cancel: Callable[[], bool] | None = None,
) -> Surface:
    """The closed surface of an output, in mm, outward.

    Where `bounds` are given the part is cut flat at them; else they are found from the program. `prune` rules out
    bricks that hold no surface before they are sampled; the triangles are the same without. What does not fit the
    memory goes to files without names in `folder`.
    Errors: E100-E103 about the output, E107 about bounds, E110, E111, E114 about the field on the grid.
    """
    root = program.solid(name)
    values = program.settle(**(settings or {}))
    grid, cut = grid_of(program, name, voxel, resolution, bounds, settings)
    field = make_field((root,), values, program.graph.ranges, backend, dtype, threads=1)
    sampled = field.on_grid(grid.axes())
    return extract(
        grid,
        cut,
        sampled.block,
        box_test(root, values, F32 if field.backend == "glsl" or dtype == "f32" else F64) if prune else None,
        threads=workers(threads),
        folder=folder,
        progress=progress,
        cancel=cancel,
    )


def grid_of(
    program: Program,
    name: str | None = None,
    voxel: float | None = None,
    resolution: int | None = None,
    bounds: Bounds | None = None,
    settings: Mapping[str, Setting] | None = None,
) -> tuple[Grid, tuple[Point, Point]]:
    """The grid that an output is sampled on, and the box that its surface is cut at."""
    box = checked_bounds(bounds) if bounds is not None else found_bounds(program, name, settings or {})
    if voxel is None and resolution is None:
        resolution = RESOLUTION
    grid = Grid.cover(box.lo, box.hi, voxel, resolution)
    if bounds is not None:
        return grid, (box.lo, box.hi)
    # The part ends of itself: its surface is not to be cut by a plane through it.
    h = grid.spacing
    lo, hi = tuple(a - h for a in box.lo), tuple(b + h for b in box.hi)
    cut = ((lo[0], lo[1], lo[2]), (hi[0], hi[1], hi[2]))
    return Grid.cover(*cut, spacing=h), cut


@dataclass(frozen=True, slots=True)
class Refined:
    """A surface that was refined, and what is to be said about it."""

    surface: Surface
    facts: dict[str, float | int]


def refine(
    surface: Surface,
    program: Program,
    name: str | None,
    grid: Grid,
    cut: tuple[Point, Point],
    settings: Mapping[str, Setting] | None = None,
    *,
    smooth: bool = False,
    sharp: bool = False,
    deviation: float | None = None,
    progress: Callable[[int, int], None] | None = None,
    cancel: Callable[[], bool] | None = None,
) -> Refined:
    """A meshed output with its vertices on the field, its rims sharp, and no more triangles than `deviation` (mm) asks.

    `sharp` includes `smooth`: what is cut are edges between points on the surface. `grid` and `cut` are those of
    `grid_of`. `progress(done, all)` is called between steps, and counts anew for each thing done; `cancel()` as well,
    and a cancelled run raises `CancelledError`.
    """
    from porelang.measure import block  # which itself meshes

    facts: dict[str, float | int] = {}
    if smooth or sharp:
        raw, layers = surface.vertices, clip(grid, *cut)
        root, values = program.solid(name), program.settle(**(settings or {}))
        field = Branches(root, values)
        smoothed = project.smooth(surface, field.slope, layers)
        surface = smoothed.surface
        facts |= {"off_surface": smoothed.off, "kept": smoothed.kept}
        if sharp:
            if project.capped(raw, layers).any():  # caps are surfaces too, and have rims
                field = Branches(node("max", root, block(Box(*cut))), values)
            sharpened = sharpen(surface, raw, layers, field, progress, cancel)
            surface = sharpened.surface
            facts |= {"off_surface": sharpened.off, "kept": sharpened.kept}
            facts |= {"rim_edges": sharpened.rims, "corners": sharpened.corners}
    if deviation is not None:
        simplified = simplify(surface, deviation, threads=workers(None), progress=progress, cancel=cancel)
        facts |= {"triangles_before": len(surface.faces), "deviation": simplified.deviation}
        surface = simplified.surface
    return Refined(surface, facts)


def notes_of(program: Program, name: str | None, settings: Mapping[str, Setting]) -> dict[str, str]:
    """What made a mesh, for its file: program, SHA-256 of its text, output, and every param in base units."""
    made = {
        "program": Path(program.source.name).name,
        "sha256": hashlib.sha256(program.source.text.encode()).hexdigest(),
        "output": program.output(name),
    }
    return made | {f"param.{param}": repr(value) for param, value in settle(program.params, settings).items()}


def found_bounds(program: Program, name: str | None, settings: Mapping[str, Setting]) -> Box:
    """The box that holds the part, remembered: to find it takes as long as many a mesh. Errors: E102, E103."""
    return _bounds(program, name, tuple(sorted(settings.items())))


@lru_cache(maxsize=8)
def _bounds(program: Program, name: str | None, settings: tuple[tuple[str, Setting], ...]) -> Box:
    return program.bounds(name, **dict(settings))


def checked_bounds(bounds: Bounds) -> Box:
    """Six numbers as a box. Errors: E107."""
    try:
        flat = [float(v) for v in np.ravel(bounds)]
    except (TypeError, ValueError):
        flat = []
    if len(flat) != 6 or not np.isfinite(flat).all():
        raise fail("E107", "bounds are six finite numbers", hint="give x0, y0, z0, x1, y1, z1 in mm, or two corners")
    if max(map(abs, flat)) > FARTHEST:
        raise fail("E107", "the bounds reach more than 1000 km from the origin", hint="coordinates are in mm")
    lo, hi = flat[:3], flat[3:]
    if not all(a < b for a, b in zip(lo, hi, strict=True)):
        raise fail("E107", f"the bounds {', '.join(f'{v:g}' for v in flat)} hold no volume",
                   hint="give x0,y0,z0,x1,y1,z1 with each first corner below the second")  # fmt: skip
    return Box((lo[0], lo[1], lo[2]), (hi[0], hi[1], hi[2]))
