"""What a value is, in a few words: a number with its unit, a field with its range and steepness, a function with what
it takes."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass

import numpy as np

from porelang.analysis.sampled import Points, about_the_origin, inside_of, sampler
from porelang.diagnostics import PoreError
from porelang.elaborate.values import Bool, Builtin, Function, Record, Scalar, Value, Vector, describe
from porelang.formula import Bindings
from porelang.ir import TASKS, Node, Stage, node, order, param
from porelang.program import Design
from porelang.progress import CancelledError, watching
from porelang.rewrites import flatten
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

    def place(self, argument: int) -> int:
        """Where among the parameters the argument at a position stands: of a pair `w or phase` the second is named."""
        in_order = [i for i in range(len(self.parameters)) if i == 0 or not self.parameters[i - 1].instead]
        return in_order[argument] if argument < len(in_order) else max(argument, len(self.parameters))


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


def told(value: Value, design: Design | None, part: bool = True, seconds: float = 0.0) -> list[str]:
    """What a value is, a line each: what kind, its number, with its error where it was found from fields; or how far a
    field reaches and how steep it is, where samples see it.

    `design` has the params, and `part` says to look at fields within its part. What tasks have to find may take so many
    seconds; what takes longer is left to who asks for it.
    """
    match value:
        case Scalar() if value.node.stage is Stage.FIELD:
            return _field(value, design, part, seconds)
        case Scalar():
            known = number_of(value, design, seconds)
            if known is None:
                return [f"{describe(value)}: found when it is asked for"]
            return [f"{describe(value)}: {known}{_when(value.node, design)}"]
        case Vector():
            if any(n.axes for n in value.nodes):
                return [f"{describe(value)} that varies in space"]
            parts = [number_of(Scalar(n, value.dimension), design, seconds) for n in value.nodes]
            known = None if None in parts else f"[{', '.join(p for p in parts if p is not None)}]"
            return [describe(value) if known is None else f"{describe(value)}: {known}"]
        case Bool():
            known = number_of(Scalar(value.node), design, seconds)
            return [describe(value) if known is None else f"a condition: {'true' if float(known) else 'false'}"]
        case Record():
            return [f"{describe(value)}: {', '.join(n for n in value.members if not n.startswith('_'))}"]
    return [describe(value)]


def number_of(value: Value | None, design: Design | None, seconds: float = 0.0) -> str | None:
    """A value that is one number, with its unit and the error of what was found for it; None of what is none, and of
    what tasks do not find in so many seconds."""
    if not isinstance(value, Scalar) or value.node.axes:
        return None
    (flat,) = flatten(value.node)
    unit = _unit(value)
    if not any(n.op in TASKS for n in order([flat])):
        at = sampler([flat], _settings(design))
        return None if at is None else f"{at(np.zeros((1, 3)))[0][0]:.6g}{unit}"
    if design is None or not seconds:
        return None
    with _within(seconds), suppress(CancelledError, PoreError):
        found = design.valued(flat)
        return f"{found.value:.6g}{unit}" + (f" +- {found.error:.2g}{unit}" if found.error else "")
    return None


def _when(n: Node, design: Design | None) -> str:
    if n.stage is Stage.CONST or design is None or not design.settings:
        return ""
    infos = design.program.params
    at_defaults = all(value == infos[name].default for name, value in design.settings.items())
    return f" with the params {'at their defaults' if at_defaults else 'as they are set'}"


def _settings(design: Design | None) -> Bindings:
    return {} if design is None else {param(name): value for name, value in design.settings.items()}


@contextmanager
def _within(seconds: float) -> Iterator[None]:
    """While this lasts, work ends itself after so many seconds."""
    end = time.monotonic() + seconds
    with watching(cancel=lambda: time.monotonic() > end):
        yield


def _unit(value: Scalar | Vector) -> str:
    dimension = value.dimension
    return "" if dimension is None or dimension.unit == "1" else dimension.called


def _field(value: Scalar, design: Design | None, part: bool, seconds: float) -> list[str]:
    unit, what = _unit(value), describe(value)
    roots = [value.node, *(node("d", value.node, value=axis) for axis in range(3))]
    bindings: Bindings = _settings(design)
    if design is not None and seconds:
        with _within(seconds), suppress(CancelledError, PoreError):
            bindings = design.formula(*flatten(*roots)).bindings
    at = sampler(roots, bindings)
    if at is None:
        return [what, "what it reads is found when it is asked for"]
    inside = _inside(design, bindings) if part else None
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


def _inside(design: Design | None, bindings: Bindings) -> Points | None:
    """Points in the part of a design; None where samples find none."""
    if design is None:
        return None
    try:
        root = design.program.solid(None)
    except PoreError:
        return None
    with np.errstate(all="ignore"):
        points = inside_of(root, bindings)
    return points if points is not None and len(points) else None
