"""`pore volume`: the values of fields on a grid, to a file."""

from __future__ import annotations

import time
from argparse import Namespace

from porelang.atomic import destination
from porelang.checks import undecided_checks
from porelang.cli import report
from porelang.cli.evaluate import machine
from porelang.cli.loading import bound
from porelang.diagnostics import fail, to_lists
from porelang.volume import write_volume


def volume(options: Namespace) -> int:
    """Write the values of an output and of further fields at the nodes of a grid."""
    if options.voxel is not None and options.resolution is not None:
        raise fail("E108", "--voxel and --resolution say the same thing twice", hint="give one of them")
    design = bound(options)
    destination(options.output, design.program.files)
    backend, dtype = machine(options, "f32")
    start = time.perf_counter()
    found = write_volume(
        design, options.output, name=options.out, fields=options.fields, voxel=options.voxel,
        resolution=options.resolution, bounds=options.bounds, backend=backend, dtype=dtype,
    )  # fmt: skip
    doubts = [*undecided_checks(design), *design.told(*design.program.roots(options.out))]
    report.say([] if options.quiet else doubts)
    seconds = round(time.perf_counter() - start, 3)
    if options.json:
        report.put({"file": options.output, **found, "seconds": seconds, **to_lists([*options.doubts, *doubts])})
    elif not options.quiet:
        nodes = " x ".join(f"{n:,}" for n in found["nodes"])
        names = ", ".join(found["fields"])
        print(f"{options.output}: {names} at {nodes} nodes, {found['spacing']:.4g} mm apart, {seconds:.1f} s")
    return 0
