"""Params: numbers (or choices) that are set after the program is compiled, with their range as part of the grammar."""

from __future__ import annotations

from porelang.diagnostics import Label
from porelang.elaborate import bound, operators
from porelang.elaborate.arguments import looked_up
from porelang.elaborate.context import Context
from porelang.elaborate.results import OF_DATA, DataInfo, ParamInfo
from porelang.elaborate.values import (
    POISON,
    TENSOR,
    Bool,
    Builtin,
    Choice,
    Function,
    ListValue,
    Poison,
    Record,
    Scalar,
    Scope,
    Text,
    Value,
    Vector,
    as_list,
    as_vector,
    describe,
)
from porelang.ir import const, param
from porelang.ir import node as make
from porelang.source import Span
from porelang.syntax import tree
from porelang.units import UNITS, Dimension


def declare(ctx: Context, s: tree.Param, scope: Scope, prefix: str) -> Value:
    """The value of a param's name, after noting the param itself."""
    name = prefix + s.name
    if s.kind_span is not None:
        return _data(ctx, s, s.kind_span, scope, name)
    ctx.declared.append(name)
    if s.choices:
        return _choice(ctx, s, scope, name)
    assert s.low is not None
    assert s.high is not None
    parts: list[tuple[str, tree.Expr]] = [
        ("the default", s.default),
        ("the lower end", s.low),
        ("the upper end", s.high),
    ]
    if s.step is not None:
        parts.append(("the step", s.step))
    values: list[float] = []
    dimension: Dimension | None = None
    known: Span | None = None
    for what, t in parts:
        value = ctx.evaluate(t, scope)
        number = ctx.need_constant(value, t.span, f"{what} of `{s.name}`")
        if number is None or not isinstance(value, Scalar):
            return POISON
        if value.dimension is not None:
            if dimension is not None and value.dimension != dimension:
                assert known is not None
                return ctx.error(
                    "E062",
                    f"`{s.name}` is {dimension} here and {value.dimension} there",
                    t.span,
                    label=f"this is {value.dimension}",
                    others=(Label(known, f"this is {dimension}"),),
                )
            dimension, known = value.dimension, t.span
        values.append(number)
    default, low, high, *step = values
    if not low < high:
        return ctx.error(
            "E081",
            f"the range of `{s.name}` is empty: {low:g}..{high:g}",
            s.low.span.to(s.high.span),
            label="the lower end comes first",
        )
    if step and not 0 < step[0] <= high - low and s.step is not None:
        return ctx.error(
            "E081",
            f"the step of `{s.name}` does not fit its range",
            s.step.span,
            label=f"must be above 0 and at most {high - low:g}",
        )
    step_size = step[0] if step else None
    fixed = ctx.structure.get(name)
    ctx.found.params[name] = ParamInfo(
        name, default, low, high, step_size, (), (), dimension, s.doc, s.name_span, fixed is not None
    )
    if not low <= default <= high:
        return ctx.error(
            "E080",
            f"the default of `{s.name}` lies outside its range",
            s.default.span,
            label=f"{default:g} is not in {low:g}..{high:g}",
            others=(Label(s.low.span.to(s.high.span), "its range"),),
            hint="widen the range or change the default",
        )
    return Scalar(param(name) if fixed is None else const(fixed), dimension)


#: The default of each kind of data, as an example.
_AS_IN = {"field": ("a field", "0MPa"), "vector": ("a vector", "[0, 0, 0]"),
          "tensor": ("a tensor", "tensor(0, 0, 0, 0, 0, 0)")}  # fmt: skip


def _data(ctx: Context, s: tree.Param, kind: Span, scope: Scope, name: str) -> Value:
    """The value of a param that takes data: the lookup of what is bound, or its default."""
    components = OF_DATA.get(s.kind)
    if components is None:
        hint = "a number has a range instead of a kind: `param w = 30mm in 10mm..60mm`"
        label = f"data are {' or '.join(f'a `{k}`' for k in OF_DATA)}"
        return ctx.error("E154", f"`{s.name}` cannot be bound to data as a `{s.kind}`", kind, label, hint=hint)
    default = ctx.evaluate(s.default, scope)
    if isinstance(default, Poison):
        return POISON
    parts = _parts(default, components)
    if parts is None:
        what, example = _AS_IN[s.kind]
        message = f"the default of `{s.name}` is {describe(default)}, not {what}"
        return ctx.error("E154", message, s.default.span, hint=f"as in `= {example}`")
    dimension = next((part.dimension for part in parts if part.dimension is not None), None)
    nodes = [part.node for part in parts]
    ctx.found.data[name] = DataInfo(name, components, dimension, s.doc, s.name_span, tuple(nodes))
    if name in ctx.bound:
        op, *payload = ctx.bound[name]
        if op == "load":
            found = _parts(bound.loaded(ctx, s, name, components, payload, scope), components)
            if found is None:
                return POISON
            given = found[0].dimension
            if None not in (given, dimension) and given != dimension:
                fit = next((u for u, known in UNITS.items() if known.dimension == dimension), "...")
                hint = f"say a unit that {dimension} has: `--bind {name}=FILE:ARRAY,unit={fit}`"
                what = "what is bound"
                if "outside" in payload[2] and "unit" not in payload[2]:  # which alone has a unit
                    what, hint = "`outside` of what is bound", f"give `outside` as {dimension} too"
                return ctx.error("E155", f"`{name}` is {dimension}, and {what} to it is {given}", s.name_span,
                                 label="declared here", hint=hint)  # fmt: skip
            nodes = [part.node for part in found]
        else:
            grid = ctx.task(make(op, value=tuple(payload)), s.name_span)
            nodes = [looked_up(grid, k, False, None) for k in range(components)]
    if s.kind == "tensor":
        return Record("tensor", {c: Scalar(n, dimension) for c, n in zip(TENSOR, nodes, strict=True)})
    return Scalar(nodes[0], dimension) if s.kind == "field" else Vector(nodes[0], nodes[1], nodes[2], dimension)


def _parts(value: Value, components: int) -> list[Scalar] | None:
    """The numbers of a value that has so many of them in each place; None of another."""
    if components == 1:
        return [value] if isinstance(value, Scalar) else None
    if components == 3:
        vector = as_vector(value)
        return None if vector is None else [Scalar(n, vector.dimension) for n in vector.nodes]
    items = [value.members.get(c) for c in TENSOR] if isinstance(value, Record) else []
    found = [item for item in items if isinstance(item, Scalar)]
    return found if len(found) == components else None


def _choice(ctx: Context, s: tree.Param, scope: Scope, name: str) -> Value:
    options = [ctx.evaluate(t, scope) for t in s.choices]
    default = ctx.evaluate(s.default, scope)
    if isinstance(default, Poison) or any(isinstance(o, Poison) for o in options):
        return POISON
    if any(isinstance(o, ListValue) for o in options) and None not in (several := [as_list(o) for o in options]):
        options = [ListValue(items) for items in several if items is not None]  # three numbers are a vector elsewhere
    labels = tuple(label_of(o, t) for o, t in zip(options, s.choices, strict=True))
    if all(isinstance(o, Scalar) for o in [*options, default]):
        return _number_choice(ctx, s, options, default, labels, name)
    if len({type(o) for o in options}) > 1 and not all(
        isinstance(o, Function) or callable(getattr(o, "call", None)) for o in options
    ):
        return ctx.error(
            "E082",
            f"the choices of `{s.name}` are of different kinds",
            s.choices[0].span.to(s.choices[-1].span),
            label=", ".join(describe(o) for o in options),
        )
    wanted = label_of(default, s.default)
    if wanted not in labels:
        return ctx.error(
            "E080",
            f"the default of `{s.name}` is none of its choices",
            s.default.span,
            label=f"`{wanted}` is not among them",
            hint=f"the choices are {', '.join(labels)}",
        )
    index = float(labels.index(wanted))
    fixed = ctx.structure.get(name)
    ctx.found.params[name] = ParamInfo(
        name, index, 0.0, float(len(options) - 1), 1.0, labels, (), None, s.doc, s.name_span, fixed is not None
    )
    if fixed is not None:
        return options[int(fixed)]
    node = param(name)
    if all(isinstance(o, Bool | Vector) for o in options):
        out: Value = options[-1]
        for i in range(len(options) - 2, -1, -1):
            out = operators.select(ctx, make("eq", node, const(float(i))), options[i], out, s.span)
        return out
    choice = Choice(s.name, node, tuple(options))
    return choice if all(isinstance(o, Text | Function | Builtin | Choice) for o in options) else ctx.decided(choice)


def _number_choice(
    ctx: Context, s: tree.Param, options: list[Value], default: Value, labels: tuple[str, ...], name: str
) -> Value:
    numbers: list[float] = []
    dimension: Dimension | None = None
    for o, t in zip([*options, default], [*s.choices, s.default], strict=True):
        assert isinstance(o, Scalar)
        number = ctx.need_constant(o, t.span, f"a choice of `{s.name}`")
        if number is None:
            return POISON
        if o.dimension is not None:
            if dimension is not None and dimension != o.dimension:
                return ctx.error(
                    "E062",
                    f"the choices of `{s.name}` are {dimension} and {o.dimension}",
                    t.span,
                    label=f"this is {o.dimension}",
                )
            dimension = o.dimension
        numbers.append(number)
    *numbers, chosen = numbers
    if chosen not in numbers:
        return ctx.error(
            "E080",
            f"the default of `{s.name}` is none of its choices",
            s.default.span,
            label=f"{chosen:g} is not among them",
            hint=f"the choices are {', '.join(labels)}",
        )
    low, high, fixed = min(numbers), max(numbers), ctx.structure.get(name)
    ctx.found.params[name] = ParamInfo(
        name, chosen, low, high, None, labels, tuple(numbers), dimension, s.doc, s.name_span, fixed is not None
    )
    return Scalar(param(name) if fixed is None else const(fixed), dimension)


def label_of(value: Value, t: tree.Expr) -> str:
    """What a choice is called: its text, or as it is written."""
    return value.value if isinstance(value, Text) else t.span.text
