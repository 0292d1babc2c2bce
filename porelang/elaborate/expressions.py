"""What each kind of expression is worth: the tree's expressions as values."""

from __future__ import annotations

from dataclasses import replace

from porelang.diagnostics import Edit, Label, suggest
from porelang.elaborate import operators, suspect
from porelang.elaborate.calls import call
from porelang.elaborate.context import Context
from porelang.elaborate.kinds import check_kinds
from porelang.elaborate.names import free_names, units_named
from porelang.elaborate.values import (
    POISON,
    Bool,
    Builtin,
    Function,
    Given,
    ListValue,
    Poison,
    Range,
    Record,
    Scalar,
    Scope,
    Study,
    Text,
    Value,
    Vector,
    as_list,
    as_vector,
    describe,
)
from porelang.ir import Node, const, node
from porelang.source import Span
from porelang.syntax import tree
from porelang.units import UNITS, Dimension


def evaluate(ctx: Context, t: tree.Expr, scope: Scope) -> Value:
    """The value of an expression; what is wrong with it has been said."""
    match t:
        case tree.Name():
            return _name(ctx, t, scope)
        case tree.Number():
            return _number(ctx, t)
        case tree.Call():
            return _call(ctx, t, scope, ())
        case tree.Chain():
            return _chain(ctx, t, scope)
        case tree.Unary():
            return operators.unary(ctx, t.op, ctx.evaluate(t.operand, scope), t.span, t.operand.span)
        case tree.List():
            return _list(ctx, t, scope)
        case tree.Member():
            return _member(ctx, t, scope)
        case tree.Index():
            return _index(ctx, t, scope)
        case tree.If():
            return _if(ctx, t, scope)
        case tree.Block():
            return _block(ctx, t, scope)
        case tree.Lambda():
            parameters = tuple(tree.Parameter(p.span, p.name, p.span, (), None, None, None) for p in t.parameters)
            return Function(_written(t.span), parameters, t.body, scope)
        case tree.Comprehension():
            items: list[Value] = []
            sound = _comprehend(ctx, t, 0, scope, items)
            return ListValue(tuple(items)) if sound else POISON
        case tree.Text():
            return Text(t.value)
        case tree.Boolean():
            return Bool(const(t.value))


def _written(span: Span) -> str:
    """What a function without a name is called in messages: as it is written."""
    text = " ".join(span.text.split())
    return f"({text})" if len(text) <= 40 else f"({text.partition('=>')[0]}=> ...)"


def _name(ctx: Context, t: tree.Name, scope: Scope) -> Value:
    value = scope.find(t.name)
    if value is None:  # said by the walk over names, or the unused one of a pair of parameters
        if ctx.call_stack and t.name not in ctx.unknown:
            return ctx.error("E043", f"`{t.name}` is not given here", t.span)
        return POISON
    return ctx.refer(value)


def _number(ctx: Context, t: tree.Number) -> Value:
    if not t.unit:
        return Scalar(const(t.value), None, True)
    unit = UNITS[t.unit]
    return Scalar(const(t.value * unit.scale), unit.dimension)


#: The names of units, where they are units: one of each.
_UNITS: dict[str, Value] = {u.name: Scalar(const(u.scale), u.dimension) for u in UNITS.values()}


def _call(ctx: Context, t: tree.Call, scope: Scope, piped: tuple[Given, ...]) -> Value:
    function = ctx.evaluate(t.function, scope)
    given = list(piped)
    for a in t.arguments:
        around = Scope(_UNITS, scope) if units_named(t, a) else scope
        given.append(Given(a.name, ctx.evaluate(a.value, around), a.span))
    return call(ctx, function, given, t)


def _chain(ctx: Context, t: tree.Chain, scope: Scope) -> Value:
    value, span = ctx.evaluate(t.first, scope), t.first.span
    suspect.pipe_below_set(ctx, t)
    for (op, right), op_span in zip(t.rest, t.op_spans, strict=True):
        if op == "^" and _is_doubtful_power(t.first, op_span):
            return _doubtful_power(ctx, t.first, span.to(right.span), right.span)
        if op == "|>":
            value = _pipe(ctx, value, span, right, scope)
        elif op == "..":
            value = _range(ctx, value, span, ctx.evaluate(right, scope), right.span)
        elif op == "@":
            value = _at(ctx, value, span, ctx.evaluate(right, scope), right.span)
        else:
            value = operators.binary(ctx, op, value, ctx.evaluate(right, scope), (span, op_span, right.span))
            if isinstance(value, Bool) and op in operators.COMPARISONS and not t.span.source.prelude:
                ctx.found.conditions.setdefault(value.node, t)
        span = span.to(right.span)
    return value


def _is_doubtful_power(base: tree.Expr, op: Span) -> bool:
    """Whether this is `640mm^3`, which reads as 640 mm3 and is (640mm)^3. (What is in parentheses is clear.)"""
    between = op.source.text[base.span.end : op.start]
    return isinstance(base, tree.Number) and bool(base.unit) and base.value not in (0, 1) and ")" not in between


def _doubtful_power(ctx: Context, base: tree.Expr, span: Span, exponent: Span) -> Value:
    assert isinstance(base, tree.Number)
    number = base.span.text.removesuffix(base.unit)
    unit = f"({number} * 1{base.unit}^{exponent.text})"
    return ctx.error(
        "E039",
        f"`{span.text}` can be read in two ways",
        span,
        label=f"{number} {base.unit}{exponent.text}, or the power of {base.span.text}",
        hint=f"write `{unit}` for the one, `({base.span.text})^{exponent.text}` for the other",
        edit=(span, unit),
    )


def _range(ctx: Context, low: Value, low_span: Span, high: Value, high_span: Span) -> Value:
    for end, at in ((low, low_span), (high, high_span)):
        if isinstance(end, Poison):
            return POISON
        if not isinstance(end, Scalar):
            return ctx.error("E060", f"an end of a range is a number, not {describe(end)}", at)
    assert isinstance(low, Scalar)
    assert isinstance(high, Scalar)
    if None not in (low.dimension, high.dimension) and low.dimension != high.dimension:
        return ctx.error(
            "E062",
            f"a range from {low.dimension} to {high.dimension}",
            low_span,
            label="one end",
            others=(Label(high_span, "the other"),),
        )
    return Range(low, high)


def _pipe(ctx: Context, value: Value, span: Span, right: tree.Expr, scope: Scope) -> Value:
    piped = (Given(None, value, span),)
    if isinstance(right, tree.Call):
        return _call(ctx, right, scope, piped)
    return call(ctx, ctx.evaluate(right, scope), piped, tree.Call(right.span, right, ()))


def _at(ctx: Context, value: Value, span: Span, point: Value, at: Span) -> Value:
    if isinstance(value, Poison) or isinstance(point, Poison):
        return POISON
    q = as_vector(point)
    if q is None:
        return ctx.error(
            "E060",
            f"`@` needs a point, not {describe(point)}",
            at,
            label=f"this is {describe(point)}",
            hint="a point is a vector: `f @ [x + 5, y, z]`",
        )
    if isinstance(value, Record) and value.name == "tensor":  # six fields
        return Record(value.name, {name: _at(ctx, part, span, point, at) for name, part in value.members.items()})
    if not isinstance(value, Scalar | Vector | Bool):
        return ctx.error(
            "E060",
            f"`@` evaluates a field, not {describe(value)}",
            span,
            label=f"this is {describe(value)}",
            hint=operators.how_to_call(value),
        )

    def moved(n: Node) -> Node:
        return node("at", n, *q.nodes) if n.axes else n

    match value:
        case Scalar():
            return Scalar(moved(value.node), value.dimension)
        case Bool():
            return Bool(moved(value.node))
    return Vector(moved(value.x), moved(value.y), moved(value.z), value.dimension)


def _list(ctx: Context, t: tree.List, scope: Scope) -> Value:
    items = [ctx.evaluate(i, scope) for i in t.items]
    if any(isinstance(i, Poison) for i in items):
        return POISON
    if len(items) == 3 and all(isinstance(i, Scalar) for i in items):
        return _vector(ctx, items, [i.span for i in t.items])
    return ListValue(tuple(items))


def _vector(ctx: Context, items: list[Value], spans: list[Span]) -> Value:
    known: dict[int, Dimension] = {}
    for i, item in enumerate(items):
        assert isinstance(item, Scalar)
        if item.dimension is not None:
            known[i] = item.dimension
    first = next(iter(known), None)
    for i, d in known.items():
        if first is not None and d != known[first]:
            return ctx.error(
                "E062",
                f"a vector of {known[first]} and {d}",
                spans[first],
                label=f"this is {known[first]}",
                others=(Label(spans[i], f"this is {d}"),),
            )
    nodes = [i.node for i in items if isinstance(i, Scalar)]
    return Vector(nodes[0], nodes[1], nodes[2], None if first is None else known[first])


def _member(ctx: Context, t: tree.Member, scope: Scope) -> Value:
    target = ctx.evaluate(t.target, scope)
    if isinstance(target, Poison):
        return POISON
    if (vector := as_vector(target)) is not None and t.name in ("x", "y", "z"):
        return Scalar(vector.nodes["xyz".index(t.name)], vector.dimension)
    if isinstance(target, Record):
        value = target.members.get(t.name)
        if value is not None:
            return ctx.refer(value)
        why = target.without.get(t.name) if isinstance(target, Study) else None
        near = suggest(t.name, target.members) if why is None else None
        return ctx.error(
            "E036",
            f"`{target.name}` has no `{t.name}`",
            t.name_span,
            label="nothing is called this there",
            hint=why or (f"did you mean `{near}`?" if near else f"it has {', '.join(sorted(target.members))}"),
            edit=Edit(t.name_span, near) if near else None,
        )
    hint = "a vector has the members x, y and z"
    edit = None
    if isinstance(scope.find(t.name), Function | Builtin):
        dot = Span(t.span.source, t.target.span.end, t.name_span.start)
        hint, edit = f"`{t.name}` is a function: write `a |> {t.name}(...)` for `{t.name}(a, ...)`", Edit(dot, " |> ")
    return ctx.error(
        "E036", f"{describe(target)} has no `{t.name}`", t.name_span, label="no such member", hint=hint, edit=edit
    )


def _index(ctx: Context, t: tree.Index, scope: Scope) -> Value:
    target, index = ctx.evaluate(t.target, scope), ctx.evaluate(t.index, scope)
    if isinstance(target, Poison):
        return POISON
    items = as_list(target)
    if items is None:
        return ctx.error("E060", f"{describe(target)} has no items", t.target.span, label="this is no list")
    number = ctx.need_constant(index, t.index.span, "an index", fixing=True)
    if number is None:
        return POISON
    if number != int(number) or not 0 <= number < len(items):
        last = f"0 to {len(items) - 1}" if items else "none"
        return ctx.error(
            "E065",
            f"there is no item {number:g} in {describe(target)}",
            t.index.span,
            label="out of reach",
            hint=f"the items are numbered from 0: {last}",
        )
    return items[int(number)]


def _if(ctx: Context, t: tree.If, scope: Scope) -> Value:
    with ctx.requiring() as others:
        out = ctx.evaluate(t.otherwise, scope)
    for condition, then in reversed(t.branches):
        with ctx.requiring() as always:
            test = ctx.evaluate(condition, scope)
        with ctx.requiring() as own:
            value = ctx.evaluate(then, scope)
        if isinstance(test, Poison):
            out = POISON
            continue
        if not isinstance(test, Bool):
            out = ctx.error(
                "E060",
                f"`if` needs a condition, not {describe(test)}",
                condition.span,
                label=f"this is {describe(test)}",
                hint="compare it with something: `if a > 0`",
            )
            continue
        with ctx.requiring() as both:
            ctx.required.update((r, None) for r in own if r in others)  # whatever is taken: once, or they double
            ctx.require_where(test.node, (r for r in own if r not in both))
            ctx.require_where(node("not", test.node), (r for r in others if r not in both))
        others = {**always, **both}
        out = operators.select(ctx, test.node, value, out, t.span)
    ctx.required.update(others)
    return out


def named(value: Value, let: tree.Let) -> Value:
    """The value that a `let` binds: a function that is written in it is called as it is."""
    if isinstance(value, Function) and isinstance(let.value, tree.Lambda):
        return replace(value, name=let.name)
    return value


def _block(ctx: Context, t: tree.Block, scope: Scope) -> Value:
    for b in t.bindings:
        names: dict[str, Value] = {}
        inner = Scope(names, scope)
        if isinstance(b, tree.Let):
            names[b.name] = named(ctx.evaluate(b.value, scope), b)
        else:
            check_kinds(ctx, b)
            names[b.name] = Function(b.name, b.parameters, b.body, scope, b)
        scope = inner
    return ctx.evaluate(t.value, scope)


def _comprehend(
    ctx: Context, t: tree.Comprehension, depth: int, scope: Scope, into: list[Value], times: int = 1
) -> bool:
    """Collect the values of a comprehension; False if one of them is poison.

    A list whose length does not depend on the items before it is gone through `times` times, so that all of them are
    known to be too many before the first is computed.
    """
    if depth == len(t.clauses):
        into.append(ctx.evaluate(t.value, scope))
        return not isinstance(into[-1], Poison)
    clause = t.clauses[depth]
    source = clause.items
    value = ctx.evaluate(source, scope)
    if isinstance(value, Poison):
        return False
    items = as_list(value)
    if items is None:
        counted = f"count with `range`: `for {clause.name.name} in range({source.span.text})`"
        hint = counted if isinstance(value, Scalar) else ""
        ctx.error("E060", f"`for` needs a list, not {describe(value)}", source.span, label="this is no list", hint=hint)
        return False
    sound = True
    times = times * len(items) if times and not clause.filters and _alike(source, t.clauses[:depth]) else 0
    ctx.expect(times, t.span)  # each item is an expression at least
    for item in items:
        inner = Scope({clause.name.name: item}, scope)
        taken = _taken(ctx, clause.filters, inner)
        if taken is None:
            return False
        if taken:
            sound &= _comprehend(ctx, t, depth + 1, inner, into, times)
            times = 0
    return sound


def _alike(source: tree.Expr, before: tuple[tree.Clause, ...]) -> bool:
    """Whether a list is the same for all items of the clauses before it, whose names it does not use."""
    return not before or not {n.name for n in free_names(source)} & {c.name.name for c in before}


def _taken(ctx: Context, filters: tuple[tree.Expr, ...], scope: Scope) -> bool | None:
    """Whether an item satisfies the filters of its clause; None where one is no condition, or not known now."""
    for t in filters:
        value = ctx.evaluate(t, scope)
        if isinstance(value, Poison):
            return None
        if not isinstance(value, Bool):
            ctx.error(
                "E060",
                f"`if` needs a condition, not {describe(value)}",
                t.span,
                label=f"this is {describe(value)}",
                hint="compare it with something: `if i > 0`",
            )
            return None
        known = ctx.need_known(value.node, t.span, "what chooses the items of a list")
        if not known:
            return None if known is None else False
    return True
