"""Calls for the phase of a lattice: what a text may ask of it."""

from __future__ import annotations

from collections.abc import Mapping

from porelang.diagnostics import suggest
from porelang.elaborate import arguments
from porelang.elaborate.calls import Call
from porelang.elaborate.context import Context
from porelang.elaborate.values import (
    ABSENT,
    POISON,
    ListValue,
    Poison,
    Record,
    Scalar,
    Text,
    Value,
    Vector,
    as_vector,
    describe,
)
from porelang.ir import ZERO, Node, const, node
from porelang.source import Span
from porelang.syntax import tree
from porelang.units import LENGTH, RATIO

_ORIENTATIONS, _KEPT = ("free", "fixed"), ("shape", "volume")


def _phase(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    vector = as_vector(values[0])
    period = vector if vector is not None else arguments.field(ctx, values[0], places[0], "`w` of `phase`")
    within = arguments.field(ctx, values[1], places[1], "`within` of `phase`")
    way = _frame(values[2])
    orientation = "along" if way is not None else _word(ctx, values[2], places[2], "orientation", _ORIENTATIONS)
    kept = _word(ctx, values[3], places[3], "keep", _KEPT)
    if period is None or within is None or orientation is None or kept is None:
        return POISON
    if period.dimension not in (None, LENGTH):
        return ctx.error("E062", f"`w` of `phase` is a length, not {period.dimension}", places[0])
    periods = (period.node,) if isinstance(period, Scalar) else period.nodes
    for n in periods:
        known = ctx.constant(n)
        if isinstance(known, float) and not known > 0:
            return ctx.error("E147", f"a period of {known:g} mm cannot be had", places[0],
                             hint="give a length above 0, as in 10mm")  # fmt: skip
    cells = _cells(ctx, values[4], places[4], 0 if way is None else len(way))
    if cells is None:
        return POISON
    words = (const(float(orientation == "free")), const(float(kept == "volume")), *cells)
    grid = ctx.task(node("phase", *periods, within.node, *words, *(n for v in way or () for n in v.nodes)), site.span)
    x, y, z = (arguments.looked_up(grid, k, True, None) for k in range(3))
    return Vector(x, y, z, RATIO)


def _frame(value: Value) -> tuple[Vector, ...] | None:
    """The direction of the first axis of cells, or those of the first two, of a frame; None where it is none."""
    vector = as_vector(value)
    if vector is not None:
        return (vector,)
    items = value.items if isinstance(value, ListValue) and len(value.items) == 2 else ()
    vectors = tuple(v for v in map(as_vector, items) if v is not None)
    return vectors if items and len(vectors) == len(items) else None


def _cells(ctx: Context, value: Value, place: Span, ways: int) -> tuple[Node, ...] | None:
    """How many cells a phase is to have: how that is meant (see `FITS` in `tasks.run`; 0 for none), and numbers."""
    if value is ABSENT:
        return (ZERO,) * 4
    if ways:
        those = "along a direction" if ways == 1 else "in a frame"
        ctx.error("E149", f"cells {those} have no whole number along the axes", place,
                  hint="leave out `cells`, or `orientation`")  # fmt: skip
        return None
    vector, value = as_vector(value), ctx.decided(value)
    if isinstance(value, Text) and value.value == "whole":
        return const(2.0), ZERO, ZERO, ZERO
    numbers = vector.nodes if vector is not None else (value.node,) * 3 if isinstance(value, Scalar) else ()
    known = [ctx.constant(n) for n in numbers]
    if not numbers or any(n.axes for n in numbers):
        if not isinstance(value, Poison):
            ctx.error("E149", f'`cells` of `phase` is a whole number, three, or "whole", not {describe(value)}', place,
                      hint='`cells="whole"` makes it the nearest along each side')  # fmt: skip
        return None
    if any(isinstance(n, float) and (n < 0 or n != round(n) or (n == 0 and vector is None)) for n in known):
        ctx.error("E149", f"{place.text} cannot be had", place,
                  hint="give a whole number above 0, or three; or \"whole\" for the nearest")  # fmt: skip
        return None
    return (const(1.0 if vector is not None else 3.0), *numbers)


def _word(ctx: Context, value: Value, place: Span, parameter: str, words: tuple[str, ...]) -> str | None:
    """One of a few words, the first where it is left out; None after saying that it is none of them."""
    if value is ABSENT:
        return words[0]
    value = ctx.decided(value)
    if isinstance(value, Text) and value.value in words:
        return value.value
    if isinstance(value, Poison):
        return None
    known = " or ".join(f'"{w}"' for w in words)
    known += ", a direction, or a frame, two vectors in a list" if parameter == "orientation" else ""
    near = suggest(value.value, words) if isinstance(value, Text) else None
    hint = f'did you mean "{near}"?' if near else f'write {parameter}="{words[0]}", or leave it out'
    items = value.items if isinstance(value, ListValue) else (value,)
    if parameter == "orientation" and any(isinstance(v, Record) and "direction" in v.members for v in items):
        hint = "take the direction of each: `principal(T, 1).direction` is a vector"
    elif parameter == "orientation" and len(items) == 3 and all(as_vector(v) is not None for v in items):
        hint = "leave out the third: it stands at right angles to both"
    elif parameter == "orientation" and isinstance(value, ListValue):
        hint = "a direction is a vector, `orientation=v`; a frame is two, `orientation=[v, u]`"
    ctx.error("E060", f"`{parameter}` of `phase` is {known}", place, label=f"this is {describe(value)}", hint=hint)
    return None


#: What asks for the tasks of these names.
CALLS: Mapping[str, Call] = {"phase": _phase}
