"""`pore mesh`: the surface of a part, to a file, with a short report."""

from __future__ import annotations

import time
from argparse import Namespace
from pathlib import Path
from typing import Any

from porelang.atomic import destination
from porelang.checks import broken_checks, undecided_checks
from porelang.cli import report
from porelang.cli.evaluate import machine
from porelang.cli.loading import bound
from porelang.diagnostics import PoreError, fail, to_lists
from porelang.mesh import write
from porelang.mesh.export import writer_of
from porelang.mesh.made import AUTO, make
from porelang.mesh.part import notes_of
from porelang.mesh.report import facts, text
from porelang.program import Design
from porelang.threemf.beams import write_beams


def mesh(options: Namespace) -> int:
    """Mesh an output, write it and print a report. What can be refused is refused before anything is computed."""
    folder = destination(options.output).parent
    writer_of(options.output)
    if options.voxel is not None and options.resolution is not None:
        raise fail("E108", "--voxel and --resolution say the same thing twice", hint="give one of them")
    if options.beams:
        _refuse_with_beams(options)
    design = bound(options)
    destination(options.output, design.program.files)
    if broken := broken_checks(design, measure=True):
        raise PoreError(broken)
    if options.beams:
        return _beams(options, design)
    backend, dtype = machine(options, "f32")
    start = time.perf_counter()
    made = make(
        design, options.out, options.voxel, options.resolution, options.bounds, backend, dtype,
        options.smooth, options.sharp, options.simplify, options.force, folder=folder,
    )  # fmt: skip
    doubts = [*undecided_checks(design), *made.doubts, *design.told(*design.program.roots(options.out))]
    report.say([] if options.quiet else doubts)
    write(made.surface, options.output, notes_of(design, options.out))
    seconds = round(time.perf_counter() - start, 3)
    found = facts(made.surface) | made.facts | {"seconds": seconds, "backend": backend}
    if options.json:
        report.put(
            {"file": options.output, "output": design.program.output(options.out), **found}
            | to_lists([*options.doubts, *doubts])
        )
    elif not options.quiet:
        print(text(options.output, found))
    return 0


#: Options of triangles, which bars have none of.
_OF_TRIANGLES = ("smooth", "sharp", "simplify", "force")


def _refuse_with_beams(options: Namespace) -> None:
    if Path(options.output).suffix.lower() != ".3mf":
        raise fail("E108", "bars are written in .3mf alone", hint="end the name with .3mf, or leave out --beams")
    for name in _OF_TRIANGLES:
        if getattr(options, name):
            raise fail("E108", f"--{name} is about triangles, and --beams writes none", hint="leave one of them out")


def _beams(options: Namespace, design: Design) -> int:
    """Write an output that is a union of bars as bars."""
    start = time.perf_counter()
    voxel = None if options.voxel == AUTO else options.voxel
    found = write_beams(
        design, options.output, name=options.out, bounds=options.bounds, voxel=voxel, resolution=options.resolution
    )
    doubts = [*undecided_checks(design), *design.told(*design.program.roots(options.out))]
    report.say([] if options.quiet else doubts)
    seconds = round(time.perf_counter() - start, 3)
    if options.json:
        report.put({"file": options.output, **found, "seconds": seconds} | to_lists([*options.doubts, *doubts]))
    elif not options.quiet:
        least, most = (f"{r:.3g}" for r in found["radius"])
        radii = least if least == most else f"{least} to {most}"
        print(f"{options.output}: {found['bars']:,} bars of the radius {radii} mm, {found['nodes']:,} ends"
              f"{_cut(found['clip'])}, {seconds:.1f} s")  # fmt: skip
    return 0


def _cut(clip: dict[str, Any] | None) -> str:
    if clip is None:
        return ", not cut"
    if "lo" in clip:
        size = " x ".join(f"{b - a:.4g}" for a, b in zip(clip["lo"], clip["hi"], strict=True))
        return f", cut at a box of {size} mm"
    return f", cut at a mesh of {clip['triangles']:,} triangles (voxel {clip['voxel']:.3g} mm)"
