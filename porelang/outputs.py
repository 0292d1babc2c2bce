"""The outputs of a program by their names: which one is meant, and what to say of one that it is not."""

from __future__ import annotations

from porelang.diagnostics import PoreError, fail, suggest
from porelang.elaborate.results import Elaborated, Output
from porelang.elaborate.values import Scalar, Vector
from porelang.source import Source, Span


def chosen(found: Elaborated, source: Source, name: str | None = None) -> str:
    """The name of an output: the one asked for, else `part`, else the only one. Errors: E100."""
    outputs = found.outputs
    if name is None:
        if "part" in outputs:
            return "part"
        if len(outputs) == 1:
            return next(iter(outputs))
        if not outputs:
            hint = "end it with an expression, or write `out part = ...`"
            raise fail("E100", "the program has no output", Span(source, 0, 0), hint=hint)
        hint = f"choose one of {', '.join(outputs)} with --out NAME"
        raise fail("E100", "the program has several outputs, and none is called `part`", hint=hint)
    if not isinstance(name, str):
        raise fail("E100", f"{name!r:.60} is no name of an output", hint='it is a text, as in "part"')
    if name not in outputs:
        near = suggest(name, outputs)
        hint = f"did you mean `{near}`?" if near else f"it has {', '.join(outputs) or 'none'}"
        if name in found.lets:
            hint = f"`{name}` is a let: `out {name}_ = {name}` makes an output of it"
        raise fail("E100", f"the program has no output `{name}`", hint=hint)
    return name


def must_be_solid(output: Output, name: str) -> None:
    """Refuse an output that has no surface. Errors: E101."""
    if not isinstance(output.value, Scalar):
        what = "a vector" if isinstance(output.value, Vector) else "a condition"
        hint = "a solid is a number that is negative inside"
        raise fail("E101", f"the output `{name}` is {what}, which has no surface", output.span, hint=hint)


def no_number(found: Elaborated, name: str) -> PoreError:
    """What is wrong with a name of neither an output nor a `let` that is a number: E100."""
    known = [*found.outputs, *found.lets]
    near = suggest(name, known)
    hint = f"did you mean `{near}`?" if near else f"it has {', '.join(known) or 'none'}"
    return fail("E100", f"the program has no output and no number called `{name}`", hint=hint)
