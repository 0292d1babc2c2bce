"""The bars of `truss`: those of a cell in mm, with the period in which they repeat."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.data import FARTHEST, LONGEST_CELL, NEAREST, Segments, Triple
from porelang.diagnostics import fail
from porelang.ops.joints import REACH, WIDER, WIDEST

#: A cell has bars in parts of this.
UNIT: Triple = (1.0, 1.0, 1.0)


def cell_of(ends: NDArray[np.float64]) -> Segments:
    """A cell of bars between ends (n, 2, 3), in its parts, whose radii are all the same."""
    return _frozen(ends[:, 0].copy(), ends[:, 1].copy(), np.ones(len(ends)), UNIT)


def laid_out(cell: Segments, period: Triple, r: float, k: float) -> Segments:
    """The bars of a cell of a period in mm, whose radii are r times their factors; with r = 0, where who reads them
    takes off a radius that varies, they are 0. With a k above 0 they are joined, as far apart as that (`ops.joints`).
    Errors: E138, E147."""
    for w in period:
        if not (NEAREST < w < FARTHEST):
            raise fail("E147", f"a cell of {w:g} mm cannot be had", hint="give a length above 0, as in 10mm")
    if max(period) > LONGEST_CELL * min(period):
        shown = " x ".join(f"{w:g}" for w in period)
        raise fail(
            "E138",
            f"a cell of {shown} mm is over {LONGEST_CELL:g} times as long as it is wide",
            hint="scale the struts instead, as in `truss(...) @ [x, y, z / 200]`",
        )
    if r == 0 and (cell.radii != 1).any():
        raise fail(
            "E138",
            "a cell whose bars have radii of their own needs one radius, and one size",
            hint="give `r` and `w` as numbers, or leave `radii` out of the file",
        )
    if k > WIDEST * min(period) * (1 + 1e-9):
        most = WIDEST / WIDER * min(period)
        raise fail("E138", f"a fillet of {k / WIDER:.3g} mm is too wide for cells of {min(period):g} mm",
                   hint=f"they take one of {most:.3g} mm")  # fmt: skip
    sides, reach = np.array(period), REACH * min(period) if k > 0 else 0.0
    return _frozen(cell.starts * sides, cell.ends * sides, cell.radii * r, period, reach)


def _frozen(
    starts: NDArray[Any], ends: NDArray[Any], radii: NDArray[Any], period: Triple, reach: float = 0.0
) -> Segments:
    for array in (starts, ends, radii):
        array.setflags(write=False)
    return Segments(starts, ends, radii, period, reach)
