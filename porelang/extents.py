"""How far a part reaches, or what is wrong with it that it reaches nowhere: no material, no end, no thickness."""

from __future__ import annotations

import numpy as np

from porelang.analysis.box import Extent, extent_of, reach, unbounded_axes
from porelang.backends.numpy import NumpyField
from porelang.data import WORLD
from porelang.diagnostics import PoreError, fail
from porelang.formula import Formula
from porelang.source import Span


def part_extent(name: str, formula: Formula, span: Span) -> Extent:
    """The extent of an output that is called `name` and written at `span`, in mm.

    Errors: E102 where it has no end, E103 where it holds no material, E117 where it lies beyond 100 m.
    """
    extent = extent_of(formula)
    if (extent is None or unbounded_axes(extent.outer)) and (end := reach(formula)) is not None:
        raise fail("E117", f"`{name}` lies more than 100 m from the origin, as far as {end:,.0f} mm", span, hint=WORLD)
    if extent is None:
        raise _empty(name, formula, span)
    box = extent.outer
    if min(box.size) <= 0:
        flat = ", ".join(axis for axis, size in zip("xyz", box.size, strict=True) if size <= 0)
        raise fail("E103", f"`{name}` holds no material: it has no thickness along {flat}", span, hint="give it some")
    if axes := unbounded_axes(box):
        raise fail(
            "E102",
            f"`{name}` has no end along {axes}",
            span,
            label="solid as far as one looks (100 m)",
            hint="intersect it with a shape, `... & box([50, 50, 50])`, or pass --bounds x0,y0,z0,x1,y1,z1",
        )
    return extent


def _empty(name: str, formula: Formula, span: Span) -> PoreError:
    """Why a part is empty: the least value of its field that samples find, and where; the number, where it is one."""
    if not formula.root.axes:
        number = float(formula.numbers[0])
        return fail(
            "E103",
            f"`{name}` holds no material: it is the number {number:.6g} everywhere",
            span,
            label="the same at every point",
            hint="a solid is a number that varies in space and is negative inside",
        )
    spread = np.random.default_rng(1)
    points = np.concatenate([spread.uniform(-r, r, (4000, 3)) for r in (10, 100, 1000)])
    found = NumpyField(formula).at(points)
    if np.isnan(found).all():
        return fail(
            "E103",
            f"`{name}` holds no material: its field is not a number",
            span,
            label="not a number anywhere",
            hint="look for the square root or the logarithm of something negative",
        )
    at = int(np.nanargmin(found))
    place = ", ".join(f"{v:.4g}" for v in points[at])
    return fail(
        "E103",
        f"`{name}` holds no material: its field is nowhere below 0 within 100 m",
        span,
        label=f"the least that samples found is {found[at]:.4g}, at ({place})",
        hint="solid is negative: check the sign or the offset, and that shapes which are intersected meet",
    )
