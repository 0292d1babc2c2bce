"""The notation of the paper (section 2.3) for each modification in a program.

(input fields)(modifiers)(dimension)(result): F a field, C a constant or param, V a vector field, L a local frame; the
dimensions are T type, S space, W wavelength, D distance, R ratio.

M. Bernhard et al., Performative Porosity.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from porelang.elaborate.values import Scalar, Value, as_vector, stage
from porelang.ir import Stage
from porelang.program import Program
from porelang.source import Span

DIMENSIONS = {"T": "type", "S": "space", "W": "wavelength", "D": "distance", "R": "ratio"}


@dataclass(frozen=True, slots=True)
class Modification:
    """A function of the prelude as the paper sees it.

    `modifier` is the argument that modifies (of several, the first that was given); `letter` is its letter where that
    does not follow from the argument; `fields` is the number of input fields.
    """

    dimension: str
    modifier: tuple[str, ...]
    fields: int = 1
    letter: str = ""


MODIFICATIONS: dict[str, Modification] = {
    "orient": Modification("S", ("xaxis",), letter="L"),
    "rotate": Modification("S", ("angle",), letter="L"),
    "translate": Modification("S", ("v",), letter="L"),
    "scale": Modification("S", ("s",), letter="L"),
    "mirror": Modification("S", ("normal",), letter="L"),
    "thicken": Modification("D", ("b",)),
    "offset": Modification("D", ("d",)),
    "shell": Modification("D", ("t",)),
    "multishell": Modification("D", ("t",)),
    "polar": Modification("S", ("turn",), letter="V"),
    "spherical": Modification("S", ("turn",), letter="V"),
    "align": Modification("S", ("v",), letter="V"),
    "twist": Modification("S", ("rate",)),
    "morph": Modification("R", ("f",), fields=2),
    "blend": Modification("R", ("along",), fields=2),
}
#: A lattice is what has a phase, be it given or computed from the period.
LATTICE = Modification("W", ("w", "phase"))


@dataclass(frozen=True, slots=True)
class Step:
    """A modification of a program: its text, its place, and what the paper writes for it."""

    text: str
    span: Span
    notation: str
    dimension: str


def steps(program: Program) -> list[Step]:
    """The modifications of a program, in the order of evaluation."""
    found = [
        Step(info.span.text, info.span, "(F)(C)(T)(F)", DIMENSIONS["T"])
        for info in program.params.values()
        if info.choices and not info.numbers
    ]
    for call in program.elaborated.calls:
        known = LATTICE if "phase" in call.arguments else MODIFICATIONS.get(call.name)
        if known is not None:
            text = " ".join(call.span.text.split())
            found.append(Step(text, call.span, notation(known, call.arguments), DIMENSIONS[known.dimension]))
    return found


def notation(known: Modification, arguments: Mapping[str, Value]) -> str:
    """What the paper writes for a modification with these arguments."""
    value = next(arguments[m] for m in known.modifier if m in arguments)
    letter = known.letter or _letter(value)
    if known.fields == 2:
        return f"(F_A, F_B)({'F_C' if letter == 'F' else letter})({known.dimension})(F_R)"
    if known.dimension == "D" and "b" in arguments and letter == "F":
        return f"(F_A)(F_B)({known.dimension})(F)"
    return f"(F)({letter})({known.dimension})(F)"


def _letter(value: Value) -> str:
    """A field, a vector field, a constant, or three of them, one for each axis."""
    vector = as_vector(value)
    if vector is not None:
        if stage(vector) is Stage.FIELD:
            return "V"
        return "C_X, C_Y, C_Z"
    return "F" if isinstance(value, Scalar) and stage(value) is Stage.FIELD else "C"
