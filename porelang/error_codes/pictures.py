"""E179: deformed parts in pictures."""

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
)
