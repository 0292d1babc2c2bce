"""`pore mesh`: the surface of a part, to a file, with a short report."""

from __future__ import annotations

import time
from argparse import Namespace

from porelang.atomic import destination
from porelang.checks import broken_checks, undecided_checks
from porelang.cli import report
from porelang.cli.evaluate import machine
from porelang.cli.loading import bound
from porelang.diagnostics import PoreError, fail, to_lists
from porelang.mesh import write
from porelang.mesh.export import writer_of
from porelang.mesh.made import make
from porelang.mesh.part import notes_of
from porelang.mesh.report import facts, text


def mesh(options: Namespace) -> int:
    """Mesh an output, write it and print a report. What can be refused is refused before anything is computed."""
    folder = destination(options.output).parent
    writer_of(options.output)
    if options.voxel is not None and options.resolution is not None:
        raise fail("E108", "--voxel and --resolution say the same thing twice", hint="give one of them")
    design = bound(options)
    destination(options.output, design.program.files)
    if broken := broken_checks(design, measure=True):
        raise PoreError(broken)
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
