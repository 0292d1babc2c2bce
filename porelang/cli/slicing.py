"""`pore slices`: layers for printing."""

from __future__ import annotations

import time
from argparse import Namespace
from functools import partial
from pathlib import Path
from typing import Any

from porelang.atomic import destination
from porelang.checks import broken_checks, undecided_checks
from porelang.cli import report
from porelang.cli.evaluate import machine
from porelang.cli.loading import bound
from porelang.diagnostics import PoreError, fail, to_lists
from porelang.mesh.doubts import layer_doubts
from porelang.progress import watching
from porelang.slices import SLICING, write_layer_file, write_slices


def slices(options: Namespace) -> int:
    """Write the layers of an output into a folder, or into a .cli file."""
    one = Path(options.output).suffix.lower() == ".cli"
    if one and options.format is not None:
        raise fail("E108", f"--format is of a folder of layers, and `{options.output}` is a file",
                   hint="leave it out, or name a folder")  # fmt: skip
    design = bound(options)
    if one:
        destination(options.output, design.program.files)
    if broken := broken_checks(design, measure=True):
        raise PoreError(broken)
    backend, dtype = machine(options, "f32")
    start = time.perf_counter()
    told = report.progress(options.quiet)
    done, of = 0, 0

    def progress(activity: str, layer: int, layers: int) -> None:
        nonlocal done, of
        if activity == SLICING and layer:
            done, of = layer, layers
        if told is not None:
            told(activity, layer, layers)

    try:
        with watching(progress):
            write = write_layer_file if one else partial(write_slices, form=options.format or "png")
            found = write(
                design, options.output, options.step, name=options.out, pixel=options.voxel, bounds=options.bounds,
                backend=backend, dtype=dtype,
            )  # fmt: skip
    except KeyboardInterrupt:
        if not options.quiet:
            report.note(f"\nstopped after {done} of {of or 'all'} layers: nothing is written to {options.output}")
        raise
    doubts = layer_doubts(design, options.out, options.bounds, found["volume"], found["step"], found["pixel"])
    doubts += [*undecided_checks(design), *design.told(*design.program.roots(options.out))]
    report.say([] if options.quiet else doubts)
    seconds = round(time.perf_counter() - start, 3)
    if options.json:
        report.put(
            {
                "file" if one else "folder": options.output,
                **found,
                "seconds": seconds,
                **to_lists([*options.doubts, *doubts]),
            }
        )
    elif not options.quiet:
        print(f"{options.output}: {of_layers(found)}, {found['volume']:.6g} mm3, {seconds:.1f} s")
    return 0


def of_layers(found: dict[str, Any]) -> str:
    """`30 layers of 0.1 mm`, and how much of the last the part fills."""
    count, step = found["layers"], found["step"]
    last = found["bounds"][1][2] - found["bounds"][0][2] - (count - 1) * step
    text = f"{count} layer{'' if count == 1 else 's'} of {step:g} mm"
    return text if last > 0.999 * step else f"{text}, the last filled to {last:.3g} mm"
