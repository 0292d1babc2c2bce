"""E147-E149, W228, W229, W237: lattices whose cells change their size, and the phases that drive them."""

from __future__ import annotations

from porelang.error_codes.page import Code

PHASES = (
    Code(
        "E147",
        "a period that is none",
        "`phase(w, within)` is the phase of a lattice whose cells have the size w: a length above 0 everywhere within\n"
        "the part. The message says what it is, and where; all samples of a file are looked at, and formulas at\n"
        "places a hundredth of the longest side apart, along one axis or two much finer. Beyond the part it may be\n"
        "anything.",
        "gyroid(phase=phase(0mm, sphere(30))) & sphere(30)",
        "gyroid(phase=phase(10mm + z / 20, sphere(30))) & sphere(30)",
    ),
    Code(
        "E148",
        "cells that would fold",
        "Where the size of cells changes by too much within a few of them, no phase without folds is near to what is\n"
        "asked for: beyond a fold the lattice would come back mirrored. The message says where. Let the size change\n"
        "over a longer way, or by less. Cells that stand along directions fold where these turn too quickly, or turn\n"
        "by half a turn or a whole one round a line or a hole, as no phase does without a seam: the hint says it.",
        "",
        "gyroid(phase=phase(10mm + z / 20, sphere(30))) & sphere(30)",
    ),
    Code(
        "E149",
        "a number of cells that is none",
        "`cells` of `phase` fits cells into the box of the solid: a whole number of them along its longest side,\n"
        'three for its sides (0 leaves one as it comes), or "whole", the nearest along each. Cells that stand along a\n'
        "direction have no number along the axes.",
        "gyroid(phase=phase(10mm, sphere(30), cells=2.5)) & sphere(30)",
        "gyroid(phase=phase(10mm + z / 20, sphere(30), cells=6)) & sphere(30)",
    ),
    Code(
        "W228",
        "a period that varies, and cells that do not have it",
        "With a field as `w` a lattice is a wave of p / w, as in the paper, and that is no wave of the length w: the\n"
        "farther from the origin a change of w is, the longer or shorter are cells there, until they shear. The\n"
        "message says what they are at a place of the part where they miss `w` by more than 25 %.\n"
        "`phase(w, within)` finds the phase of a lattice whose cells do have the size w, as nearly as can be, and\n"
        "says how nearly. Where the wave of the paper is what is meant, `phase=p / w` says that it is.",
        "gyroid(20mm + z / 10) & cylinder(75mm, 300mm)",
        "gyroid(phase=phase(20mm + z / 20, cylinder(75mm, 300mm))) & cylinder(75mm, 300mm)",
    ),
    Code(
        "W229",
        "cells that are not as they were asked for",
        "Cells of one shape whose size varies exist for few fields: `phase` gets as near as can be, and says so.\n"
        "Here one cell in twenty misses its size by 10 % or more, is 1.15 times as long as it should be against\n"
        "its width, or lies 10 degrees off the direction that was given, its layers or its edges; or there is no\n"
        "direction in a hundredth;\n"
        "or the smallest or largest cells that are asked for are missed by a fifth, as a size that is asked for\n"
        "over no more than a few cells is; or some are smaller or larger by a fifth than any that is asked for;\n"
        "or one misses its size by half or is 1.5 times as long as\n"
        "it should be, as in a narrow place. A size that grows with the distance from a long axis cannot be had,\n"
        "whatever one does. Give it less range or a longer way, let cells turn (`orientation` "
        'left out), or give up some of their shape for their size: `keep="volume"`.',
        "",
        "gyroid(phase=phase(10mm + z / 20, sphere(30))) & sphere(30)",
    ),
    Code(
        "W237",
        "a part that reaches beyond its phase",
        "`phase(w, within)` is known in the box of the solid `within`, and a sixteenth of its longest side beyond.\n"
        "Farther out it is what it is at the end of that box: along that way nothing changes, and cells are drawn out\n"
        "into bars. Give `phase` the solid that the lattice fills, as it lies where the lattice is made.\n"
        "It shows when the phase has been found: `pore check` finds it with `--measure`, as `mesh` and others do.",
        "",
        "let part = cube(60)\ngyroid(phase=phase(8mm + z / 20, part)) & part",
    ),
)
