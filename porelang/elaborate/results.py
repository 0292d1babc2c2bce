"""What elaboration finds out about a program, as data: its params, outputs, checks, contracts and calls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from porelang.diagnostics import Diagnostic, Label
from porelang.elaborate.values import Bool, Scalar, Value, Vector
from porelang.ir import Node
from porelang.source import Span
from porelang.syntax import tree
from porelang.units import Dimension


@dataclass(frozen=True, slots=True)
class ParamInfo:
    """A param: its default and range in base units, or the labels of its choices (its number is then the index).

    `numbers` holds the values of a choice among numbers: they are set by value, not by index.
    """

    name: str
    default: float
    low: float
    high: float
    step: float | None
    choices: tuple[str, ...]
    numbers: tuple[float, ...]
    dimension: Dimension | None
    doc: str
    span: Span

    @property
    def unit(self) -> str:
        """The base unit its number is in, or nothing; a ratio has none, not the unit 1."""
        return "" if self.dimension is None or self.dimension.unit == "1" else self.dimension.unit

    def shown(self, value: float) -> str:
        """A value as a user would write it."""
        return self.choices[int(value)] if self.choices and not self.numbers else f"{value:g}{self.unit}"


@dataclass(frozen=True, slots=True)
class Output:
    """A named result: its value (a number, a vector or a condition) and where it is written."""

    name: str
    value: Scalar | Vector | Bool
    span: Span


@dataclass(frozen=True, slots=True)
class Requirement:
    """A condition over params that must hold for every setting, or (a `check`) for the one in use."""

    condition: Node
    message: str
    span: Span
    others: tuple[Label, ...] = ()


@dataclass(frozen=True, slots=True)
class CallRecord:
    """A call that the user wrote: the function's name and definition, its arguments by parameter, and the place.

    `definition` is None for a lambda.
    """

    name: str
    definition: tree.Def | None
    arguments: Mapping[str, Value]
    span: Span


@dataclass(slots=True)
class Elaborated:
    """All that elaboration finds out about a program."""

    params: dict[str, ParamInfo] = field(default_factory=dict)
    outputs: dict[str, Output] = field(default_factory=dict)
    lets: dict[str, Scalar] = field(default_factory=dict)
    checks: list[Requirement] = field(default_factory=list)
    requirements: list[Requirement] = field(default_factory=list)
    contracts: list[Requirement] = field(default_factory=list)
    calls: list[CallRecord] = field(default_factory=list)
    reductions: dict[str, Span] = field(default_factory=dict)
    diagnostics: list[Diagnostic] = field(default_factory=list)


def roots_of(outputs: Mapping[str, Output]) -> dict[str, Node]:
    """The graph's roots: an output's node, or three for a vector (`name.x`, `name.y`, `name.z`)."""
    roots: dict[str, Node] = {}
    for name, o in outputs.items():
        if isinstance(o.value, Vector):
            roots |= {f"{name}.{axis}": n for axis, n in zip("xyz", o.value.nodes, strict=True)}
        else:
            roots[name] = o.value.node
    return roots
