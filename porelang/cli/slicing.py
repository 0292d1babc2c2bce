"""`pore slices`: layers for printing."""

from __future__ import annotations

import time
from argparse import Namespace

from porelang.cli import report
from porelang.cli.commands import load
from porelang.cli.evaluate import machine
from porelang.slices import write_slices


def slices(options: Namespace) -> int:
    """Write the layers of an output into a folder."""
    program = load(options)
    backend, dtype = machine(options, "f32")
    start = time.perf_counter()
    found = write_slices(
        program,
        options.output,
        options.step,
        name=options.out,
        form=options.format,
        pixel=options.voxel,
        bounds=options.bounds,
        backend=backend,
        dtype=dtype,
        settings=dict(options.settings),
        progress=report.progress("slicing", options.quiet),
    )
    seconds = round(time.perf_counter() - start, 3)
    if options.json:
        report.put({"folder": options.output, **found, "seconds": seconds})
    elif not options.quiet:
        layers = f"{found['layers']} layers of {options.step:g} mm"
        print(f"{options.output}: {layers}, {found['volume']:.6g} mm3, {seconds:.1f} s")
    return 0
