"""`pore mesh`: the surface of a part, to a file, with a short report."""

from __future__ import annotations

import math
import time
from argparse import Namespace
from typing import Any

from porelang.analysis.box import Box, block
from porelang.atomic import destination
from porelang.checks import broken_checks
from porelang.cli import report
from porelang.cli.evaluate import machine
from porelang.cli.loading import load
from porelang.diagnostics import Diagnostic, PoreError, fail
from porelang.field import checked_bounds, number_type, rounding_doubts
from porelang.ir import node
from porelang.mesh import Surface, write
from porelang.mesh.export import writer_of
from porelang.mesh.part import grid_of, notes_of, refine, surface_of
from porelang.program import Design
from porelang.tasks.numbers.integrals import volume

#: More samples than this are a slip of the voxel, not a wish.
MOST_NODES = 20_000_000_000


def mesh(options: Namespace) -> int:
    """Mesh an output, write it and print a report. What can be refused is refused before anything is computed."""
    writer_of(options.output)
    folder = destination(options.output).parent
    if options.voxel is not None and options.resolution is not None:
        raise fail("E108", "--voxel and --resolution say the same thing twice", hint="give one of them")
    design = load(options).design(dict(options.settings))
    if broken := broken_checks(design, measure=True):
        raise PoreError(broken)
    _refuse_too_fine(design, options)
    backend, dtype = machine(options, "f32")
    start = time.perf_counter()
    placed = grid_of(design, options.out, options.voxel, options.resolution, options.bounds)
    surface = surface_of(design, options.out, placed, backend, dtype, folder=folder)
    refined = refine(
        surface, design, options.out, placed, smooth=options.smooth, sharp=options.sharp, deviation=options.simplify
    )
    surface = refined.surface
    part, box = design.of(options.out), Box(*placed.cut)
    dtype = number_type(part, box, placed.grid.spacing, backend, dtype)
    doubts = too_coarse(design, options, surface)
    doubts += rounding_doubts(part, box, placed.grid.spacing, backend, dtype)
    report.say([] if options.quiet else doubts)
    write(surface, options.output, notes_of(design, options.out))
    seconds = round(time.perf_counter() - start, 3)
    found = facts(surface) | refined.facts | {"seconds": seconds, "backend": backend, "dtype": dtype}
    if options.json:
        report.put(
            {"file": options.output, "output": design.program.output(options.out), **found}
            | {"warnings": [d.to_json() for d in doubts]}
        )
    elif not options.quiet:
        print(_text(options.output, found))
    return 0


#: A mesh whose volume is further than this from the part's is not the part.
COARSE = 0.03


def too_coarse(design: Design, options: Namespace, surface: Surface) -> list[Diagnostic]:
    """A warning where the mesh does not hold the part's volume: walls thinner than a voxel come out as specks."""
    part = design.of(options.out)
    if options.bounds:
        part = part.with_roots(node("max", part.root, block(checked_bounds(options.bounds))))
    true = volume(part, accuracy=2e-3)
    off = abs(surface.volume - true.value)
    if off <= COARSE * true.value + true.error:
        return []
    return [
        Diagnostic(
            "W202",
            f"the voxel is too coarse: the mesh holds {surface.volume:.4g} mm3, the part "
            f"{true.value:.4g} +- {true.error:.2g} mm3",
            design.program.outputs[design.program.output(options.out)].span,
            "what is thinner than a voxel is lost or torn",
            hint="use a smaller --voxel, a few to the thinnest wall",
            severity="warning",
        )
    ]


def _refuse_too_fine(design: Design, options: Namespace) -> None:
    """Refuse a grid of more nodes than anybody waits for. Errors: E114."""
    if options.voxel is None and options.resolution is None:
        return
    box = checked_bounds(options.bounds) if options.bounds else design.bounds(options.out)
    voxel = options.voxel or max(box.size) / options.resolution
    nodes = math.prod(s / voxel + 2 for s in box.size)
    if nodes > MOST_NODES:
        enough = (math.prod(box.size) / MOST_NODES) ** (1 / 3)
        digits = 1 - math.floor(math.log10(enough))
        enough = math.ceil(enough * 10**digits) / 10**digits
        size = " x ".join(f"{s:g}" for s in box.size)
        raise fail(
            "E114",
            f"a voxel of {voxel:g} mm asks for {nodes:.2g} samples of a box of {size} mm",
            hint=f"a voxel of {enough:g} mm would do; or mesh a part of it with --bounds",
        )


def facts(surface: Surface) -> dict[str, Any]:
    """What a mesh is, in mm, mm2 and mm3; `components` counts the closed surfaces."""
    lo, hi = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    return {
        "triangles": len(surface.faces),
        "vertices": len(surface.vertices),
        "volume": surface.volume,
        "area": surface.area,
        "bounds": [lo.tolist(), hi.tolist()],
        "components": surface.components,
    }


def _text(path: str, found: dict[str, Any]) -> str:
    lo, hi = found["bounds"]
    size = " x ".join(f"{b - a:.4g}" for a, b in zip(lo, hi, strict=True))
    lines = {
        "triangles": f"{found['triangles']:,}",
        "volume": f"{found['volume']:.6g} mm3",
        "area": f"{found['area']:.6g} mm2",
        "size": f"{size} mm",
        "from": f"{', '.join(f'{v:.5g}' for v in lo)}",
        "to": f"{', '.join(f'{v:.5g}' for v in hi)}",
        "surfaces": f"{found['components']}{'' if found['components'] == 1 else ' that are not joined'}",
        "time": f"{found['seconds']:.2f} s ({found['backend']}, {found['dtype']})",
    }
    if "off_surface" in found:
        stayed = f"; {found['kept']} of them not on it" if found["kept"] else ""
        lines["vertices"] = f"at most {found['off_surface']:.2g} mm off the field{stayed}"
    if "rim_edges" in found:
        lines["rims"] = f"{found['rim_edges']:,} edges on them, {found['corners']:,} corners"
    if "deviation" in found:
        lines["simplified"] = f"from {found['triangles_before']:,} triangles, {found['deviation']:.3g} mm off at most"
    return "\n".join([path, *(f"  {name:<10} {value}" for name, value in lines.items())])
