"""How far a part reaches, or what is wrong with it that it reaches nowhere: no material, no end, no thickness."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from porelang.analysis.backwards import UNIVERSE
from porelang.analysis.box import Box, Extent, Points, extent_of, reach, unbounded_axes
from porelang.analysis.sampled import depth_of, seen, unending
from porelang.backends.numpy import NumpyField
from porelang.data import WORLD
from porelang.diagnostics import Diagnostic, Label, PoreError, fail
from porelang.formula import Formula
from porelang.source import Span

#: How much larger than what samples find the bounds are that are proposed.
_ROOM = 0.1


@dataclass(frozen=True, slots=True)
class Cut:
    """That a part as a whole is one solid cut by another, or one that an inward offset took a layer off: the operator,
    `\\`, `&` or `offset`, its place and that of the second, and the flat root of the first."""

    operator: str
    span: Span
    second: Span | None
    first: Formula


def part_extent(name: str, formula: Formula, span: Span, cut: Callable[[], Cut | None] = lambda: None) -> Extent:
    """The extent of an output that is called `name` and written at `span`, in mm; `cut` tells how it is made.

    Errors: E102 where it has no end or none was proven, E103 where it holds no material, E117 where it lies beyond
    100 m.
    """
    extent = extent_of(formula)
    if (extent is None or unbounded_axes(extent.outer)) and (end := reach(formula)) is not None:
        raise fail("E117", f"`{name}` lies more than 100 m from the origin, as far as {end:,.0f} mm", span, hint=WORLD)
    if extent is None:
        raise _empty(name, formula, span, cut())
    box = extent.outer
    if min(box.size) <= 0:
        if (made := cut()) is not None and made.operator == "offset":
            raise _empty(name, formula, span, made)
        flat = ", ".join(axis for axis, size in zip("xyz", box.size, strict=True) if size <= 0)
        raise fail("E103", f"`{name}` holds no material: it has no thickness along {flat}", span, hint="give it some")
    if unbounded_axes(box):
        raise PoreError(no_end(formula, box).told(name, span))
    return extent


@dataclass(frozen=True, slots=True)
class NoEnd:
    """Of a part of which no end was proven: along which axes, whether samples find it `as_far` as parts are looked for,
    and what is to be said of it."""

    axes: str
    as_far: bool
    label: str
    hint: str

    def told(self, name: str, span: Span) -> Diagnostic:
        """E102 of an output that is called `name`."""
        message = f"`{name}` has no end along {self.axes}"
        message = message if self.as_far else f"no end of `{name}` was proven along {self.axes}"
        return Diagnostic("E102", message, span, self.label, (), self.hint)


def no_end(formula: Formula, box: Box) -> NoEnd:
    """What samples tell of a part that no end was proven of, within `box`: that it has none, or where it seems to end,
    and the bounds that hold that."""
    axes = unbounded_axes(box)
    beyond = unending(formula)
    found = None if beyond else seen(formula)
    if found is not None:
        ends = zip("xyz", *found, strict=True)
        beyond = ", ".join(axis for axis, lo, hi in ends if max(-lo, hi) >= UNIVERSE)
    if beyond:
        hint = "intersect it with a shape, `... & box([50, 50, 50])`, or pass --bounds x0,y0,z0,x1,y1,z1"
        return NoEnd(max(axes, beyond, key=len), True, "solid as far as one looks (100 m)", hint)
    if found is None:
        hint = "pass --bounds x0,y0,z0,x1,y1,z1, the box that holds it, in mm"
        return NoEnd(axes, False, "samples found none of it", hint)
    far = max(max(-lo, hi) for axis, lo, hi in zip("xyz", *found, strict=True) if axis in axes)
    bounds = ",".join(f"{v:.10g}" for v in _roomy(*found, box))
    hint = f"say where it ends, as by --bounds={bounds}, which holds what samples found"
    return NoEnd(axes, False, f"samples found none of it beyond {far:.3g} mm", hint)


def _roomy(lo: Points, hi: Points, box: Box) -> list[float]:
    """Bounds with some room round a box, in round numbers; none beyond `box`."""
    room = _ROOM * float((hi - lo).max())
    step = 10.0 ** math.floor(math.log10(room))
    least, most = np.floor((lo - room) / step) * step, np.ceil((hi + room) / step) * step
    return [*np.maximum(least, box.lo).tolist(), *np.minimum(most, box.hi).tolist()]


def _empty(name: str, formula: Formula, span: Span, cut: Cut | None) -> PoreError:
    """Why a part is empty: the number that it is everywhere, the cut that leaves nothing of it, or else the least value
    of its field that samples find, and where."""
    if not formula.root.axes:
        number = float(formula.numbers[0])
        return fail(
            "E103",
            f"`{name}` holds no material: it is the number {number:.6g} everywhere",
            span,
            label="the same at every point",
            hint="a solid is a number that varies in space and is negative inside",
        )
    if cut is not None and cut.operator == "\\" and extent_of(cut.first) is not None:
        others = () if cut.second is None else (Label(cut.second, "the second"),)
        said = f"`{name}` holds no material: what is cut away is all of it"
        hint = "make the second smaller, or swap the two"
        return fail("E103", said, cut.span, label="the second solid covers the first", others=others, hint=hint)
    if cut is not None and cut.operator == "offset":
        deep = depth_of(cut.first.root, cut.first.bindings)
        if deep is not None:
            said = f"`{name}` holds no material: the offset takes away all of it"
            label = f"no point lies more than about {deep:.3g} mm below the surface of what it is taken off"
            hint = f"take away less than {deep:.3g} mm, or check the unit"
            return fail("E103", said, cut.span, label=label, hint=hint)
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
