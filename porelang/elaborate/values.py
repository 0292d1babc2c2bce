"""What an expression can mean while a program is compiled; only numbers and conditions reach the graph."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from porelang.ir import Node, Stage
from porelang.source import Span
from porelang.syntax import tree
from porelang.units import Dimension


@dataclass(frozen=True, slots=True)
class Scalar:
    """A number of any stage. `dimension` is None where it is not known; `literal` marks a bare number as written."""

    node: Node
    dimension: Dimension | None = None
    literal: bool = False


@dataclass(frozen=True, slots=True)
class Vector:
    """Three numbers of one dimension."""

    x: Node
    y: Node
    z: Node
    dimension: Dimension | None = None

    @property
    def nodes(self) -> tuple[Node, Node, Node]:
        return (self.x, self.y, self.z)


#: The components of a symmetric tensor, in VTK's order.
TENSOR = ("xx", "yy", "zz", "xy", "yz", "xz")


@dataclass(frozen=True, slots=True)
class Bool:
    """A condition of any stage."""

    node: Node


@dataclass(frozen=True, slots=True)
class Text:
    value: str


@dataclass(frozen=True, slots=True)
class ListValue:
    items: tuple[Value, ...]


@dataclass(frozen=True, slots=True)
class Range:
    """`lo..hi` as an argument: where `solve` looks."""

    low: Scalar
    high: Scalar


@dataclass(frozen=True, slots=True, eq=False)
class Function:
    """A def or a lambda with the scope it was written in."""

    name: str
    parameters: tuple[tree.Parameter, ...]
    body: tree.Expr
    scope: Scope
    definition: tree.Def | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Builtin:
    """A function that cannot be written in Pore: a kernel operation, or one over lists and fields.

    `signature` lists its parameter names; `call` receives the `Context` of the elaboration, the place of the call (a
    `tree.Call`), the list of the arguments' values, and that of their places. (Its type is spelled out in `calls.Call`:
    to import the context here would close a circle.)
    """

    name: str
    signature: tuple[str, ...]
    call: Callable[..., Value]
    least: int
    most: int | None
    doc: str
    optional: bool = False  # what is left out is handed on as ABSENT


@dataclass(frozen=True, slots=True)
class Given:
    """An argument as the caller wrote it."""

    name: str | None
    value: Value
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """Named members: a used file, or a namespace of the prelude."""

    name: str
    members: Mapping[str, Value]


@dataclass(frozen=True, slots=True, eq=False)
class Acting(Record):
    """What holds or loads a part, as a study takes it: a row of `porelang.ops.studies.ACTIONS` by its name, where it
    does (a condition), and its numbers."""

    where: Node
    numbers: tuple[Node, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Study(Record):
    """A study; its members are what it gives, `task` is what finds them, `without` says why it does not give some."""

    task: Node
    without: Mapping[str, str]


@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """A param that chooses among things that are no numbers; `index` is the number of the option."""

    name: str
    index: Node
    options: tuple[Value, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Poison:
    """The value of an expression that was found to be wrong: whatever uses it says nothing more."""


Value = Scalar | Vector | Bool | Text | ListValue | Range | Function | Builtin | Record | Choice | Poison
POISON = Poison()
#: In place of an argument that was left out, of a builtin that can do without.
ABSENT = Poison()


class Scope:
    """Names bound in one block, over those of the block around it."""

    __slots__ = ("names", "outer")

    def __init__(self, names: Mapping[str, Value], outer: Scope | None = None) -> None:
        self.names = names
        self.outer = outer

    def find(self, name: str) -> Value | None:
        scope: Scope | None = self
        while scope is not None:
            value = scope.names.get(name)
            if value is not None:
                return value
            scope = scope.outer
        return None

    def visible(self) -> set[str]:
        names: set[str] = set()
        scope: Scope | None = self
        while scope is not None:
            names.update(scope.names)
            scope = scope.outer
        return names


def stage(value: Value) -> Stage:
    """When a value is known; what is no number is known when the program is compiled."""
    match value:
        case Scalar(node=n) | Bool(node=n):
            return n.stage
        case Vector():
            return max(n.stage for n in value.nodes)
        case ListValue():
            return max((stage(i) for i in value.items), default=Stage.CONST)
        case Record(name="tensor"):
            return max((stage(i) for i in value.members.values()), default=Stage.CONST)
        case Choice():
            return Stage.UNIFORM
    return Stage.CONST


def describe(value: Value) -> str:
    """A value in a user's words: `a length`, `a list of 4`, `the function gyroid`."""
    match value:
        case Scalar():
            thing = "a number" if value.dimension is None else str(value.dimension)
            return f"{thing} that varies in space" if value.node.stage is Stage.FIELD else thing
        case Vector():
            return "a vector" if value.dimension is None else f"a vector of {_plural(str(value.dimension))}"
        case Bool():
            return "a condition"
        case Text():
            return f'the text "{value.value}"'
        case ListValue():
            return f"a list of {len(value.items)}"
        case Range():
            return "a range"
        case Function() | Builtin():
            return f"the function `{value.name}`"
        case Record():
            return f"the collection `{value.name}`"
        case Choice():
            return f"the choice `{value.name}`"
    return "something wrong"


def _plural(name: str) -> str:
    return {"a length": "lengths", "an angle": "angles", "a force": "forces", "a stress": "stresses"}.get(name, name)


def memo_key(value: Value) -> Any:
    """What tells two values apart when calls are remembered: nodes by identity, numbers with their dimension."""
    match value:
        case Scalar():
            return (value.node, value.dimension, value.literal)
        case ListValue():
            return tuple(memo_key(i) for i in value.items)
    return value


def map_nodes(value: Value, step: Callable[[Node], Node]) -> Value:
    """The value with `step` applied to every node in it."""
    match value:
        case Scalar():
            return Scalar(step(value.node), value.dimension)
        case Vector():
            return Vector(step(value.x), step(value.y), step(value.z), value.dimension)
        case Bool():
            return Bool(step(value.node))
        case ListValue():
            return ListValue(tuple(map_nodes(i, step) for i in value.items))
    return value


def as_list(value: Value) -> tuple[Value, ...] | None:
    """The items of a list; a vector is a list of its three components."""
    match value:
        case ListValue():
            return value.items
        case Vector():
            return tuple(Scalar(n, value.dimension) for n in value.nodes)
    return None


def as_vector(value: Value) -> Vector | None:
    """A vector, or a list of three numbers as one."""
    match value:
        case Vector():
            return value
        case ListValue(items=(Scalar() as a, Scalar() as b, Scalar() as c)):
            return Vector(a.node, b.node, c.node, a.dimension or b.dimension or c.dimension)
    return None
