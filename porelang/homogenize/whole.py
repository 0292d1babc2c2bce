"""A period of a design, homogenised at several resolutions and extrapolated."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from porelang.diagnostics import Diagnostic, fail
from porelang.formula import Formula
from porelang.homogenize.cell import cell_of, corner_of, period_doubts, place, sampled
from porelang.homogenize.found import Homogenized, Level, sizes_of
from porelang.program import Design
from porelang.progress import activity
from porelang.unitcell.effective import checked_ratio, conducted, homogenized
from porelang.unitcell.extrapolate import limit
from porelang.unitcell.fractions import fractions
from porelang.unitcell.period import voxels_of
from porelang.unitcell.pieces import Piece, pieces_of

Floats = NDArray[np.float64]
#: Voxels along the longest side of the finest grid, and of the others in units of that.
FINEST, SHARES = 64, (3 / 8, 1 / 2, 3 / 4, 1)
#: Samples along a side of a voxel; fewest and most voxels of the finest grid along a side.
FINE, FEWEST, MOST = 2, 8, 256
#: A relative error above which is said that the voxels are too coarse.
COARSE = 0.05


def homogenize(
    design: Design,
    name: str | None = None,
    cell: Sequence[float] | None = None,
    nu: float = 0.3,
    finest: int = FINEST,
    threads: int | None = None,
) -> Homogenized:
    """A period of an output of a design as a material; `cell` are its sides in mm, else those of its lattices.

    The period is centred at the origin, or where the part is as large as that and ends, at its middle. It is solved at
    `finest` voxels along its longest side, and at 3/4, 1/2 and 3/8 of them. Errors: those of the output; E180 where the
    cell is not known, E181 where it is no period, E182 where it is empty or an envelope cuts it, E183 for a Poisson's
    ratio that no solid has.
    """
    name = design.program.output(name)
    part = design.of(name)
    return material(part, name, cell_of(design, name, part, cell), nu, finest, threads)


def material(
    part: Formula, name: str, sides: Floats, nu: float = 0.3, finest: int = FINEST, threads: int | None = None,
    middle: Sequence[float] = (0.0, 0.0, 0.0),
) -> Homogenized:  # fmt: skip
    """A period of a part as a material; `sides` (3,) are its lengths in mm, and it lies round `middle` unless the part
    is as large as that. See `homogenize`, also for errors."""
    begun = time.perf_counter()
    checked_ratio(nu)
    if not isinstance(finest, int | np.integer) or isinstance(finest, bool) or not FEWEST <= finest <= MOST:
        raise fail("E180", f"a finest grid of {finest!r:.40} voxels is not to be had",
                   hint=f"take from {FEWEST} to {MOST} along the longest side, as by --resolution 64")  # fmt: skip
    low = corner_of(part, sides, middle)
    doubts = period_doubts(part, low, sides)
    levels: list[Level] = []
    pieces: list[Piece] = []
    for n in dict.fromkeys(max(4, round(share * finest)) for share in SHARES):
        voxels = voxels_of(sides, n)
        values = sampled(part, low, sides, voxels, FINE)
        density = fractions(values, FINE)
        if not density.any():
            raise fail("E182", f"the cell from {place(low)} to {place(low + sides)} holds no material",
                       hint="solid is negative; the cell is looked at round the origin")  # fmt: skip
        with activity(f"homogenizing {' x '.join(map(str, voxels))} voxels"):
            levels.append(Level(voxels, homogenized(density, sides, nu, threads=threads), conducted(density, sides)))
        pieces = pieces_of(values < 0) if n == finest else pieces
    sizes = sizes_of(levels)
    stiff = limit(sizes, np.array([at.stiffness.matrix for at in levels]))
    heat = limit(sizes, np.array([at.conductivity.matrix for at in levels]))
    share = limit(sizes, np.array([at.stiffness.density for at in levels]))
    found = Homogenized(
        name, tuple(map(float, sides)), tuple(map(float, low)), nu, tuple(levels),  # type: ignore[arg-type]  # three each
        float(np.clip(share.value, 0, 1)), float(share.error), _tidy(stiff.value), stiff.error, _tidy(heat.value),
        heat.error, stiff.order, tuple(pieces), FINE, (), 0.0,
    )  # fmt: skip
    doubts += _doubts(found)
    return replace(found, doubts=tuple(doubts), seconds=round(time.perf_counter() - begun, 3))


def _tidy(matrix: Floats) -> Floats:
    """A matrix without what is rounding beside its largest entry."""
    return np.where(np.abs(matrix) < 1e-10 * np.abs(matrix).max(), 0.0, matrix)


def _doubts(found: Homogenized) -> list[Diagnostic]:
    """Warnings about what was found."""
    out = []
    islands = [p for p in found.pieces if not any(p.leads)]
    if islands:
        share = sum(p.share for p in islands)
        many = "a piece" if len(islands) == 1 else f"{len(islands)} pieces"
        hangs = "hangs" if len(islands) == 1 else "hang"
        out.append(Diagnostic(
            "W261", f"{many} of the solid, {share:.2g} of it, {hangs} by nothing: the largest at "
            f"{place(found.place(islands[0].at))}", severity="warning",
            hint="they carry nothing and count as density; take them off, or join them to the rest"))  # fmt: skip
    closed = [axis for i, axis in enumerate("xyz") if not any(p.leads[i] for p in found.pieces)]
    if closed:
        along = " and ".join(closed)
        out.append(Diagnostic(
            "W262", f"no solid leads from one cell to the next along {along}: there is no stiffness that way",
            severity="warning",
            hint="a thicker wall may join them; or the cell is not the period that is meant"))  # fmt: skip
    worst = max(("100", "010", "001"), key=lambda k: found.errors[f"E.{k}"] / max(found.numbers[f"E.{k}"], 1e-300)
                if found.numbers[f"E.{k}"] else 0.0)  # fmt: skip
    e, error = found.numbers[f"E.{worst}"], found.errors[f"E.{worst}"]
    if e and error > COARSE * e:
        finest = max(found.levels[-1].voxels)
        out.append(Diagnostic(
            "W263", f"{finest} voxels along the cell are too coarse: E along {worst} is {e:.3g} +- {error:.2g}",
            severity="warning",
            hint=f"use --resolution {min(MOST, 2 * finest)}: a wall wants three voxels"))  # fmt: skip
    return out
