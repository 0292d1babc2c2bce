"""Calls that ask for a task: their arguments checked, a node made; computing it comes later, if a root reads it.

What a task gives is a number, or data. Data are no values of the language: a loaded grid becomes the field that looks
it up, a frame the distance from its bars.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace

from porelang.diagnostics import suggest
from porelang.elaborate import bare, operators
from porelang.elaborate.advice import is_number
from porelang.elaborate.calls import Call, call
from porelang.elaborate.context import Context
from porelang.elaborate.values import (
    ABSENT,
    POISON,
    Bool,
    Builtin,
    Function,
    Given,
    Poison,
    Range,
    Record,
    Scalar,
    Text,
    Value,
    Vector,
    as_vector,
    describe,
)
from porelang.ir import ONE, ZERO, Node, Stage, X, Y, Z, const, node, order, unknown
from porelang.ops import TASK_TABLE
from porelang.ops.tasks import SAME, Task
from porelang.source import Span
from porelang.syntax import tree
from porelang.units import LENGTH, RATIO, SPELT, UNITS, Dimension

_HERE = (X, Y, Z)
#: What a porosity that is asked for has to be.
A_SHARE = "needs a porosity between 0 and 1"


def _field(ctx: Context, value: Value, place: Span, of: str) -> Scalar | None:
    """A field, or None after saying that it is none; `of` names the argument: `f` of `volume`."""
    if isinstance(value, Scalar):
        return value
    if operators.is_compared(value, ctx):
        operators.not_a_solid(ctx, f"{of} must be a field, not a condition", value, place)
        return None
    ctx.error(
        "E060",
        f"{of} must be a field, not {describe(value)}",
        place,
        label=f"this is {describe(value)}",
        hint=f"call it first: `{value.name}(...)`" if isinstance(value, Function) else "",
    )
    return None


def _number(row: Task) -> Call:
    """The call of a task that finds a number from fields."""

    def ask(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
        fields: list[Scalar] = []
        for value, parameter, place in zip(values, row.parameters, places, strict=True):
            found = _field(ctx, value, place, f"`{parameter}` of `{row.name}`")
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
            ctx.required[replace(r, condition=found, solve=len(ctx.found.tasks))] = None
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


def _text(ctx: Context, value: Value, place: Span, what: str, example: str = "stress.npz") -> str | None:
    if isinstance(value, Text):
        if not value.value:
            ctx.error("E060", f"{what} is an empty text", place, hint=f'as in "{example}"')
        return value.value or None
    ctx.error("E060", f"{what} is a text, not {describe(value)}", place, label=f"this is {describe(value)}",
              hint=f'write it in quotes: "{example}"')  # fmt: skip
    return None


def _beside(site: tree.Call, path: str, ctx: Context) -> tuple[str, str]:
    """The path of a file that a program names: beside the program, unless it begins at the root. As a person would
    write it from where the program was named, and whole: a program means the same wherever it is used from then on."""
    shown = os.path.normpath(os.path.join(os.path.dirname(ctx.users_place(site.span).source.name), path))
    return shown, os.path.normpath(os.path.join(ctx.folder, shown))


def looked_up(grid: Node, component: int, smooth: bool, outside: Node | None) -> Node:
    """The field of a component of a grid."""
    found = node("lookup_cubic" if smooth else "lookup", grid, *_HERE, value=(component, 0, 0, 0))
    return found if outside is None else node("select", node("covers", grid, *_HERE), found, outside)


def _smooth(ctx: Context, value: Value, place: Span) -> bool | None:
    if value is ABSENT:
        return False
    known = ctx.constant(value.node) if isinstance(value, Bool) else None
    if isinstance(known, bool):
        return known
    ctx.error("E060", "`smooth` is true or false", place, label=f"this is {describe(value)}")
    return None


def _length_now(ctx: Context, value: Value, place: Span, what: str) -> float | None:
    """A length above 0 that is known now, 0 where it is not given; None after saying what is wrong with it."""
    if value is ABSENT:
        return 0.0
    if isinstance(value, Scalar) and value.dimension not in (None, LENGTH):
        ctx.error("E062", f"{what} is a length, not {value.dimension}", place)
        return None
    known = ctx.need_constant(value, place, what)
    if known is not None and not known > 0:
        ctx.error("E152", f"{what} is a length above 0", place, label=f"this is {known:g} mm", hint="as in 0.5mm")
        return None
    return known


@dataclass(frozen=True, slots=True)
class _Loaded:
    """What is read from a file: a field for each number at a node."""

    grid: Node
    smooth: bool
    masked: bool
    components: int
    scale: Node
    dimension: Dimension | None

    def fields(self, outside: Sequence[Node | None]) -> list[Node]:
        """The field of each number, with what is beyond what the file covers."""
        return [self._field(k, beyond) for k, beyond in enumerate(outside)]

    def _field(self, component: int, outside: Node | None) -> Node:
        found = looked_up(self.grid, component, self.smooth, None)
        if self.scale is not ONE:
            found = node("mul", found, self.scale)
        if outside is None:
            return found
        covered = node("covers", self.grid, *_HERE)
        if self.masked:  # where the component that says how far outside of the cells a place lies is below 0
            covered = node("and", covered, node("le", looked_up(self.grid, self.components, False, None), ZERO))
        return node("select", covered, found, outside)


def _unit(ctx: Context, value: Value, place: Span, called: str) -> tuple[Node, Dimension | None] | None:
    """By what values are multiplied, and what they then are; None after saying what is wrong with a unit."""
    if value is ABSENT:
        return ONE, None
    if isinstance(value, Text) and value.value in UNITS:
        return const(UNITS[value.value].scale), UNITS[value.value].dimension
    at, known = bare.value_of(place), f"the units are {', '.join(UNITS)}"
    if isinstance(value, Text):
        near = SPELT.get(value.value) or suggest(value.value, UNITS)
        hint = f"did you mean `{near}`?" if near else f"write it without quotes, as in `unit=MPa`; {known}"
        ctx.error("E153", f"`{value.value}` is not a unit", place, hint=hint, edit=(at, near) if near else None)
        return None
    scale = ctx.need_constant(value, place, f"the unit of `{called}`")
    if scale is None or not isinstance(value, Scalar):
        return None
    if value.dimension is None or not 0 < scale < math.inf:
        what = f"this is {scale:g}" if value.dimension is None else f"this is {scale:g}{value.dimension.unit}"
        ctx.error("E153", f"the unit of `{called}` is no unit", place, what, hint=f"as in `unit=MPa`; {known}")
        return None
    return const(scale), value.dimension


def _loaded(
    ctx: Context, values: list[Value], places: list[Span], site: tree.Call, called: str, components: int
) -> _Loaded | None:
    """The slot of what is loaded; its file has to hold so many numbers at each node."""
    unit = _unit(ctx, values[5], places[5], called)
    smooth = _smooth(ctx, values[3], places[3])
    voxel = _length_now(ctx, values[4], places[4], f"`voxel` of `{called}`")
    path = _text(ctx, values[0], places[0], f"the path of the file that `{called}` reads")
    name = _text(ctx, values[1], places[1], f"the name of what `{called}` takes from a file", "von_mises")
    if path is None or name is None or smooth is None or voxel is None or unit is None:
        return None
    masked = values[2] is not ABSENT and not path.lower().endswith(".npz")
    more = (voxel, int(masked)) if voxel or masked else ()
    grid = ctx.task(node("load", value=(*_beside(site, path, ctx), name, components, *more)), site.span)
    return _Loaded(grid, smooth, masked, components, *unit)


def _dimension_of(ctx: Context, loaded: _Loaded, outside: Scalar | Vector | None, place: Span) -> Dimension | None:
    """What is loaded is measured in; says so where what is outside is of another dimension."""
    beyond = None if outside is None else outside.dimension
    if None not in (beyond, loaded.dimension) and beyond != loaded.dimension:
        ctx.error("E062", f"inside this is {loaded.dimension}, outside {beyond}", place, hint="give both one unit")
    return loaded.dimension or beyond


def _load(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    outside = None if values[2] is ABSENT else _field(ctx, values[2], places[2], "`outside` of `load`")
    loaded = _loaded(ctx, values, places, site, "load", 1)
    if loaded is None or (outside is None and values[2] is not ABSENT):
        return POISON
    (field,) = loaded.fields([None if outside is None else outside.node])
    return Scalar(field, _dimension_of(ctx, loaded, outside, places[2]))


def _load_vector(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    outside = None if values[2] is ABSENT else as_vector(values[2])
    if outside is None and values[2] is not ABSENT:
        return ctx.error(
            "E060", f"`outside` of `load_vector` is a vector, not {describe(values[2])}", places[2],
            hint="write three numbers: `outside=[0, 0, 0]`",
        )  # fmt: skip
    loaded = _loaded(ctx, values, places, site, "load_vector", 3)
    if loaded is None:
        return POISON
    x, y, z = loaded.fields(outside.nodes if outside is not None else (None,) * 3)
    return Vector(x, y, z, _dimension_of(ctx, loaded, outside, places[2]))


#: The components of a symmetric tensor, in VTK's order.
TENSOR = ("xx", "yy", "zz", "xy", "yz", "xz")


def _load_tensor(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    outside = None if values[2] is ABSENT else _field(ctx, values[2], places[2], "`outside` of `load_tensor`")
    loaded = _loaded(ctx, values, places, site, "load_tensor", 6)
    if loaded is None or (outside is None and values[2] is not ABSENT):
        return POISON
    # outside it is the same in all directions: a pressure, or nothing
    beyond = (None,) * 6 if outside is None else (*(outside.node,) * 3, *(ZERO,) * 3)
    fields = loaded.fields(beyond)
    dimension = _dimension_of(ctx, loaded, outside, places[2])
    return Record("tensor", {c: Scalar(f, dimension) for c, f in zip(TENSOR, fields, strict=True)})


def _sample(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    vector = as_vector(values[0])
    field = vector if vector is not None else _field(ctx, values[0], places[0], "`f` of `sample`")
    if field is None:
        return POISON
    voxel = _field(ctx, values[1], places[1], "`voxel` of `sample`")
    within = _field(ctx, values[2], places[2], "`within` of `sample`")
    smooth = _smooth(ctx, values[3], places[3])
    if voxel is None or within is None or smooth is None:
        return POISON
    if voxel.node.stage is Stage.FIELD:
        return ctx.error("E063", "`voxel` of `sample` must be one number", places[1], label="this varies in space")
    if voxel.dimension not in (None, LENGTH):
        return ctx.error("E062", f"`voxel` of `sample` is a length, not {voxel.dimension}", places[1])
    known = ctx.constant(voxel.node)
    if known is not None and not known > 0:
        return ctx.error("E096", f"a voxel of {known:g} mm cannot be sampled at", places[1],
                         hint="give a length above 0, as in 1mm")  # fmt: skip
    fields = field.nodes if isinstance(field, Vector) else (field.node,)
    grid = ctx.task(node("sample", *fields, voxel.node, within.node), site.span)
    found = [looked_up(grid, k, smooth, None) for k in range(len(fields))]
    if isinstance(field, Vector):
        return Vector(found[0], found[1], found[2], field.dimension)
    return Scalar(found[0], _dimension(TASK_TABLE["sample"], field.dimension))


def _blur(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    vector = as_vector(values[0])
    field = vector if vector is not None else _field(ctx, values[0], places[0], "`f` of `blur`")
    sigma = _uniform_length(ctx, values[1], places[1], "`sigma` of `blur`")
    within = _field(ctx, values[2], places[2], "`within` of `blur`")
    voxel = sigma if values[3] is ABSENT else _uniform_length(ctx, values[3], places[3], "`voxel` of `blur`")
    smooth = _smooth(ctx, values[4], places[4])
    if field is None or sigma is None or within is None or voxel is None or smooth is None:
        return POISON
    wide, step = ctx.constant(sigma.node), ctx.constant(voxel.node)
    if None not in (wide, step) and float(step or 0) > float(wide or 0):
        return ctx.error("E156", f"samples every {step:g} mm do not tell what is averaged over {wide:g} mm", places[3],
                         hint=f"take {float(wide or 0) / 2:.3g}mm, or leave `voxel` out")  # fmt: skip
    step_node = node("mul", sigma.node, const(0.5)) if values[3] is ABSENT else voxel.node
    fields = field.nodes if isinstance(field, Vector) else (field.node,)
    grid = ctx.task(node("blur", *fields, sigma.node, step_node, within.node), site.span)
    found = [looked_up(grid, k, smooth, None) for k in range(len(fields))]
    if isinstance(field, Vector):
        return Vector(found[0], found[1], found[2], field.dimension)
    return Scalar(found[0], field.dimension)


def _uniform_length(ctx: Context, value: Value, place: Span, what: str) -> Scalar | None:
    """A length above 0 that is the same everywhere; None after saying what is wrong with it."""
    found = _field(ctx, value, place, what)
    if found is None:
        return None
    if found.node.stage is Stage.FIELD:
        ctx.error("E063", f"{what} must be one number", place, label="this varies in space")
        return None
    if found.dimension not in (None, LENGTH):
        ctx.error("E062", f"{what} is a length, not {found.dimension}", place)
        return None
    known = ctx.constant(found.node)
    if known is not None and not known > 0:
        ctx.error("E156", f"{what} is a length above 0", place, label=f"this is {known:g} mm", hint="as in 2mm")
        return None
    return found


def _bars(ctx: Context, site: tree.Call, path_given: Value, place: Span) -> Node | None:
    path = _text(ctx, path_given, place, "the path of a frame's file", "truss.json")
    return None if path is None else ctx.task(node("frame", value=_beside(site, path, ctx)), site.span)


def _nearest(bars: Node, result: str) -> Node:
    return node("nearest", bars, *_HERE, value=result)


def _frame(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    bars = _bars(ctx, site, values[0], places[0])
    return POISON if bars is None else Scalar(_nearest(bars, "distance"))


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


_CALLS: dict[str, Call] = {"solve": _solve, "load": _load, "sample": _sample, "blur": _blur, "frame": _frame}


def _builtin(row: Task) -> Builtin:
    most = len(row.parameters)
    ask = _CALLS.get(row.name) or _number(row)
    return Builtin(row.name, row.parameters, ask, most - row.optional, most, row.doc, row.optional > 0)


BUILTINS = (
    *(_builtin(row) for row in TASK_TABLE.values() if row.parameters),
    Builtin(
        "load_vector",
        TASK_TABLE["load"].parameters,
        _load_vector,
        2,
        len(TASK_TABLE["load"].parameters),
        "A vector field from samples in a file, as `load`; its array holds three numbers a node: (nx, ny, nz, 3).",
        True,
    ),
    Builtin(
        "load_tensor",
        TASK_TABLE["load"].parameters,
        _load_tensor,
        2,
        len(TASK_TABLE["load"].parameters),
        "A symmetric tensor from samples in a file, as `load`: a stress, with the members `.xx`, `.yy`, `.zz`, `.xy`, "
        "`.yz` and `.xz`. Its array holds these six a node, in this order, or all nine. `outside` is one number, for "
        "`.xx`, `.yy` and `.zz`.",
        True,
    ),
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
