"""A period of a design, homogenised at several resolutions and extrapolated."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import Box
from porelang.diagnostics import fail
from porelang.formula import Formula
from porelang.homogenize.cell import corner_of, period_doubts, place, sampled, sides_of
from porelang.homogenize.doubts import doubts_of
from porelang.homogenize.found import Homogenized
from porelang.homogenize.kept import level
from porelang.program import Design
from porelang.progress import activity
from porelang.solid import Solid
from porelang.unitcell.effective import checked_ratio
from porelang.unitcell.extrapolate import ALIGNED, CREASED, SMOOTH, STRAYS, definite_limit
from porelang.unitcell.grids import ALIKE, grids, sizes_of
from porelang.unitcell.pieces import pieces_of
from porelang.walls import thinnest

Floats = NDArray[np.float64]
#: Voxels along the longest side of the finest grid: what is usual, the fewest and the most.
RESOLUTION, FEWEST, MOST = 64, 8, 256
#: Of walls of fewer samples the density errs by this share over their square, as of round struts of 2 to 10 samples.
THIN, ROUND = 6.0, 0.45
#: The share of the surface that has an edge leading into the solid, above which the solid is no smooth one: one strut
#: that meets another has 5 times as much.
EDGES = 1e-3
#: The share of the surface that lies with the voxels above which these cut whole walls alike.
FLAT = 0.2


def homogenize(
    design: Design,
    name: str | None = None,
    cell: Any = None,
    nu: float = 0.3,
    resolution: int = RESOLUTION,
    threads: int | None = None,
) -> Homogenized:
    """A period of an output of a design as a material; `cell` are its sides in mm, else those of its lattices.

    The period is centred at the origin, or where the part is as large as that and ends, at its middle. It is solved at
    `resolution` voxels along its longest side (rounded up to eights), and at 3/4, 1/2 and 3/8 of them. Errors: those of
    the output; E180 where the cell is not known, E181 where it is no period, E182 where it is empty or an envelope cuts
    it, E183 for a Poisson's ratio that no solid has.
    """
    name = design.program.output(name)
    sides = sides_of(design, name, cell)
    return material(design.of(name), name, sides, nu, resolution, threads)


def material(
    part: Formula, name: str, sides: Floats, nu: float = 0.3, resolution: int = RESOLUTION, threads: int | None = None,
    middle: Sequence[float] = (0.0, 0.0, 0.0), reach: Box | None = None,
) -> Homogenized:  # fmt: skip
    """A period of a part as a material; `sides` (3,) are its lengths in mm, and it lies round `middle` unless the part
    is as large as that. `reach` is the box in which the part has to repeat, where that is not all of it. See
    `homogenize`, also for errors."""
    begun = time.perf_counter()
    nu = checked_ratio(nu)
    whole = isinstance(resolution, int | np.integer) and not isinstance(resolution, bool)
    if not whole or not FEWEST <= resolution <= MOST:
        raise fail("E180", f"a finest grid of {resolution!r:.40} voxels is not to be had",
                   hint=f"take from {FEWEST} to {MOST} along the longest side, as by --resolution 64")  # fmt: skip
    low = corner_of(part, sides, middle)
    doubts = period_doubts(part, low, sides, reach)
    # a little beyond the cell, or a wall that its face halves would count as half as thick
    wall = thinnest(Solid(part, (tuple(low - sides / 4), tuple(low + 5 * sides / 4))))
    x, y, z = (bool(part.root.axes & 1 << axis) for axis in range(3))
    grid = grids(sides, (x, y, z), int(resolution), wall)
    with activity("sampling the cell"):
        seen = sampled(part, low, sides, grid)
    densities, density_error, creased = seen.densities, seen.error, seen.creased > EDGES
    if not densities[-1].any():
        many = " x ".join(map(str, grid.samples))
        raise fail("E182", f"no sample of {many} in the cell from {place(low)} to {place(low + sides)} is solid",
                   hint="solid is negative, and the cell lies round the origin; or walls are thinner than the samples "
                   "are apart: take a higher --resolution")  # fmt: skip
    through = (
        np.inf if wall is None else wall / max(c / n for c, n in zip(sides, grid.samples, strict=True) if n > ALIKE)
    )
    if through < THIN:  # every third sample misses it, and tells nothing
        density_error = max(density_error, ROUND / through**2 * float(densities[-1].mean()))
    levels = []
    for density in densities:
        with activity(f"homogenizing {' x '.join(map(str, density.shape))} voxels"):
            levels.append(level(density, sides, nu, threads))
    orders, strays = CREASED if creased else SMOOTH, ALIGNED if seen.flat > FLAT else STRAYS
    stiff = definite_limit(sizes_of(), np.array([at.stiffness.matrix for at in levels]), orders, strays)
    heat = definite_limit(sizes_of(), np.array([at.conductivity.matrix for at in levels]), orders, strays)
    found = Homogenized(
        name=name, cell=_three(sides), low=_three(low), nu=nu, resolution=int(resolution),
        levels=tuple(levels), wall=wall, orders=orders, strays=strays,
        density=float(densities[-1].mean()), density_error=density_error,
        stiffness=_tidy(stiff.value), stiffness_error=stiff.error,
        conductivity=_tidy(heat.value), conductivity_error=heat.error,
        pieces=tuple(pieces_of(densities[-1], corners=True)), doubts=(), seconds=0.0,
    )  # fmt: skip
    found = found.widened()
    doubts += doubts_of(found, pieces_of(seen.solid), grid.samples, MOST)
    return replace(found, doubts=tuple(doubts), seconds=round(time.perf_counter() - begun, 3))


def _three(values: Floats) -> tuple[float, float, float]:
    x, y, z = map(float, values)
    return x, y, z


def _tidy(matrix: Floats) -> Floats:
    """A matrix without what is rounding beside its largest entry."""
    return np.where(np.abs(matrix) <= 1e-9 * np.abs(matrix).max(), 0.0, matrix)
