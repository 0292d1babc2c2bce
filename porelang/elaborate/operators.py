"""What operators and kernel operations do to values: lifted over vectors, checked for kind and dimension."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TypeGuard

from porelang.diagnostics import Label
from porelang.elaborate import advice, dimensions, raw, suspect
from porelang.elaborate.bare import degrees, share_and_percent
from porelang.elaborate.context import Context
from porelang.elaborate.natures import note_scaled
from porelang.elaborate.values import (
    POISON,
    Bool,
    Builtin,
    Choice,
    Function,
    ListValue,
    Poison,
    Scalar,
    Text,
    Value,
    Vector,
    describe,
)
from porelang.ir import Node, Stage, const, constant, node
from porelang.ops import OPERATORS, TABLE, Op
from porelang.source import Span
from porelang.units import LENGTH

SETS = {"&": "max", "|": "min", "\\": "max"}
COMPARISONS = {
    "<": ("lt", False),
    "<=": ("le", False),
    ">": ("lt", True),
    ">=": ("le", True),
    "==": ("eq", False),
    "!=": ("eq", False),
}
_SET_WORDS = {"&": "and", "|": "or"}


def unary(ctx: Context, op: str, a: Value, span: Span, at: Span) -> Value:
    """`-a`, `~a`, `not a`."""
    if isinstance(a, Poison):
        return a
    if op == "not":
        if isinstance(a, Bool):
            return Bool(node("not", a.node))
        solid = isinstance(a, Scalar) and a.node.stage is Stage.FIELD
        return ctx.error(
            "E060",
            f"`not` needs a condition, not {describe(a)}",
            at,
            label="this is no condition",
            hint="a solid is turned inside out by `~`" if solid else "",
            edit=(Span(span.source, span.start, at.start), "~") if solid else None,
        )
    if _is_meant_as_solid(a, ctx):
        return not_a_solid(ctx, f"`{op}` needs a solid, and this is a condition", a, at)
    if isinstance(a, Bool) and op == "~":
        return ctx.error(
            "E060", "`~` turns a solid inside out; a condition is turned with `not`", span, edit=(span, "not ")
        )
    if isinstance(a, Scalar):
        if op == "~":
            suspect.total_as_solid(ctx, a)
        n = const(-constant(a.node)) if a.node.op == "const" and a.literal else -a.node
        return Scalar(n, a.dimension, a.literal)
    if isinstance(a, Vector):
        return Vector(-a.x, -a.y, -a.z, a.dimension)
    return ctx.error("E060", f"`{op}` needs a number, not {describe(a)}", at, label=_why(a), hint=how_to_call(a))


def binary(ctx: Context, op: str, a: Value, b: Value, spans: tuple[Span, Span, Span]) -> Value:
    """One operator between two values; `spans` are the places of a, of the operator and of b."""
    if isinstance(a, Poison) or isinstance(b, Poison):
        return POISON
    at_a, at_op, at_b = spans
    if op in ("and", "or"):
        for side, at in ((a, at_a), (b, at_b)):
            if not isinstance(side, Bool):
                instead = {"and": "&", "or": "|"}[op]
                solids = all(isinstance(s, Scalar) for s in (a, b))
                return ctx.error(
                    "E060",
                    f"`{op}` joins conditions, not {describe(side)}",
                    at,
                    label="no condition",
                    hint=f"solids are joined with `{instead}`",
                    edit=(at_op, instead) if solids else None,
                )
        return Bool(node(op, a.node, b.node))  # type: ignore[union-attr]  # both are Bool
    if op in ("==", "!=") and isinstance(a, Bool | Text | Choice) and isinstance(b, Bool | Text | Choice):
        same = _same(ctx, a, b, at_op)
        return Bool(node("not", same.node)) if op == "!=" and isinstance(same, Bool) else same
    for side, at in ((a, at_a), (b, at_b)):
        if not isinstance(side, Scalar | Vector):
            hint = how_to_call(side)
            if isinstance(side, Bool) and op in _SET_WORDS and isinstance(a, Bool) and isinstance(b, Bool):
                hint = f"conditions are joined with `{_SET_WORDS[op]}`"
            elif _is_meant_as_solid(side, ctx) or (op in SETS and is_compared(side, ctx)):
                does = "joins solids" if op in SETS else "works on numbers"
                return not_a_solid(ctx, f"`{op}` {does}, and this is a condition", side, at)
            if isinstance(side, Text):
                hint = "texts are names of files and choices: they cannot be put together or computed with"
            return ctx.error(
                "E060", f"`{op}` works on numbers, not on {describe(side)}", at, label=_why(side), hint=hint
            )
    assert isinstance(a, Scalar | Vector)
    assert isinstance(b, Scalar | Vector)
    if op in COMPARISONS:
        return _compare(ctx, op, a, b, spans)
    if op in SETS:
        for side, at in ((a, at_a), (b, at_b)):
            if isinstance(side, Vector):
                return ctx.error("E060", f"`{op}` combines solids, and a vector is none", at, label="this is a vector")
            suspect.total_as_solid(ctx, side)
        if op == "\\":
            b = Scalar(-b.node, b.dimension)  # type: ignore[union-attr]  # no Vector
        made = apply(ctx, TABLE[SETS[op]], [a, b], (at_a, at_b), at_op, f"`{op}`")
        suspect.cut(ctx, op, (a, at_a), (b, at_b), made, at_op)
        return made
    out = apply(ctx, OPERATORS[op], [a, b], (at_a, at_b), at_op, f"`{op}`")
    if op in ("+", "-"):
        suspect.note_total(ctx, op, out, at_op)
    return out


def _same(ctx: Context, a: Value, b: Value, span: Span) -> Value:
    """Whether two texts, two conditions, or a chosen text and a text are equal."""
    if isinstance(a, Choice) and isinstance(b, Text):
        a, b = b, a
    if isinstance(a, Text) and isinstance(b, Text):
        return Bool(const(a.value == b.value))
    if isinstance(a, Bool) and isinstance(b, Bool):
        return Bool(node("select", a.node, b.node, node("not", b.node)))
    if isinstance(a, Text) and isinstance(b, Choice) and all(isinstance(o, Text) for o in b.options):
        chosen: Node = const(False)
        for i, option in enumerate(b.options):
            if isinstance(option, Text) and option.value == a.value:
                chosen = node("or", chosen, node("eq", b.index, const(float(i))))
        if chosen.op == "const":
            known = ", ".join(f'"{o.value}"' for o in b.options if isinstance(o, Text))
            return ctx.error(
                "E060", f'`{b.name}` is never "{a.value}"', span, label="always false", hint=f"its choices are {known}"
            )
        return Bool(chosen)
    return ctx.error("E060", f"{describe(a)} and {describe(b)} cannot be compared", span, label="always different")


def _compare(ctx: Context, op: str, a: Scalar | Vector, b: Scalar | Vector, spans: tuple[Span, Span, Span]) -> Value:
    for side, at in ((a, spans[0]), (b, spans[2])):
        if isinstance(side, Vector):
            return ctx.error(
                "E060",
                f"`{op}` compares numbers, and this is a vector",
                at,
                hint="compare its length, or one of .x .y .z",
            )
    name, swapped = COMPARISONS[op]
    out = apply(
        ctx,
        TABLE[name],
        [b, a] if swapped else [a, b],
        (spans[2], spans[0]) if swapped else (spans[0], spans[2]),
        spans[1],
        f"`{op}`",
    )
    return Bool(node("not", out.node)) if op == "!=" and isinstance(out, Bool) else out


def apply(ctx: Context, row: Op, arguments: Sequence[Value], places: Sequence[Span], span: Span, called: str) -> Value:
    """A kernel operation on numbers, component by component where some are vectors."""
    numbers: list[Scalar | Vector] = []
    for a, at in zip(arguments, places, strict=True):
        if isinstance(a, Poison):
            return a
        if _is_meant_as_solid(a, ctx):
            return not_a_solid(ctx, f"{called} needs a number, not a condition", a, at)
        if not isinstance(a, Scalar | Vector):
            return ctx.error(
                "E060", f"{called} needs a number, not {describe(a)}", at, label=_why(a), hint=how_to_call(a)
            )
        numbers.append(a)
    exponent = None
    if row.name == "pow" and isinstance(numbers[1], Scalar):
        exponent = ctx.constant(numbers[1].node)
    try:
        dimension = dimensions.result(row.units, numbers, exponent)
    except dimensions.Clash as clash:
        one, two = clash.first, clash.second
        hint, edit = "both sides must be of one kind; a bare number fits anywhere", None
        if called.strip("`") in SETS:  # a solid is one whatever its values are in
            spot = places[two if numbers[one].dimension == LENGTH else one]
            bare = f"bare{spot.text}" if _enclosed(spot.text) else f"bare({spot.text})"
            hint, edit = f"a solid may be a bare number: write `{bare}`", (spot, bare)
        return ctx.error(
            "E062",
            f"{called} of {numbers[one].dimension} and {numbers[two].dimension}",
            places[one],
            label=f"this is {numbers[one].dimension}",
            others=(Label(places[two], f"this is {numbers[two].dimension}"),),
            hint=hint,
            edit=None if any(p.source.prelude for p in places) else edit,
        )
    except dimensions.Unfit as unfit:
        hint = ""
        if row.units == "turns":
            hint = "a turn is a unit: `atan2(y, x) / 1turn` is a number of turns"
            called = "`phase`" if places[0].source.prelude else called  # it reads its phase as a sine, and as a cosine
        return ctx.error(
            "E062",
            f"{called} needs {unfit.wanted}, not {numbers[unfit.argument].dimension}",
            places[unfit.argument],
            label=f"this is {numbers[unfit.argument].dimension}",
            hint=hint,
        )
    out = lift(lambda *n: node(row.name, *n), numbers, dimension, row.result == "bool")
    if (refused := raw.length_on_lattice(ctx, row.name, numbers, places, span)) is not None:
        return refused
    if row.name in ("mul", "div"):
        note_scaled(ctx.natures, row.name, numbers, out)
        raw.note_length(ctx, numbers, out)
    elif row.name in ("add", "sub"):
        raw.note_varied(ctx, numbers, out, span)
    elif row.result == "bool":
        share_and_percent(ctx, numbers, places)
    elif row.units == "angle":
        degrees(ctx, numbers[0], places[0], row.name)
    if row.domain != "all numbers" and isinstance(out, Scalar) and out.node.stage is Stage.CONST:
        value = ctx.constant(out.node)
        if value is not None and not math.isfinite(value):
            what = "infinite" if math.isinf(value) else "not a number"
            return ctx.error(
                "E069",
                f"{called} gives a value that is {what}",
                places[-1],
                label="because of this",
                hint=f"it is defined for: {row.domain}",
            )
    return out


def lift(
    make: Callable[..., Node],
    numbers: Sequence[Scalar | Vector],
    dimension: dimensions.Known,
    boolean: bool = False,
) -> Value:
    """`make` on the nodes of numbers; a scalar beside a vector counts for all three components."""
    if any(isinstance(a, Vector) for a in numbers):
        columns = [a.nodes if isinstance(a, Vector) else (a.node,) * 3 for a in numbers]
        x, y, z = (make(*(c[i] for c in columns)) for i in range(3))
        return Vector(x, y, z, dimension)
    made = make(*(a.node for a in numbers if isinstance(a, Scalar)))
    literal = len(numbers) > 0 and all(isinstance(a, Scalar) and a.literal for a in numbers)
    return Bool(made) if boolean else Scalar(made, dimension, literal and dimension is None)


def _enclosed(text: str) -> bool:
    """Whether the first and the last sign of a text are parentheses that belong together."""
    depth = 0
    for i, c in enumerate(text):
        depth += (c == "(") - (c == ")")
        if depth == 0:
            return c == ")" and i == len(text) - 1
    return False


def _why(value: Value) -> str:
    return f"this is {describe(value)}"


def is_compared(value: Value, ctx: Context) -> TypeGuard[Bool]:
    """Whether a value is a condition that the user made by a comparison."""
    return isinstance(value, Bool) and value.node in ctx.found.conditions


def _is_meant_as_solid(value: Value, ctx: Context) -> TypeGuard[Bool]:
    """Whether a value is `a & z > 2mm`, which compares all of `a & z`."""
    return is_compared(value, ctx) and advice.joins(ctx.found.conditions[value.node])


def not_a_solid(ctx: Context, message: str, value: Bool, at: Span) -> Value:
    """Say that a condition, which the user made by a comparison, stands for a solid."""
    made = ctx.found.conditions[value.node]
    hint, edit = advice.as_solid(made)
    inside = made.span.source is at.source and at.start <= made.span.start and made.span.end <= at.end
    others = () if inside else (Label(made.span, "compared here"),)
    return ctx.error("E060", message, at, "this is a condition", others, hint, edit)


def how_to_call(value: Value) -> str:
    """What to do about a function where a number is wanted."""
    if isinstance(value, Function):
        first = next((p.name for p in value.parameters if p.default is None), None)
        return f"call it: `{value.name}({f'{first}=...' if first else ''})`"
    if isinstance(value, Builtin):
        return f"call it: `{value.name}({', '.join(value.signature)})`"
    return ""


def select(ctx: Context, condition: Node, a: Value, b: Value, span: Span) -> Value:
    """`a` where the condition holds, else `b`."""
    if isinstance(a, Poison) or isinstance(b, Poison):
        return POISON
    known = ctx.constant(condition)
    if known is not None:
        return a if known else b
    if isinstance(a, ListValue) and isinstance(b, ListValue) and len(a.items) == len(b.items):
        return ListValue(tuple(select(ctx, condition, p, q, span) for p, q in zip(a.items, b.items, strict=True)))
    if isinstance(a, Bool) and isinstance(b, Bool):
        return Bool(node("select", condition, a.node, b.node))
    if isinstance(a, Scalar | Vector) and isinstance(b, Scalar | Vector) and type(a) is type(b):
        try:
            dimension = dimensions.same([a, b])
        except dimensions.Clash:
            return ctx.error(
                "E062",
                f"one branch is {a.dimension}, the other {b.dimension}",
                span,
                label="both must be of one kind",
            )
        return lift(lambda p, q: node("select", condition, p, q), [a, b], dimension)
    if ctx.fix(condition):
        return POISON
    return ctx.error(
        "E060",
        f"one branch is {describe(a)}, the other {describe(b)}",
        span,
        label="both must be of one kind",
        hint="only numbers, vectors and conditions can be chosen in space",
    )
