"""Functions that cannot be written in Pore: the kernel operations, and those over lists and whole fields."""

from __future__ import annotations

from porelang.elaborate import chance, tasks, tensors
from porelang.elaborate.calls import call
from porelang.elaborate.context import Context
from porelang.elaborate.operators import apply
from porelang.elaborate.values import (
    POISON,
    Builtin,
    Given,
    ListValue,
    Poison,
    Scalar,
    Value,
    Vector,
    as_list,
    as_vector,
    describe,
)
from porelang.ir import X, Y, Z, const, node
from porelang.ops import CALLABLE, Op
from porelang.source import Span
from porelang.syntax import tree
from porelang.units import LENGTH

#: A list longer than this is a mistake, or the wrong tool.
LONGEST = 100_000
_NAMES = ("a", "b")


def _kernel(row: Op, name: str) -> Builtin:
    def call_it(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
        return apply(ctx, row, values, places, site.span, f"`{name}`")

    count = len(row.args)
    signature = ("y", "x") if name == "atan2" else _NAMES[:count]
    return Builtin(name, signature, call_it, count, count, row.doc)


def _extreme(row: Op, name: str) -> Builtin:
    def call_it(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
        if len(values) == 1:
            items = as_list(values[0])
            if not items:
                return ctx.error(
                    "E061",
                    f"`{name}` of {describe(values[0])} has no meaning",
                    site.span,
                    hint=f"give `{name}` two numbers or more, or a list of them",
                )
            values, places = list(items), places * len(items)
        # halved, so that a union of thousands is not thousands of operations deep
        while len(values) > 1:
            paired: list[Value] = []
            spots: list[Span] = []
            for i in range(0, len(values) - 1, 2):
                paired.append(apply(ctx, row, values[i : i + 2], places[i : i + 2], site.span, f"`{name}`"))
                spots.append(places[i])
            if len(values) % 2:
                paired.append(values[-1])
                spots.append(places[-1])
            values, places = paired, spots
        return (
            values[0]
            if isinstance(values[0], Scalar | Vector | Poison)
            else apply(ctx, row, [values[0], values[0]], places * 2, site.span, f"`{name}`")
        )

    return Builtin(name, ("a", "b", "..."), call_it, 1, None, row.doc + " Takes any number of arguments, or a list.")


def _grad(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    (f,) = values
    if not isinstance(f, Scalar):
        return ctx.error("E060", f"`grad` needs a field, not {describe(f)}", places[0])
    dx, dy, dz = (node("d", f.node, value=i) for i in range(3))
    return Vector(dx, dy, dz, None if f.dimension is None else f.dimension / LENGTH)


def _items(ctx: Context, place: Span, value: Value, name: str) -> tuple[Value, ...] | None:
    items = as_list(value)
    if items is None:
        ctx.error("E060", f"`{name}` needs a list, not {describe(value)}", place)
    return items


def _len(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    items = _items(ctx, places[0], values[0], "len")
    return POISON if items is None else Scalar(const(float(len(items))))


def _range(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    numbers: list[float] = []
    for v, place in zip(values, places, strict=True):
        number = ctx.need_constant(v, place, "a bound of `range`", fixing=True)
        if number is None:
            return POISON
        numbers.append(number)
    start, stop, step = (0.0, numbers[0], 1.0) if len(numbers) == 1 else (*numbers, 1.0)[:3]
    if step == 0:
        return ctx.error("E061", "the step of `range` is 0", site.span, label="this range never ends")
    count = max(0.0, -((start - stop) // step))
    if count > LONGEST:
        return ctx.error(
            "E071",
            f"a range of {count:,.0f} items is too long",
            site.span,
            label=f"at most {LONGEST:,}",
            hint="for something that repeats in space use `repeat`",
        )
    ctx.spend(int(count), site.span)
    return ListValue(tuple(Scalar(const(start + i * step)) for i in range(int(count))))


def _map(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    items = _items(ctx, places[0], values[0], "map")
    if items is None:
        return POISON
    return ListValue(tuple(call(ctx, values[1], [Given(None, i, site.span)], site) for i in items))


def _reduce(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    items = _items(ctx, places[0], values[0], "reduce")
    if items is None:
        return POISON
    if not items:
        return ctx.error("E061", "an empty list cannot be reduced", site.span, label="nothing to combine")
    layer = list(items)
    out = layer[0]
    for item in layer[1:]:
        out = call(ctx, values[1], [Given(None, out, site.span), Given(None, item, site.span)], site)
    return out


def _concat(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    joined: list[Value] = []
    for v, place in zip(values, places, strict=True):
        items = _items(ctx, place, v, "concat")
        if items is None:
            return POISON
        ctx.spend(len(items), site.span)
        joined.extend(items)
    return ListValue(tuple(joined))


def _vector(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    made = as_vector(values[0])
    return made or ctx.error("E060", f"{describe(values[0])} is not three numbers", site.span)


_LISTS = (
    Builtin("grad", ("f",), _grad, 1, 1, "The gradient of a field: the vector of its derivatives along x, y, z."),
    Builtin("len", ("list",), _len, 1, 1, "The number of items of a list."),
    Builtin("range", ("start", "stop", "step"), _range, 1, 3, "Numbers from 0 (or start) up to, not including, stop."),
    Builtin("map", ("list", "f"), _map, 2, 2, "The list of f of each item."),
    Builtin("reduce", ("list", "f"), _reduce, 2, 2, "The items combined from the left by a function of two."),
    Builtin("concat", ("a", "b"), _concat, 1, None, "Lists joined end to end."),
    Builtin("vector", ("list",), _vector, 1, 1, "A list of three numbers as a vector."),
)


def builtins() -> dict[str, Value]:
    """The names that every program starts with, below the prelude."""
    names: dict[str, Value] = {
        "x": Scalar(X),
        "y": Scalar(Y),
        "z": Scalar(Z),
        "p": Vector(X, Y, Z),
    }
    for name, row in CALLABLE.items():
        names[name] = _extreme(row, name) if name in ("min", "max") else _kernel(row, name)
    names |= {b.name: b for b in (*_LISTS, *tensors.BUILTINS, *chance.BUILTINS, *tasks.BUILTINS)}
    return names
