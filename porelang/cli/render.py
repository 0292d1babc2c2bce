"""`pore render`: a picture of a part, with cuts and field planes, as PNG."""

from __future__ import annotations

import time
from argparse import Namespace

from porelang.atomic import destination
from porelang.checks import broken_checks
from porelang.cli import report
from porelang.cli.loading import load
from porelang.diagnostics import PoreError, fail


def render(options: Namespace) -> int:
    """Draw an output and write the picture. What can be refused is refused before anything is computed."""
    from porelang.render.camera import VIEWS
    from porelang.render.cuts import HalfSpace
    from porelang.render.picture import Wishes, render_output, write_png
    from porelang.render.planes import Plane, Scale

    destination(options.output)
    if not options.output.lower().endswith(".png"):
        raise fail("E112", f"{options.output}: pictures are written as .png", hint="end the name with .png")
    for option, given in (("--field", options.field), ("--range", options.range), ("--legend", options.legend)):
        if given is not None and not options.slice:
            raise fail("E108", f"{option} is about planes, and there is none", hint="add one: --slice x=0")
    if options.solid == "none" and not options.slice:
        raise fail("E108", "--solid none leaves nothing to be seen", hint="add a plane, as in --slice x=0")
    design = load(options).design(dict(options.settings))
    if broken := broken_checks(design):
        raise PoreError(broken)
    low, high = options.range or (0.0, 0.0)
    wishes = Wishes(
        size=options.size,
        view=VIEWS[options.view] if isinstance(options.view, str) else options.view,
        projection=options.projection,
        zoom=options.zoom,
        samples=options.samples,
        cuts=tuple(tuple(HalfSpace(*side) for side in c) for c in options.cut),
        slices=tuple(Plane(*p) for p in options.slice),
        field=options.field,
        scale=None if options.range is None else Scale(-low or high, high or -low),
        legend=options.legend,
        solid=options.solid or ("glass" if options.slice else "opaque"),
        transparent=options.background == "transparent",
    )
    start = time.perf_counter()
    made = render_output(design, options.out, wishes, options.bounds)
    write_png(made, options.output, wishes.transparent)
    seconds = round(time.perf_counter() - start, 3)
    width, height = options.size
    if not made.covered and wishes.solid != "none" and not options.quiet:
        report.note(
            f"no part of the solid is seen: it is cut away, thinner than {made.pixel:.2g} mm, or out of the picture"
        )
    if options.json:
        report.put(
            {
                "file": options.output,
                "output": design.program.output(options.out),
                "size": [width, height],
                "seconds": seconds,
                "steps": made.steps,
                "covered": made.covered,
                "pixel": made.pixel,
                "slice_range": None if made.scale is None else [-made.scale.low, made.scale.high],
                "backend": made.backend,
            }
        )
    elif not options.quiet:
        lines = {"size": f"{width} x {height} pixels of {made.pixel:.3g} mm"}
        if made.scale is not None:
            lines["planes"] = f"red -{made.scale.low:.3g}, yellow 0, blue {made.scale.high:.3g}"
        lines["time"] = f"{seconds:.2f} s ({made.backend})"
        print("\n".join([options.output, *(f"  {name:<10} {value}" for name, value in lines.items())]))
    return 0
