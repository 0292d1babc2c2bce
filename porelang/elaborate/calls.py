"""Calls: arguments matched to parameters, their kinds and contracts checked, the body evaluated once per set of
values."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

from porelang.diagnostics import Edit, Label
from porelang.elaborate import advice, operators, raw, suspect
from porelang.elaborate.bare import value_of
from porelang.elaborate.context import Context
from porelang.elaborate.kinds import KINDS, Kind
from porelang.elaborate.natures import note
from porelang.elaborate.values import (
    ABSENT,
    POISON,
    Bool,
    Builtin,
    Choice,
    Function,
    Given,
    ListValue,
    Poison,
    Scalar,
    Scope,
    Text,
    Value,
    Vector,
    as_list,
    describe,
    map_nodes,
    memo_key,
)
from porelang.ir import Node, Stage, node
from porelang.source import Span
from porelang.syntax import habits, tree

DEEPEST = 150
#: Kinds that are one number.
_NUMBERS = frozenset(("number", "field", "solid", "ratio", "length", "angle", "force", "stress", "rate", "count"))
#: What a builtin does: of the place of the call, the values of its arguments, and the place of each.
Call = Callable[[Context, tree.Call, list[Value], list[Span]], Value]


def call(ctx: Context, function: Value, arguments: Sequence[Given], site: tree.Call) -> Value:
    """The value of a call."""
    match function:
        case Function():
            return _call_function(ctx, function, arguments, site)
        case Builtin():
            return _call_builtin(ctx, function, arguments, site)
        case Choice():
            return _call_choice(ctx, function, arguments, site)
        case Poison():
            return POISON
    if isinstance(site.function, tree.Name) and site.function.name in ("map", "reduce", "solve"):
        name = site.function.name  # which was handed something that is no function
        hint = f"write it as {'`(a, b) => ...`' if name == 'reduce' else '`t => ...`'}"
        return ctx.error("E060", f"`{name}` needs a function, not {describe(function)}", site.span, hint=hint)
    hint = "for a product write `*` between the two"
    if isinstance(function, Text):
        hint = "functions stand without quotes, as choices too: `in {gyroid, diamond}`"
    return ctx.error(
        "E061", f"{describe(function)} cannot be called", site.function.span, label="this is no function", hint=hint
    )


def _call_builtin(ctx: Context, function: Builtin, arguments: Sequence[Given], site: tree.Call) -> Value:
    values: list[Value] = []
    places: list[Span] = []
    slots: dict[str, Given] = {}
    for a in arguments:
        if a.name is None:
            values.append(a.value)
            places.append(a.span)
            continue
        if a.name not in function.signature or function.most is None:
            return _no_such_parameter(ctx, function.name, a, function.signature)
        if a.name in slots or function.signature.index(a.name) < len(values):
            return ctx.error(
                "E042", f"`{a.name}` of `{function.name}` is given twice", a.span, label="given again here"
            )
        slots[a.name] = a
    for i, name in enumerate(function.signature[len(values) :], len(values)):
        if name not in slots and not (slots and i >= function.least):
            break
        found = slots.pop(name, Given(name, ABSENT, site.span))
        values.append(found.value)
        places.append(found.span)
    if len(values) < function.least or slots:
        missing = function.signature[min(len(values), len(function.signature) - 1)]
        return ctx.error(
            "E043",
            f"`{function.name}` needs `{missing}`",
            site.span,
            label="an argument is missing here",
            hint=f"it is called as `{function.name}({', '.join(function.signature)})`",
        )
    if function.most is not None and len(values) > function.most:
        return _too_many(ctx, function.name, function.signature, arguments[function.most].span, None)
    if any(isinstance(v, Poison) and v is not ABSENT for v in values):
        return POISON
    if function.optional:
        left_out = len(function.signature) - len(values)
        values, places = values + [ABSENT] * left_out, places + [site.span] * left_out
    return function.call(ctx, site, values, places)


def _call_choice(ctx: Context, choice: Choice, arguments: Sequence[Given], site: tree.Call) -> Value:
    results: list[tuple[Node, Value]] = []
    for i, option in enumerate(choice.options):
        condition = node("eq", choice.index, node("const", value=float(i)))
        with ctx.requiring() as own:
            results.append((condition, call(ctx, option, arguments, site)))
        ctx.require_where(condition, own)
    out = results[-1][1]
    for condition, value in reversed(results[:-1]):
        out = operators.select(ctx, condition, value, out, site.span)
    return out


def _call_function(ctx: Context, function: Function, arguments: Sequence[Given], site: tree.Call) -> Value:
    function = _list_form(function, arguments)
    given = _match(ctx, function, arguments, site)
    if given is None:
        return POISON
    if len(ctx.call_stack) >= DEEPEST:
        return ctx.error(
            "E072",
            f"calls are nested more than {DEEPEST} deep at `{function.name}`",
            site.span,
            label="a function that is handed to itself never ends",
            hint="there is no recursion",
        )
    ctx.call_stack.append((function.name, site.span))
    try:
        return _evaluate_body(ctx, function, given, site)
    finally:
        ctx.call_stack.pop()


def _evaluate_body(ctx: Context, function: Function, given: dict[str, Given], site: tree.Call) -> Value:
    if advice.are_swapped(ctx, function, given, site):
        return POISON
    bound: dict[str, Value] = {}
    scope = Scope(bound, function.scope)
    kinds: dict[str, Kind] = {}
    sound = True
    for p in function.parameters:
        if p.name in given:
            value = given[p.name].value
        elif p.default is not None:
            value = ctx.evaluate(p.default, scope)
        else:
            continue  # the other one of a pair `w or phase` is given
        if p.kinds and not isinstance(value, Poison):
            place = given[p.name].span if p.name in given else site.span
            coerced = _coerce(ctx, function, p, value, place, site)
            if coerced is None:
                value, sound = POISON, False
            else:
                kinds[p.name], value = coerced
        bound[p.name] = value
        sound = sound and not isinstance(value, Poison)
    if not sound and not any(isinstance(v, Poison) for v in bound.values()):
        return POISON
    ctx.record(function, bound, site.span)
    exchanged = suspect.call_of(ctx, function, given, kinds, site)
    if not site.span.source.prelude and raw.call_on_lattice(ctx, function, given) is not None:
        return POISON
    memo = (function, *((k, memo_key(v)) for k, v in bound.items()))
    known = ctx.memo.get(memo)
    if known is not None:
        value, required, noted = known
        ctx.required.update(required)
        ctx.journal.done(noted)
        return value
    mark = ctx.journal.mark()
    with ctx.requiring() as own:
        ensured = _contracts(ctx, function, bound, scope, kinds, given, site) if sound else []
        if exchanged and ensured:  # what is broken at points by a field that does not belong there has been said
            ensured = []
        # what the body would say about values it does not take is of no use
        result = POISON if ensured is None else ctx.evaluate(function.body, scope)
    ctx.required.update(own)
    if ensured is None:
        ctx.memo[memo] = (POISON, {}, ctx.journal.since(mark))
        return POISON
    for which, condition in ensured:
        result = map_nodes(result, lambda n, c=condition, k=which: node("ensure", n, c, value=k))  # type: ignore[misc]  # a default binds now
    if function.definition is not None:
        given_as = note(ctx.natures, function.definition, bound, result)
        if given_as is not None and given_as.raw and given_as.plain and isinstance(result, Scalar):
            ctx.found.lattices.setdefault(result.node, (ctx.users_place(site.span), given_as.period))
        suspect.made_by(ctx, function, bound, result, site)
    ctx.memo[memo] = (result, own, ctx.journal.since(mark))
    return result


def _coerce(
    ctx: Context, function: Function, p: tree.Parameter, value: Value, place: Span, site: tree.Call
) -> tuple[Kind, Value] | None:
    """The value as the first declared kind that it fits."""
    declared = [KINDS[k.name] for k in p.kinds if k.name in KINDS] or [KINDS["any"]]
    for kind in declared:
        coerced = kind.coerce(value)
        if coerced is None:
            continue
        what = f"`{p.name}` of `{function.name}`"
        if kind.constant and isinstance(coerced, Scalar) and ctx.need_known(coerced.node, place, what) is None:
            return None
        if kind.whole and isinstance(coerced, Scalar) and ctx.fix(coerced.node):
            return None
        return kind, coerced
    if isinstance(value, Choice) and isinstance(ctx.decided(value), Poison):
        return None
    wanted = " or ".join(k.words for k in declared) or "something else"
    if declared[0].name in ("field", "solid") and operators.is_compared(value, ctx):
        operators.not_a_solid(ctx, f"`{p.name}` of `{function.name}` must be {wanted}, not a condition", value, place)
        return None
    code = "E062" if isinstance(value, Scalar | Vector) and value.dimension is not None else "E060"
    others = (Label(p.span, "declared here"),) if not p.span.source.prelude else ()
    message = f"`{p.name}` of `{function.name}` must be {wanted}, not {describe(value)}"
    hint = f"divide it by a length: `{place.text} / 10mm`" if declared[0].name == "rate" else ""
    edit: Edit | None = None
    if isinstance(value, Function):
        hint = f"`{value.name}` is a function; call it first: `{value.name}(...)`"
    elif isinstance(value, Vector) and function.name in habits.OF_A_VECTOR and isinstance(site.function, tree.Name):
        ours, hint = habits.OF_A_VECTOR[function.name]
        edit = Edit(site.function.span, ours)
    elif isinstance(value, Scalar) and function.name in habits.OF_A_NUMBER and isinstance(site.function, tree.Name):
        ours, hint = habits.OF_A_NUMBER[function.name]
        edit = Edit(site.function.span, ours)
    elif isinstance(value, Vector) and declared[0].name in _NUMBERS:
        hint = f"a vector has three numbers: `{place.text}.x`, or `length({place.text})`"
    elif isinstance(value, Text) and declared[0].name in _NUMBERS and advice.is_number(value.value):
        hint, edit = "a number stands without quotes", Edit(place, value.value)
    elif declared[0].name == "vector" and (along := advice.axis(value, place)):
        hint, edit = f"a direction is a vector: write `{along}`", Edit(value_of(place), along)
    elif isinstance(value, ListValue) and len(value.items) == 2 and declared[0].name in ("vector", "point"):
        hint = "`[x, y, 0]` is one in the plane z = 0"
        message = message if not place.source.prelude else "a point in space has three coordinates, not two"
    elif code == "E060" and isinstance(value, Scalar) and not value.node.axes:
        hint = {"point": f"a point is `[{place.text}, 0, 0]`", "list": f"a list is `[{place.text}]`"}.get(
            declared[0].name, ""
        )
    ctx.error(
        code,
        message,
        place,
        label=f"this is {describe(value)}",
        others=others,
        hint=hint,
        edit=edit,
    )
    return None


def _contracts(
    ctx: Context,
    function: Function,
    bound: dict[str, Value],
    scope: Scope,
    kinds: dict[str, Kind],
    given: dict[str, Given],
    site: tree.Call,
) -> list[tuple[int, Node]] | None:
    """Contracts that only hold at points, to be attached to the result; None if one is broken for certain."""
    conditions: list[tuple[Node, str, str, tree.Parameter]] = []
    for p in function.parameters:
        kind = kinds.get(p.name)
        if kind is not None and kind.holds is not None:
            conditions.extend((c, text.format(p.name), p.name, p) for c, text in kind.holds(bound[p.name]))
        if p.where is None or p.name not in bound:
            continue
        condition = ctx.evaluate(p.where, scope)
        if isinstance(condition, Bool):
            conditions.append((condition.node, p.where.span.text, p.name, p))
        elif not isinstance(condition, Poison):
            ctx.error("E060", f"a contract is a condition, not {describe(condition)}", p.where.span)
    ensured: list[tuple[int, Node]] = []
    for condition_node, text, name, p in conditions:
        place = given[name].span if name in given else site.span
        others = () if p.span.source.prelude else (Label(p.span, "declared here"),)
        message = f"`{function.name}` needs {advice.in_words(text)}"
        if condition_node.stage is Stage.CONST:
            if ctx.constant(condition_node):
                continue
            value = bound[name]
            now = ctx.constant(value.node) if isinstance(value, Scalar) else None
            label = f"`{name}` is {now:g} here" if isinstance(now, float) else "this breaks it"
            hint, edit = advice.kept(function, text, name, place)
            ctx.error("E064", message, place, label=label, others=others, hint=hint, edit=edit)
            return None
        if condition_node.stage is Stage.UNIFORM:
            ctx.require(condition_node, message, place, others)
        else:
            told = "" if function.definition is None else function.definition.fact(f"Else {name}") or ""
            ensured.append((ctx.contract(message, place, others, told), condition_node))
    return ensured


def _list_form(function: Function, arguments: Sequence[Given]) -> Function:
    """The function that its documentation names for a list as the first argument, if that is what is given."""
    definition = function.definition
    if definition is None or not arguments or as_list(arguments[0].value) is None:
        return function
    if arguments[0].name not in (None, definition.parameters[0].name if definition.parameters else None):
        return function
    name = definition.fact("List form")
    other = function.scope.find(name) if name else None
    return other if isinstance(other, Function) else function


def _match(ctx: Context, function: Function, arguments: Sequence[Given], site: tree.Call) -> dict[str, Given] | None:
    """Arguments by parameter name; None (after a diagnostic) where they do not fit."""
    names = [p.name for p in function.parameters]
    if len(set(names)) < len(names):  # said where it is defined
        return None
    given: dict[str, Given] = {}
    second = {b.name for a, b in pairwise(function.parameters) if a.alternative is not None}
    in_order = [name for name in names if name not in second]  # of a pair `w or phase` the second is named
    position = 0
    for a in arguments:
        if a.name is None:
            if position >= len(in_order):
                _too_many(ctx, function.name, names, a.span, function.definition, advice.too_many(function, arguments))
                return None
            name = in_order[position]
            position += 1
        else:
            name = a.name
            if name not in names:
                _no_such_parameter(ctx, function.name, a, names, site)
                return None
        if name in given:
            ctx.error(
                "E042",
                f"`{name}` of `{function.name}` is given twice",
                a.span,
                label="given again here",
                others=(Label(given[name].span, "first given here"),),
            )
            return None
        given[name] = a
    for i, p in enumerate(function.parameters):
        if p.alternative is not None:
            other = function.parameters[i + 1]
            if p.name in given and other.name in given:
                ctx.error(
                    "E045",
                    f"`{function.name}` takes `{p.name}` or `{other.name}`, not both",
                    given[other.name].span,
                    label="the second",
                    others=(Label(given[p.name].span, "the first"),),
                )
                return None
            if p.name not in given and other.name not in given:
                _missing(ctx, function, f"`{p.name}` (or `{other.name}`)", site)
                return None
        elif p.default is None and p.name not in given:
            _missing(ctx, function, f"`{p.name}`", site)
            return None
    return given


def _missing(ctx: Context, function: Function, what: str, site: tree.Call) -> None:
    definition = function.definition
    others = _defined(definition)
    ctx.error(
        "E043",
        f"`{function.name}` needs {what}",
        site.span,
        label="an argument is missing here",
        others=others,
        hint=habits.FORMS.get((function.name, what.strip("`")), "") or f"it is called as `{signature(function)}`",
    )


def signature(function: Function) -> str:
    """How a function is called, as a line of text."""
    parts: list[str] = []
    for p in function.parameters:
        text = p.name if p.default is None else f"{p.name}={p.default.span.text}"
        if parts and parts[-1].endswith(" or"):
            parts[-1] += f" {p.name}"
        else:
            parts.append(text if p.alternative is None else f"{p.name} or")
    return f"{function.name}({', '.join(parts)})"


def _too_many(
    ctx: Context,
    name: str,
    names: Sequence[str],
    span: Span,
    definition: tree.Def | None,
    instead: tuple[str, Edit | None] = ("", None),
) -> Value:
    others = _defined(definition)
    count = len(names)
    return ctx.error(
        "E040",
        f"`{name}` takes {count} argument{'' if count == 1 else 's'}",
        span,
        others=others,
        label="one too many",
        hint=instead[0] or f"its parameters are {', '.join(names) or 'none'}",
        edit=instead[1],
    )


def _defined(definition: tree.Def | None) -> tuple[Label, ...]:
    """Where a function of the user's is defined; nothing for the prelude's."""
    if definition is None or definition.span.source.prelude:
        return ()
    return (Label(definition.name_span, "defined here"),)


def _no_such_parameter(ctx: Context, name: str, a: Given, names: Sequence[str], site: tree.Call | None = None) -> Value:
    word = a.name or ""
    spot = Span(a.span.source, a.span.start, a.span.start + len(word))
    hint, edit = advice.other_parameter(name, a, names, spot, site)
    return ctx.error(
        "E041", f"`{name}` has no parameter `{word}`", spot, label="no such parameter", hint=hint, edit=edit
    )
