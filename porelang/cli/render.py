"""`pore render`: a picture of a part, with cuts and field planes, as PNG."""

from __future__ import annotations

import time
from argparse import Namespace
from typing import Any

from porelang.atomic import destination
from porelang.checks import broken_checks
from porelang.cli import report
from porelang.cli.loading import bound
from porelang.diagnostics import PoreError, fail, to_lists
from porelang.picture import Picture

#: Options that say what the picture shows.
_WISHES = ("view", "projection", "size", "zoom", "cut", "slice", "field", "range", "legend", "solid", "background",
           "samples", "axes", "scale_bar", "frame", "deform", "ghost")  # fmt: skip


def _deformed(made: Picture) -> dict[str, Any]:
    """What is said of displacements, where they are drawn."""
    d = made.deformed
    return {} if d is None else {"deform": {"of": d.what, "factor": d.factor, "greatest": d.greatest}}


def render(options: Namespace) -> int:
    """Draw an output and write the picture. What can be refused is refused before anything is computed."""
    from porelang.picture import write_png
    from porelang.render.picture import bodies_of, render_output, roots_shown
    from porelang.render.wishes import wishes_of

    destination(options.output)
    if not options.output.lower().endswith(".png"):
        raise fail("E112", f"{options.output}: pictures are written as .png", hint="end the name with .png")
    named: list[str] = options.outs
    wishes = wishes_of(
        **{o: getattr(options, o) for o in _WISHES}, several=options.bodies or len(set(named)) > 1
    )  # what contradicts itself is refused before the program is read
    design = bound(options)
    destination(options.output, design.program.files)
    if broken := broken_checks(design):
        raise PoreError(broken)
    names = bodies_of(design.program) if options.bodies else named or None
    start = time.perf_counter()
    made = render_output(design, names, wishes, options.bounds)
    write_png(made, options.output, wishes.transparent)
    told = [*design.told(*roots_shown(design.program, names, wishes)), *made.told]
    report.say([] if options.quiet else told)
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
                "output": [name for name, _ in made.colours] or design.program.output(named[0] if named else None),
                "size": [width, height],
                "seconds": seconds,
                "steps": made.steps,
                "covered": made.covered,
                "pixel": made.pixel,
                "slice_range": None if made.scale is None else list(made.scale.ends),
                "colours": {name: "#{:02x}{:02x}{:02x}".format(*colour) for name, colour in made.colours},
                **_deformed(made),
                "backend": made.backend,
                **to_lists([*options.doubts, *told]),
            }
        )
    elif not options.quiet:
        lines = {"size": f"{width} x {height} pixels of {made.pixel:.3g} mm"}
        if made.scale is not None:
            lines["planes" if options.slice else "colours"] = str(made.scale)
        if made.deformed is not None:
            lines["deformed"] = f"{made.deformed}, of {made.deformed.greatest:.4g} mm at most ({made.deformed.what})"
        for name, colour in made.colours:
            lines[name] = "#{:02x}{:02x}{:02x}".format(*colour)
        lines["time"] = f"{seconds:.2f} s ({made.backend})"
        print("\n".join([options.output, *(f"  {name:<10} {value}" for name, value in lines.items())]))
    return 0
