"""E147-E149, W228, W229, W234: lattices whose cells change their size, and the phases that drive them."""

from __future__ import annotations

from porelang.error_codes.page import Code

PHASES = (
    Code(
        "E147",
        "a period that is none",
        "`phase(w, within)` is the phase of a lattice whose cells have the size w: a length above 0 everywhere within\n"
        "the part. The message says what it is, and where. Beyond the part it may be anything.",
        "gyroid(phase=phase(0mm, sphere(30))) & sphere(30)",
        "gyroid(phase=phase(10mm + z / 20, sphere(30))) & sphere(30)",
    ),
    Code(
        "E148",
        "cells that would fold",
        "Where the size of cells changes by too much within a few of them, no phase without folds is near to what is\n"
        "asked for: beyond a fold the lattice would come back mirrored. The message says where. Let the size change\n"
        "over a longer way, or by less.",
        "",
        "gyroid(phase=phase(10mm + z / 20, sphere(30))) & sphere(30)",
    ),
    Code(
        "W229",
        "cells that are not as they were asked for",
        "Cells of one shape whose size varies exist for few fields: `phase` gets as near as can be, and says so.\n"
        "Here one cell in twenty misses its size by 10 % or more, is 1.15 times as long as it should be against its\n"
        "width, or lies 10 degrees off the direction that was given. A size that grows with the distance from a long\n"
        "axis cannot be had, whatever one does. Give it less range or a longer way, let cells turn (`orientation`\n"
        'left out), or give up some of their shape for their size: `keep="volume"`.',
        "",
        "gyroid(phase=phase(10mm + z / 20, sphere(30))) & sphere(30)",
    ),
)
