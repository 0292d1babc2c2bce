"""Arguments of calls that ask for a task: what each has to be, and what is said of what is not that."""

from __future__ import annotations

import os

from porelang.elaborate import operators
from porelang.elaborate.context import Context
from porelang.elaborate.values import ABSENT, Bool, Function, Scalar, Text, Value, describe
from porelang.ir import Node, Stage, X, Y, Z, node
from porelang.source import Span
from porelang.syntax import tree
from porelang.units import LENGTH

_HERE = (X, Y, Z)


def field(ctx: Context, value: Value, place: Span, of: str) -> Scalar | None:
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


def text(ctx: Context, value: Value, place: Span, what: str, example: str = "stress.npz") -> str | None:
    if isinstance(value, Text):
        if not value.value:
            ctx.error("E060", f"{what} is an empty text", place, hint=f'as in "{example}"')
        return value.value or None
    ctx.error("E060", f"{what} is a text, not {describe(value)}", place, label=f"this is {describe(value)}",
              hint=f'write it in quotes: "{example}"')  # fmt: skip
    return None


def beside(site: tree.Call, path: str, ctx: Context) -> tuple[str, str]:
    """The path of a file that a program names: beside the program, unless it begins at the root. As a person would
    write it from where the program was named, and whole: a program means the same wherever it is used from then on."""
    shown = os.path.normpath(os.path.join(os.path.dirname(ctx.users_place(site.span).source.name), path))
    return shown, os.path.normpath(os.path.join(ctx.folder, shown))


def looked_up(grid: Node, component: int, smooth: bool, outside: Node | None) -> Node:
    """The field of a component of a grid."""
    found = node("lookup_cubic" if smooth else "lookup", grid, *_HERE, value=(component, 0, 0, 0))
    return found if outside is None else node("select", node("covers", grid, *_HERE), found, outside)


def flag(ctx: Context, value: Value, place: Span, name: str) -> bool | None:
    """Whether something that is false where it is left out is to be; None after saying that this is no answer."""
    if value is ABSENT:
        return False
    known = ctx.constant(value.node) if isinstance(value, Bool) else None
    if isinstance(known, bool):
        return known
    ctx.error("E060", f"`{name}` is true or false", place, label=f"this is {describe(value)}")
    return None


def length_now(ctx: Context, value: Value, place: Span, what: str, code: str = "E152") -> float | None:
    """A length above 0 that is known now, 0 where it is not given; None after saying what is wrong with it: one that is
    not above 0 by a `code` of the task's own."""
    if value is ABSENT:
        return 0.0
    if isinstance(value, Scalar) and value.dimension not in (None, LENGTH):
        ctx.error("E062", f"{what} is a length, not {value.dimension}", place)
        return None
    known = ctx.need_constant(value, place, what)
    if known is not None and not known > 0:
        ctx.error(code, f"{what} is a length above 0", place, label=f"this is {known:g} mm", hint="as in 0.5mm")
        return None
    return known


def uniform_length(ctx: Context, value: Value, place: Span, what: str) -> Scalar | None:
    """A length above 0 that is the same everywhere; None after saying what is wrong with it."""
    found = field(ctx, value, place, what)
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
