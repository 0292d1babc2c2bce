"""What a value is, in a few words: a number with its unit, a field with its range and steepness, a function with what
it takes."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from porelang.analysis.sampled import Points, about_the_origin, inside_of, sampler
from porelang.diagnostics import PoreError
from porelang.elaborate.values import Bool, Builtin, Function, Record, Scalar, Text, Value, Vector, describe
from porelang.formula import Bindings
from porelang.ir import Node, Stage, node, param
from porelang.program import Program
from porelang.syntax import tree

#: Lines of documentation that tools read; who writes a program is told what the call gives by the call.
_FACTS = re.compile(
    r"^(Gives|Modifies|Stretches|Fits|Copies|Closes|Adds|Rounds|Rod|Follows|Folds|List form|Else \w+):.*$", re.MULTILINE
)
_EXAMPLE = re.compile(r"^Example:\s*(.*)$", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter as it is declared, and its name; `instead` of it the next may be given."""

    name: str
    text: str
    instead: bool = False


@dataclass(frozen=True, slots=True)
class Signature:
    """How a function is called, and what it does."""

    name: str
    parameters: tuple[Parameter, ...]
    doc: str
    example: str = ""

    def __str__(self) -> str:
        joined = ""
        for i, p in enumerate(self.parameters):
            joined += ("" if i == 0 else " or " if self.parameters[i - 1].instead else ", ") + p.text
        return f"{self.name}({joined})"


def signature(function: Value | tree.Def | None, name: str) -> Signature | None:
    """How a function is called; None of what is none."""
    if isinstance(function, Function):
        definition = function.definition
        return _signature(name, function.parameters, definition.doc if definition is not None else "")
    if isinstance(function, tree.Def):
        return _signature(name, function.parameters, function.doc)
    if isinstance(function, Builtin):
        return Signature(name, tuple(Parameter(p, p) for p in function.signature), function.doc)
    return None


def _signature(name: str, parameters: tuple[tree.Parameter, ...], doc: str) -> Signature:
    texts = [" ".join(p.span.text.split()) for p in parameters]
    said = tuple(Parameter(p.name, text, p.alternative is not None) for p, text in zip(parameters, texts, strict=True))
    example = _EXAMPLE.search(doc)
    text = _FACTS.sub("", _EXAMPLE.sub("", doc))
    return Signature(name, said, re.sub(r"\n{2,}", "\n", text).strip(), example[1].strip() if example else "")


def number(n: Node, unit: str, bindings: Bindings) -> str | None:
    """The value of a node that is the same everywhere, with its unit; None where tasks have yet to find it."""
    at = None if n.axes else sampler([n], bindings)
    if at is None:
        return None
    value = at(np.zeros((1, 3)))[0][0]
    return f"{value:.6g}{unit}"


def told(
    value: Value, program: Program | None, part: bool = True, settings: Mapping[str, float] | None = None
) -> list[str]:
    """What a value is, a line each: what kind, its number with the params at their defaults, or how far a field reaches
    and how steep it is, where samples see it. `program` has the params; `part` looks at fields within its part;
    `settings` are the params that are set, in base units."""
    bindings = {**_defaults(program), **{param(name): number for name, number in (settings or {}).items()}}
    match value:
        case Scalar():
            return _scalar(value, program, bindings, part, settings is not None)
        case Vector():
            unit = _unit(value)
            parts = [number(n, unit, bindings) for n in value.nodes]
            if all(p is not None for p in parts):
                return [f"{describe(value)}: [{', '.join(p for p in parts if p is not None)}]"]
            return [f"{describe(value)} that varies in space" if any(n.axes for n in value.nodes) else describe(value)]
        case Bool():
            known = number(value.node, "", bindings)
            return [describe(value) if known is None else f"a condition: {'true' if float(known) else 'false'}"]
        case Text():
            return [describe(value)]
        case Record():
            return [f"{describe(value)}: {', '.join(n for n in value.members if not n.startswith('_'))}"]
    return [describe(value)]


def _defaults(program: Program | None) -> Bindings:
    return {} if program is None else {param(name): info.default for name, info in program.params.items()}


def _unit(value: Scalar | Vector) -> str:
    dimension = value.dimension
    return "" if dimension is None or dimension.unit == "1" else dimension.called


def _scalar(value: Scalar, program: Program | None, bindings: Bindings, part: bool, are_set: bool) -> list[str]:
    unit, what = _unit(value), describe(value)
    if value.node.stage is not Stage.FIELD:
        known = number(value.node, unit, bindings)
        how = "as they are set" if are_set else "at their defaults"
        when = "" if value.node.stage is Stage.CONST else f" with the params {how}"
        return [f"{what}: found when it is asked for" if known is None else f"{what}: {known}{when}"]
    slopes = [node("d", value.node, value=axis) for axis in range(3)]
    at = sampler([value.node, *slopes], bindings)
    if at is None:
        return [what, "what it reads is found when it is asked for"]
    inside = _inside(program, bindings) if part else None
    points = about_the_origin() if inside is None else inside
    values, *rise = (np.asarray(v) for v in at(points))
    steep = np.sqrt(sum(s * s for s in rise))
    if not np.isfinite(values).any():
        return [what, "it has no value where it was looked at"]
    where = "within 256 mm of the origin" if inside is None else "in the part"
    low, high = np.nanmin(values), np.nanmax(values)
    lines = [what, f"{low:.4g}{unit} to {high:.4g}{unit} {where}, as samples show"]
    if np.isfinite(steep).any():
        lines.append(f"it rises by {np.nanmedian(steep):.3g}{unit} in each mm, {np.nanmax(steep):.3g}{unit} at most")
    return lines


def number_of(value: Value | None, program: Program | None) -> str | None:
    """A value that is one number, with its unit, with the params at their defaults; None of what is none, and of what
    tasks have yet to find."""
    if not isinstance(value, Scalar) or value.node.axes:
        return None
    return number(value.node, _unit(value), _defaults(program))


def _inside(program: Program | None, bindings: Bindings) -> Points | None:
    """Points in the part of a program; None where samples find none."""
    if program is None:
        return None
    try:
        root = program.solid(None)
    except PoreError:
        return None
    with np.errstate(all="ignore"):
        points = inside_of(root, bindings)
    return points if points is not None and len(points) else None
