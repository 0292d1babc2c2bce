"""E179, W285: deformed parts in pictures, and results of studies."""

from __future__ import annotations

from porelang.error_codes.page import Code

PICTURES = (
    Code(
        "E179",
        "a deformation that cannot be drawn",
        "`pore render --deform` moves every place of the part's surface by its displacement, many times as large. So\n"
        "nothing is shown where nothing moves, and no part at all where places that were apart come to lie on each\n"
        "other, or pass: where a compression, times the magnification, is more than the part has. The message names\n"
        "the magnification up to which all but a hundredth of the surface keeps its order; `--deform auto` takes less.",
        "",
        "",
    ),
    Code(
        "W285",
        "a picture of what was not studied",
        "Beyond its part a study is what it is at the nearest place of it, so that a program can read it anywhere:\n"
        "also on an output that is larger than what the study is of, or lies elsewhere. In a picture that would be\n"
        "taken for a result. So what is farther beyond the elements than a step and a half of their samples is\n"
        "grey, and does not count for the colours; the message names its share of what is drawn. With `--deform`\n"
        "it moves as the nearest place does. Where the study says what is beyond, `outside=0`, that is drawn. A\n"
        "lattice within the solid that was studied lies within it.",
        "",
        "",
    ),
)
