"""A param that is bound to an array of a file: the `load` that reads it, as if that were its default.

What the default says of its file (its unit, how it is sampled, what holds outside) is said of this one too, unless the
binding says something else.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import fields, is_dataclass

from porelang.elaborate import names
from porelang.elaborate.context import Context
from porelang.elaborate.values import POISON, Scope, Value
from porelang.ops import TASK_TABLE
from porelang.source import Source, Span
from porelang.syntax import tree
from porelang.syntax.parse import parse
from porelang.units import UNITS

_CALLED = {1: "load", 3: "load_vector", 6: "load_tensor"}


def loaded(ctx: Context, s: tree.Param, name: str, components: int, payload: list[str], scope: Scope) -> Value:
    """What is read for a param of so many numbers in each place; `payload` is a file, an array, options."""
    file, array, options = payload
    called = _CALLED[components]
    words = [
        json.dumps(file, ensure_ascii=False),
        json.dumps(array, ensure_ascii=False),
        *([options] if options else []),
    ]
    read, wrong = parse(Source(f"--bind {name}", f"{called}({', '.join(words)})"))
    _, unknown = names.resolve(read.statements, names.LOADING)
    if wrong or unknown:
        ctx.found.diagnostics += [*wrong, *unknown]
        return POISON
    call = read.statements[0].value if len(read.statements) == 1 and isinstance(read.statements[0], tree.Out) else None
    if not isinstance(call, tree.Call):
        return ctx.error("E155", f"`{name}` cannot be bound with `{options}`", s.name_span, label="declared here",
                         hint=f"as in --bind {name}=FILE:ARRAY,unit=Pa,lengths=m")  # fmt: skip
    said = {a.name for a in call.arguments}
    more = [a for a in _options_of(s.default) if a.name not in said]
    return ctx.evaluate(tree.Call(call.span, call.function, (*call.arguments, *more)), scope)


def _options_of(default: tree.Expr) -> list[tree.Argument]:
    """What a default says of how a file is read: that of the first call that loads one, else the unit of its number."""
    parts = list(_within(default))
    for part in parts:
        if isinstance(part, tree.Call) and isinstance(part.function, tree.Name) and part.function.name in names.LOADING:
            row = TASK_TABLE["load"].parameters
            named = [(a.name or row[i], a) for i, a in enumerate(part.arguments) if a.name or i < len(row)]
            return [tree.Argument(a.span, n, a.value) for n, a in named if n not in ("path", "name")]
    unit = next((part for part in parts if isinstance(part, tree.Number) and part.unit), None)
    if unit is None or UNITS[unit.unit].scale == 1:
        return []
    return [tree.Argument(unit.span, "unit", tree.Text(unit.span, unit.unit))]


def _within(item: object) -> Iterator[object]:
    """An expression and all that it is made of."""
    yield item
    if is_dataclass(item) and not isinstance(item, Span):
        for part in (getattr(item, f.name) for f in fields(item)):
            for one in part if isinstance(part, tuple) else (part,):
                yield from _within(one) if is_dataclass(one) and not isinstance(one, Span) else ()
