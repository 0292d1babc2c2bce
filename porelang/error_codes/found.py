"""E090-E099: numbers that are found from whole fields, such as a porosity."""

from __future__ import annotations

from porelang.error_codes.page import Code

FOUND = (
    Code(
        "E090",
        "a porosity that cannot be",
        "A porosity is the fraction of void: it lies between 0 and 1, and is written 0.5 or 50%.",
        "",
        "let d = to_porosity(gyroid(20), 50%, sphere(30))\noffset(gyroid(20), d) & sphere(30)",
    ),
    Code(
        "E091",
        "a number over a region without an end",
        "A volume, an area, a mean or a porosity is that of a part with an end. Intersect the field with a shape,\n"
        "or hand over a bounded solid as `within`.",
        "",
        'check volume(gyroid(20) & sphere(30)) > 1, "empty"\ngyroid(20) & sphere(30)',
    ),
    Code(
        "E092",
        "a number over a region without material",
        "The region over which a number is to be found holds no point that is solid, or is far thinner than it is\n"
        "wide. Solid is negative: check its sign.",
        "",
        'check volume(sphere(30)) > 1, "empty"\nsphere(30)',
    ),
    Code(
        "E093",
        "a number of a field that is not a number",
        "Within the region the field is undefined in places: a division of zero by zero, a root or logarithm of a\n"
        "negative number.",
        "",
        'check mean(sqrt(abs(x)), sphere(30)) > 1, "too small"\nsphere(30)',
    ),
    Code(
        "E094",
        "a number that cannot be reached",
        "What `solve` or `to_porosity` looks for lies outside what the range allows; the message says between which\n"
        "values it can be.",
        "",
        "let d = to_porosity(gyroid(20), 50%, sphere(30))\noffset(gyroid(20), d) & sphere(30)",
    ),
    Code(
        "E095",
        "a range in which nothing can be found",
        "`solve` looks from the lower end of a range to the upper one: the lower comes first.",
        "",
        "sphere(30)",
    ),
    Code(
        "E096",
        "samples that cannot be taken",
        "`sample(f, voxel, within)` takes a value every `voxel` over the box of `within`: a length above 0, and one\n"
        "with which a few hundred million samples are enough. The message says which voxel would do. A `phase`\n"
        "takes two samples a cell.",
        "",
        "sample(gyroid(20), 1mm, sphere(30)) & sphere(30)",
    ),
    Code(
        "E097",
        "samples of a field that is not a number",
        "Somewhere in the box of the region, and a little around it, the field is infinite or undefined: samples\n"
        "there would spoil all that is read near them. The message says where.",
        "",
        "sample(sqrt(abs(x)), 1mm, sphere(30)) & sphere(30)",
    ),
    Code(
        "E098",
        "one of several answers",
        "`solve` gives the one number for which a function takes a value. Here there are several in the range: a\n"
        "polynomial with three roots, a function that turns, one that is level where it takes the value. Which one is\n"
        "meant is not for `solve` to choose: narrow the range until it holds one alone.",
        "",
        "let r = solve(t => (t - 1) * (t - 2) * (t - 3), 0, 0.5..1.5)\nsphere(10 * r)",
    ),
    Code(
        "E099",
        "a value that a function jumps over",
        "The function is below the target on one side of a place and above it on the other, and never takes it: at a\n"
        "step of `floor`, where an `if` changes its mind, or at a pole. The message says where.",
        "",
        "let r = solve(t => 3 * t, 1.5, 0..4)\nsphere(10 * r)",
    ),
    Code(
        "E139",
        "a solid without walls",
        "`min_wall` measures between parallel sides. A cone or a pyramid has none: its thickness goes down to nothing\n"
        "at its edges and its tip, which are no walls.",
        "",
        "let w = min_wall(cone(10, 0, 20))\nsphere(w)",
    ),
)
