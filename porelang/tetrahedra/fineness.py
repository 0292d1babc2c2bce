"""How large tetrahedra are to be: as asked, or so that some fit across the thinnest walls."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from porelang.diagnostics import PoreError, fail
from porelang.formula import Formula
from porelang.program import Design
from porelang.solid import Solid
from porelang.tet.sizes import ACROSS
from porelang.walls import Thinnest, rounded, walls_of

AUTO = "auto"
#: Tetrahedra that each mesher makes without being asked for so many: some ten seconds, some minutes.
AFFORDABLE = {"direct": 1e6, "ftetwild": 2e4}
#: Of the longest side, where walls do not ask for less.
USUAL = 1 / 20
#: Tetrahedra in a cube of their size, of the body-centred lattice (F. Labelle, J. Shewchuk, Isosurface Stuffing, 2007).
IN_A_CUBE = 12


@dataclass(frozen=True, slots=True)
class Fineness:
    """How large tetrahedra are to be (mm, or a field that says it), what three across the thinnest wall would take (mm;
    None where no walls are found), a thinnest wall, and whether the size was found by itself: from the walls, or from
    what is `cut` (mm thick; 0: not) thinner than they are, where a shape meets a lattice at a small angle."""

    size: float | Formula
    wanted: float | None
    wall: Thinnest | None
    by_itself: bool
    cut: float = 0.0

    def told(self) -> str:
        """The size in words, and where it was not given how it was found."""
        if not isinstance(self.size, float):
            return "a field"
        text = f"{self.size:.4g} mm"
        if not self.by_itself:
            return text
        if self.cut and self.size <= self.cut:
            return (
                f"{text} (by itself: where a shape cuts it at a small angle the part is about {self.cut:.2g} mm thick)"
            )
        if self.wall is None or self.wanted is None:
            return f"{text} (by itself: 1/{1 / USUAL:.0f} of the longest side; no walls were found to measure)"
        thin = f"the thinnest walls are about {self.wall.wall:.2g} mm"
        if self.size < self.wanted * (1 - 1e-9):
            return f"{text} (by itself: 1/{1 / USUAL:.0f} of the longest side; {thin})"
        if self.size <= self.wanted * (1 + 1e-9):
            return f"{text} (by itself: {thin})"
        return f"{text} (by itself, and coarse: {thin}; three across them take --size {rounded(self.wanted)}mm)"


def fineness(design: Design, part: Solid, size: float | str | None, mesher: str, whole: bool = False) -> Fineness:
    """The size as it was asked for (mm, or the name of what says it), or else from the walls of a part in its box, of
    which it fills the `whole`, or the solid.

    Errors: E100 for a name of nothing, E108 for a field where fTetWild takes one number.
    """
    narrow, wall = walls_of(part)
    wanted = None if wall is None else wall.wall / ACROSS
    if isinstance(size, str) and size != AUTO:
        if mesher != "direct":
            raise fail("E108", "fTetWild takes one size", hint="give a length, or use --mesher direct")
        try:
            roots = design.program.field_roots(size)
        except PoreError as unknown:
            said = f"`{size}` is no length, as `3mm`, and "
            raise PoreError([replace(d, message=said + d.message) if d.code == "E100" else d
                             for d in unknown.diagnostics]) from None  # fmt: skip
        return Fineness(design.formula(*roots), wanted, wall, False)
    if isinstance(size, int | float):
        return Fineness(float(size), wanted, wall, False)
    usual = float((part.hi - part.lo).max()) * USUAL
    volume, error = part.guess
    filled = float(np.prod(part.hi - part.lo)) if whole else volume + error
    finest = (filled * IN_A_CUBE / AFFORDABLE[mesher]) ** (1 / 3)
    least = usual if narrow is None else min(usual, narrow.wall / ACROSS)
    cut = 0.0 if narrow is None or least >= min(usual, wanted or usual) * (1 - 1e-9) else narrow.wall
    return Fineness(max(finest, least), wanted, wall, True, cut)
