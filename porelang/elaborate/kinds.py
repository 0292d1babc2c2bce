"""The kinds a parameter of a def can declare, as one table."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from porelang import units
from porelang.diagnostics import Edit, Label, suggest
from porelang.elaborate.context import Context
from porelang.elaborate.values import (
    Bool,
    Builtin,
    Choice,
    Function,
    ListValue,
    Scalar,
    Text,
    Value,
    Vector,
    as_list,
    as_vector,
)
from porelang.ir import ZERO, Node, node
from porelang.source import Span
from porelang.syntax import tree
from porelang.units import Dimension


@dataclass(frozen=True, slots=True)
class Kind:
    """A declared kind: how it is called in a message, what fits it, and what else must hold.

    `coerce` returns the value as that kind, or None. `holds` gives conditions that must be true of it. A `constant` is
    known when the program is compiled; a `whole` number may come from found numbers and params of any kind, but a param
    of whole numbers is structural there.
    """

    name: str
    words: str
    doc: str
    coerce: Callable[[Value], Value | None]
    holds: Callable[[Value], Sequence[tuple[Node, str]]] | None = None
    constant: bool = False
    whole: bool = False


def _number(*dimensions: Dimension) -> Callable[[Value], Value | None]:
    def coerce(value: Value) -> Value | None:
        if not isinstance(value, Scalar):
            return None
        if not dimensions or value.dimension is None:
            return Scalar(value.node, value.dimension or (dimensions[0] if dimensions else None))
        return value if value.dimension in dimensions else None

    return coerce


def _bare(*dimensions: Dimension) -> Callable[[Value], Value | None]:
    """A number of one of these dimensions that counts as bare inside."""

    def coerce(value: Value) -> Value | None:
        if isinstance(value, Scalar) and (value.dimension is None or value.dimension in dimensions):
            return Scalar(value.node)
        return None

    return coerce


def _vector(*dimensions: Dimension) -> Callable[[Value], Value | None]:
    def coerce(value: Value) -> Value | None:
        vector = as_vector(value)
        if vector is None or not dimensions:
            return vector
        return vector if vector.dimension is None or vector.dimension in dimensions else None

    return coerce


def _period(value: Value) -> Value | None:
    coerced = _bare(units.LENGTH)(value)
    if coerced is not None:
        return coerced
    vector = _vector(units.LENGTH)(value)
    return Vector(*vector.nodes) if isinstance(vector, Vector) else None


def _positive(value: Value) -> list[tuple[Node, str]]:
    if isinstance(value, Scalar):
        return [(node("lt", ZERO, value.node), "{0} > 0")]
    if isinstance(value, Vector):
        return [(node("lt", ZERO, n), f"{{0}}.{axis} > 0") for n, axis in zip(value.nodes, "xyz", strict=True)]
    return []


def _whole(value: Value) -> list[tuple[Node, str]]:
    if not isinstance(value, Scalar):
        return []
    n = value.node
    return [(node("eq", node("floor", n), n), "{0} is a whole number"), (node("le", ZERO, n), "{0} >= 0")]


def _one_of(*types: type) -> Callable[[Value], Value | None]:
    return lambda value: value if isinstance(value, types) else None


def _list(value: Value) -> Value | None:
    items = as_list(value)
    return None if items is None else ListValue(items)


KINDS = {
    k.name: k
    for k in (
        Kind("number", "a number", "any number", _number()),
        Kind("field", "a field", "any number, usually one that varies in space", _number()),
        Kind("solid", "a solid", "a field that is negative in the material", _number()),
        Kind("ratio", "a plain number", "a number without a dimension", _number(units.RATIO)),
        Kind("length", "a length", "a number of mm", _number(units.LENGTH)),
        Kind("angle", "an angle", "a number of radians", _number(units.ANGLE)),
        Kind("force", "a force", "a number of N", _number(units.FORCE)),
        Kind("stress", "a stress", "a number of MPa", _number(units.STRESS)),
        Kind("rate", "an angle per length", "a number of rad/mm", _number(units.ANGLE / units.LENGTH)),
        Kind("vector", "a vector", "three numbers", _vector()),
        Kind("point", "a point", "three lengths", _vector(units.LENGTH)),
        Kind("period", "a period", "a length, or three, greater than 0; bare inside the def", _period, _positive),
        Kind("size", "a size", "a length greater than 0; bare inside the def", _bare(units.LENGTH), _positive),
        Kind("count", "a count", "a whole number, known when the program is compiled", _number(units.RATIO), _whole,
             constant=True),
        Kind("whole", "a whole number", "a whole number, 0 or more", _number(units.RATIO), _whole, whole=True),
        Kind("bool", "a condition", "true or false", _one_of(Bool)),
        Kind("string", "a text", "a text", _one_of(Text)),
        Kind("list", "a list", "a list, or a vector as a list of three", _list),
        Kind("any", "anything", "whatever it is", lambda value: value),
        Kind("function", "a function", "a def, a lambda or a lattice", _one_of(Function, Builtin, Choice)),
    )
}  # fmt: skip


def check_kinds(ctx: Context, definition: tree.Def) -> None:
    """Report parameters of a def that are bound twice, and declared kinds that do not exist."""
    first: dict[str, Span] = {}
    for p in definition.parameters:
        if p.name in first:
            ctx.error(
                "E031",
                f"the parameter `{p.name}` is bound twice",
                p.name_span,
                label="bound again here",
                others=(Label(first[p.name], "first bound here"),),
                hint="give one of them another name",
            )
        first.setdefault(p.name, p.name_span)
        for k in p.kinds:
            if k.name not in KINDS:
                near = suggest(k.name, KINDS)
                ctx.error(
                    "E034",
                    f"there is no kind `{k.name}`",
                    k.span,
                    label="not a kind of value",
                    hint=f"did you mean `{near}`?" if near else f"the kinds are {', '.join(KINDS)}",
                    edit=Edit(k.span, near) if near else None,
                )
