"""Calls that ask for a task: their arguments checked, a node made; computing it comes later, if a root reads it.

What a task gives is a number, or data. Data are no values of the language: samples become the field that looks them up
(`samples`, `phases`, `solids`), a frame the distance from its bars.
"""

from __future__ import annotations

from dataclasses import replace

from porelang.elaborate import arguments, bare, phases, samples, solids, studies, trusses
from porelang.elaborate.advice import is_number
from porelang.elaborate.calls import Call, call
from porelang.elaborate.context import Context
from porelang.elaborate.values import (
    POISON,
    Builtin,
    Given,
    Poison,
    Range,
    Record,
    Scalar,
    Value,
    Vector,
    describe,
)
from porelang.ir import ONE, ZERO, Node, Stage, X, Y, Z, node, order, unknown
from porelang.ops import TASK_TABLE
from porelang.ops.tasks import SAME, Task
from porelang.source import Span
from porelang.syntax import tree
from porelang.units import LENGTH, RATIO, Dimension

_HERE = (X, Y, Z)
#: What a porosity that is asked for has to be.
A_SHARE = "needs a porosity between 0 and 1"


def _number(row: Task) -> Call:
    """The call of a task that finds a number from fields."""

    def ask(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
        fields: list[Scalar] = []
        for value, parameter, place in zip(values, row.parameters, places, strict=True):
            found = arguments.field(ctx, value, place, f"`{parameter}` of `{row.name}`")
            if found is None:
                return POISON
            if parameter == "phi":
                if found.node.stage is Stage.FIELD:
                    return ctx.error(
                        "E063", f"`phi` of `{row.name}` must be one number", place, label="this varies in space"
                    )
                known = ctx.constant(found.node)
                if isinstance(known, float) and not 0 < known < 1:
                    percent = f"{place.text}%" if 1 < known < 100 and is_number(place.text) else ""
                    return ctx.error(
                        "E064",
                        f"`{row.name}` {A_SHARE}",
                        place,
                        label=f"this is {known:g}",
                        hint=f"write `{percent}`" if percent else "write 50% or 0.5",
                        edit=(place, percent) if percent else None,
                    )
                if found.node.stage is Stage.UNIFORM:
                    between = node("and", node("lt", ZERO, found.node), node("lt", found.node, ONE))
                    ctx.require(between, f"`{row.name}` {A_SHARE}", place, ())
            fields.append(found)
        asked = ctx.task(node(row.name, *(f.node for f in fields)), site.span)
        return Scalar(asked, _dimension(row, fields[0].dimension))

    return ask


def _dimension(row: Task, field: Dimension | None) -> Dimension | None:
    return field if row.dimension == SAME else row.dimension  # type: ignore[return-value]  # SAME is the only text


def _solve(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    function, target, ends = values
    if not isinstance(ends, Range):
        return ctx.error(
            "E060",
            f"`solve` looks in a range, not in {describe(ends)}",
            places[2],
            label=f"this is {describe(ends)}",
            hint="write it as `lo..hi`: `solve(t => ..., 0.5, 0.1..3)`",
        )
    if not isinstance(target, Scalar):
        return ctx.error("E060", f"the target of `solve` is a number, not {describe(target)}", places[1])
    dimension = ends.low.dimension or ends.high.dimension
    with ctx.requiring() as own, ctx.solving() as level:
        sought = Scalar(unknown(level), dimension)
        value = call(ctx, function, [Given(None, sought, places[0])], site)
    if isinstance(value, Poison):
        return POISON
    if not isinstance(value, Scalar):
        return ctx.error("E060", f"`solve` needs a function that gives a number, not {describe(value)}", places[0])
    for what, n, place in (
        ("the function of `solve`", value.node, places[0]),
        ("the target of `solve`", target.node, places[1]),
        ("an end of the range", ends.low.node, places[2]),
        ("an end of the range", ends.high.node, places[2]),
    ):
        if n.stage is Stage.FIELD:
            return ctx.error(
                "E063",
                f"{what} must be one number",
                place,
                label="this varies in space",
                hint="reduce it first: `porosity(f, within)`, `mean(f, within)`, ...",
            )
    bare.share_and_percent(ctx, (value, target), places[:2])
    if None not in (value.dimension, target.dimension) and value.dimension != target.dimension:
        return ctx.error("E062", f"the function gives {value.dimension}, the target is {target.dimension}", places[1])
    asked = node("solve", value.node, target.node, ends.low.node, ends.high.node, value=level)
    for r in own:
        if r.condition.depends & sought.node.depends:
            found = _with(r.condition, sought.node, asked)
            ctx.required[replace(r, condition=found, solve=asked)] = None
        else:
            ctx.required[r] = None
    return Scalar(ctx.task(asked, site.span), dimension)


def _with(condition: Node, sought: Node, found: Node) -> Node:
    """A condition on what a `solve` looks for as one on what it finds: its guesses may break it.

    A `solve` that stands inside on its own looks for something else by the same number.
    """
    new: dict[Node, Node] = {sought: found}
    for n in order([condition], lambda n: n.args if n.depends & sought.depends and n is not sought else ()):
        if n not in new:
            reads = n.depends & sought.depends
            new[n] = node(n.op, *(new[a] for a in n.args), value=n.value) if reads else n
    return new[condition]


def _bars(ctx: Context, site: tree.Call, path_given: Value, place: Span) -> Node | None:
    path = arguments.text(ctx, path_given, place, "the path of a frame's file", "truss.json")
    return None if path is None else ctx.task(node("frame", value=arguments.beside(site, path, ctx)), site.span)


def _nearest(bars: Node, result: str) -> Node:
    return node("nearest", bars, *_HERE, value=result)


def _frame(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    bars = _bars(ctx, site, values[0], places[0])
    k = trusses.joint(ctx, values[1], places[1], "frame")
    return POISON if bars is None or k is None else Scalar(trusses.surface(bars, _HERE, k))


def _nearest_bar(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    bars = _bars(ctx, site, values[0], places[0])
    if bars is None:
        return POISON
    return Record(
        "nearest_bar",
        {
            "distance": Scalar(_nearest(bars, "distance"), LENGTH),
            "direction": Vector(_nearest(bars, "dx"), _nearest(bars, "dy"), _nearest(bars, "dz"), RATIO),
            "outward": Vector(_nearest(bars, "nx"), _nearest(bars, "ny"), _nearest(bars, "nz"), RATIO),
            "along": Scalar(_nearest(bars, "along"), RATIO),
            "radius": Scalar(_nearest(bars, "radius"), LENGTH),
            "length": Scalar(_nearest(bars, "length"), LENGTH),
            "index": Scalar(_nearest(bars, "index")),
        },
    )


_CALLS: dict[str, Call] = {"solve": _solve, "frame": _frame, **samples.CALLS, **solids.CALLS, **phases.CALLS,
                           **studies.CALLS, **trusses.CALLS}  # fmt: skip


def _builtin(row: Task) -> Builtin:
    most = len(row.parameters)
    ask = _CALLS.get(row.name) or _number(row)
    return Builtin(row.name, row.parameters, ask, most - row.optional, most, row.doc, row.optional > 0)


BUILTINS = (
    *(_builtin(row) for row in TASK_TABLE.values() if row.parameters),
    *samples.BUILTINS,
    *studies.BUILTINS,
    Builtin(
        "nearest_bar",
        ("path",),
        _nearest_bar,
        1,
        1,
        "What is nearest among the bars of a file, as fields: `.distance` to its surface, `.direction` of the bar, "
        "`.outward` from its axis to the point, `.along` it from 0 to 1, its `.radius`, `.length` and `.index`.",
    ),
)
