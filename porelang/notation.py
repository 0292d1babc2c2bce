"""The notation of the paper (section 2.3) for each modification in a program.

(input fields)(modifiers)(dimension)(result): F a field, C a constant or param, V a vector field, L a local frame; the
dimensions are T type, S space, W wavelength, D distance, R ratio. What a function modifies is said beside it, in a
line of its documentation; here are the rules of the notation alone.

    ## Modifies: space by angle, as a local frame
    def rotate(f: field, axis: vector, angle: angle) = ...

After `Modifies:` come the dimension and the argument that modifies it (of several, `w or phase`, the first that is
given); `as` says what it amounts to where its own value does not show it.

M. Bernhard et al., Performative Porosity.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from porelang.diagnostics import fail, suggest
from porelang.elaborate.values import Scalar, Value, Vector, as_vector, stage
from porelang.ir import Node, Stage, X, Y, Z, node
from porelang.program import Program
from porelang.source import Span
from porelang.syntax import tree

DIMENSIONS = {"type": "T", "space": "S", "wavelength": "W", "distance": "D", "ratio": "R"}
LETTERS = {"a local frame": "L", "a vector field": "V"}
_FACT = re.compile(rf"({'|'.join(DIMENSIONS)}) by (\w+(?: or \w+)*)(?:, as ({'|'.join(LETTERS)}))?")


@dataclass(frozen=True, slots=True)
class Modification:
    """What a function modifies: a dimension, by one of these parameters, which counts as a `letter` if that is given.

    `dimension` and `letter` are those of the notation.
    """

    dimension: str
    modifiers: tuple[tree.Parameter, ...]
    letter: str = ""


@dataclass(frozen=True, slots=True)
class Step:
    """A modification of a program: its text, its place, and what the paper writes for it."""

    text: str
    span: Span
    notation: str
    dimension: str


def steps(program: Program) -> list[Step]:
    """The modifications of a program, in the order of evaluation.

    Errors: E116 where the documentation of a function in use has a `Modifies:` line that does not read.
    """
    found = [
        Step(info.span.text, info.span, "(F)(C)(T)(F)", "type")
        for info in program.params.values()
        if info.choices and not info.numbers
    ]
    names = {letter: word for word, letter in DIMENSIONS.items()}
    for call in program.elaborated.calls:
        known = modification(call.definition) if call.definition is not None else None
        if known is not None:
            text = " ".join(call.span.text.split())
            found.append(Step(text, call.span, notation(known, call.arguments), names[known.dimension]))
    return found


def modification(definition: tree.Def) -> Modification | None:
    """What a def modifies by the `Modifies:` line of its documentation; None if it has none.

    Errors: E116 where the line does not read, or names a parameter that the def has not.
    """
    text = definition.fact("Modifies")
    if text is None:
        return None
    fact = _FACT.fullmatch(text)
    label = f"its documentation says `Modifies: {text}`"
    if fact is None:
        raise fail(
            "E116",
            f"what `{definition.name}` modifies does not read",
            definition.name_span,
            label=label,
            hint="write `## Modifies: DIMENSION by PARAMETER`, the dimension one of " + ", ".join(DIMENSIONS),
        )
    parameters = {p.name: p for p in definition.parameters}
    names = fact[2].split(" or ")
    for name in names:
        if name not in parameters:
            near = suggest(name, parameters)
            raise fail(
                "E116",
                f"`{definition.name}` has no parameter `{name}` to modify by",
                definition.name_span,
                label=label,
                hint=f"did you mean `{near}`?" if near else f"its parameters are {', '.join(parameters) or 'none'}",
            )
    return Modification(DIMENSIONS[fact[1]], tuple(parameters[n] for n in names), LETTERS.get(fact[3], ""))


def notation(known: Modification, arguments: Mapping[str, Value]) -> str:
    """What the paper writes for a modification with these arguments."""
    modifier = next((p for p in known.modifiers if p.name in arguments), known.modifiers[0])
    letter = known.letter or _letter(arguments.get(modifier.name))
    if known.dimension == "R":  # a ratio is one of two fields
        return f"(F_A, F_B)({'F_C' if letter == 'F' else letter})(R)(F_R)"
    added = any(kind.name == "field" for kind in modifier.kinds)
    if known.dimension == "D" and letter == "F" and added:  # one field to the other
        return "(F_A)(F_B)(D)(F)"
    return f"(F)({letter})({known.dimension})(F)"


def _letter(value: Value | None) -> str:
    """A field, a vector field, a constant, or three of them, one for each axis."""
    if value is None:
        return "C"
    vector = as_vector(value)
    if vector is not None and (w := _divisor(vector)) is not None:  # the phase p / w is the period w
        return "F" if w.axes else "C"
    if vector is not None:
        if stage(vector) is Stage.FIELD:
            return "V"
        return "C_X, C_Y, C_Z"
    return "F" if isinstance(value, Scalar) and stage(value) is Stage.FIELD else "C"


def _divisor(phase: Vector) -> Node | None:
    """The number or field by which the place is divided in a vector; None where it is no such vector."""
    w = phase.x.args[1] if phase.x.op == "div" else None
    return w if w is not None and phase.nodes == tuple(node("div", c, w) for c in (X, Y, Z)) else None
