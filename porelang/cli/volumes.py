"""`pore volume`: the values of fields on a grid, or a field as a function, to a file."""

from __future__ import annotations

import math
import time
from argparse import Namespace
from pathlib import Path
from typing import Any

from porelang.atomic import destination
from porelang.checks import undecided_checks
from porelang.cli import report
from porelang.cli.evaluate import machine
from porelang.cli.loading import bound
from porelang.diagnostics import fail, to_lists
from porelang.program import Design
from porelang.threemf.field import write_field
from porelang.volume import write_volume


def volume(options: Namespace) -> int:
    """Write the values of an output and of further fields at the nodes of a grid; in .3mf the output as a function."""
    if Path(options.output).suffix.lower() == ".3mf":
        return _function(options)
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
    nodes = " x ".join(f"{n:,}" for n in found["nodes"])
    names = ", ".join(found["fields"])
    return _told(options, design, found, f"{names} at {nodes} nodes, {found['spacing']:.4g} mm apart", start)


#: Options that say how values lie on a grid, by what they are called.
_OF_GRIDS = {"voxel": "--voxel", "resolution": "--resolution", "fields": "--field", "dtype": "--dtype"}


def _function(options: Namespace) -> int:
    for name, flag in _OF_GRIDS.items():
        if getattr(options, name):
            raise fail("E108", f"a .3mf file holds the function of the part, and no values: it takes no {flag}",
                       hint=f"leave out {flag}, or write .vti or .npz")  # fmt: skip
    design = bound(options)
    destination(options.output, design.program.files)
    start = time.perf_counter()
    found = write_field(design, options.output, name=options.out, bounds=options.bounds)
    size = " x ".join(f"{b - a:.4g}" for a, b in zip(found["lo"], found["hi"], strict=True))
    said = f"{found['output']} as a function of {found['nodes']:,} nodes in a box of {size} mm"
    if images := found["images"]:
        voxels = sum(math.prod(image["nodes"]) for image in images)
        many = "an image" if len(images) == 1 else f"{len(images)} images"
        off = max(image["error"] for image in images)
        said += f", {many} of {voxels:,} voxels whose values are {off:.2g} off at most"
    return _told(options, design, found, said, start)


def _told(options: Namespace, design: Design, found: dict[str, Any], said: str, start: float) -> int:
    """Report what was written, with what is doubtful."""
    doubts = [*undecided_checks(design), *design.told(*design.program.roots(options.out))]
    report.say([] if options.quiet else doubts)
    seconds = round(time.perf_counter() - start, 3)
    if options.json:
        report.put({"file": options.output, **found, "seconds": seconds, **to_lists([*options.doubts, *doubts])})
    elif not options.quiet:
        print(f"{options.output}: {said}, {seconds:.1f} s")
    return 0
