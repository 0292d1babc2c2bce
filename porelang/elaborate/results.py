"""What elaboration finds out about a program, as data: its params, outputs, checks, contracts and calls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, TypeVar

from porelang.diagnostics import Diagnostic, Label
from porelang.elaborate.values import Bool, Scalar, Value, Vector, describe
from porelang.html import brief, table
from porelang.ir import Node
from porelang.rewrites import Graph
from porelang.source import Span
from porelang.syntax import tree
from porelang.units import UNITS, Dimension


@dataclass(frozen=True, slots=True)
class ParamInfo:
    """A param: its default and range in base units, or the labels of its choices (its number is then the index).

    `numbers` holds the values of a choice among numbers: they are set by value, not by index. `structural` says that
    something is counted or picked by it: the program is compiled once for each of its values. `written` is the unit
    that its declaration has, `deg` or `%`, in which its values are shown; "" where it has none. `raw` says that it
    has no unit and counts those of a lattice, which are no mm.
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
    structural: bool = False
    written: str = ""
    raw: bool = False

    @property
    def ends(self) -> tuple[float, ...]:
        """The values to look at where not all can be: its choices, or both ends of its range."""
        if self.choices and not self.numbers:
            return tuple(map(float, range(len(self.choices))))
        return self.numbers or (self.low, self.high)

    @property
    def countable(self) -> bool:
        """Whether it may stand where something is counted or picked: a choice, or whole numbers without a unit."""
        values = (self.default, self.low, self.high, self.step or 1.0)
        return bool(self.choices) or (self.dimension is None and all(v == int(v) for v in values))

    @property
    def unit(self) -> str:
        """The base unit its number is in, or nothing; a ratio has none, not the unit 1."""
        return "" if self.dimension is None or self.dimension.unit == "1" else self.dimension.unit

    def shown(self, value: float) -> str:
        """A value as a user would write it."""
        if self.choices and not self.numbers:
            return self.choices[int(value)]
        return f"{value / UNITS[self.written].scale:g}{self.written}" if self.written else f"{value:g}{self.unit}"

    @property
    def range(self) -> str:
        """What it may be, as it is written: `10mm..60mm step 1mm`, `{gyroid, schwarz_p}`."""
        if self.choices:
            return f"{{{', '.join(self.choices)}}}"
        step = "" if self.step is None else f" step {self.shown(self.step)}"
        return f"{self.shown(self.low)}..{self.shown(self.high)}{step}"

    def __repr__(self) -> str:
        doc = f' "{brief(self.doc, 60)}"' if self.doc else ""
        return f"<param {self.name} = {self.shown(self.default)} in {brief(self.range, 60)}{doc}>"

    def row(self) -> dict[str, str]:
        """What a table says of it."""
        return {"param": self.name, "default": self.shown(self.default), "range": self.range, "what it is": self.doc}


#: The kinds of params that take data, and how many numbers these have in each place.
OF_DATA: Mapping[str, int] = {"field": 1, "vector": 3, "tensor": 6}


@dataclass(frozen=True, slots=True)
class DataInfo:
    """A param that takes data: how many numbers it has in each place, what they are measured in, where it stands, and
    its default."""

    name: str
    components: int
    dimension: Dimension | None
    doc: str
    span: Span
    default: tuple[Node, ...] = ()

    @property
    def kind(self) -> str:
        """What it is declared as."""
        return next(kind for kind, components in OF_DATA.items() if components == self.components)

    def __repr__(self) -> str:
        unit = "" if self.dimension is None else f" in {self.dimension.unit}"
        doc = f' "{brief(self.doc, 60)}"' if self.doc else ""
        return f"<param {self.name}: {self.kind}{unit}{doc}>"


@dataclass(frozen=True, slots=True)
class Preset:
    """A named set of params: numbers in base units, or labels of choices; where each is set, and the name's place."""

    name: str
    settings: Mapping[str, float | str]
    places: Mapping[str, Span]
    span: Span


@dataclass(frozen=True, slots=True)
class Output:
    """A named result: its value (a number, a vector or a condition) and where it is written.

    `solid` is whether it is known to bound one, `made` whether it is more than a shape or a lattice as it was given.
    """

    name: str
    value: Scalar | Vector | Bool
    span: Span
    solid: bool = False
    made: bool = False

    @property
    def nodes(self) -> tuple[Node, ...]:
        """Its roots as written: one, or the three of a vector."""
        return self.value.nodes if isinstance(self.value, Vector) else (self.value.node,)

    def __repr__(self) -> str:
        return f"<output {self.name}, {describe(self.value)}: {self.written}>"

    @property
    def written(self) -> str:
        """Its statement in a line, shortened."""
        return brief(self.span.text, 80)

    def row(self) -> dict[str, str]:
        """What a table says of it."""
        return {"output": self.name, "kind": describe(self.value), "written as": self.written}


Row = TypeVar("Row", ParamInfo, Output)


class Listed(dict[str, Row]):
    """Params or outputs by their names; shown one a line, and as a table in a notebook."""

    def __repr__(self) -> str:
        return "\n".join(map(repr, self.values())) or "<none>"

    def _repr_html_(self) -> str:
        rows = [item.row() for item in self.values()]
        return table(list(rows[0]), [list(row.values()) for row in rows]) if rows else "none"


@dataclass(frozen=True, slots=True)
class Requirement:
    """A condition over params that must hold for every setting, or (a `check`) for the one in use.

    `solve` is the task that finds what it is about, as it was written; `hint` a way out.
    """

    condition: Node
    message: str
    span: Span
    others: tuple[Label, ...] = ()
    solve: Node | None = None
    hint: str = ""


@dataclass(frozen=True, slots=True)
class CallRecord:
    """A call that the user wrote: the function's name and definition, its arguments by parameter, and the place.

    `definition` is None for a lambda.
    """

    name: str
    definition: tree.Def | None
    arguments: Mapping[str, Value]
    span: Span


@dataclass(frozen=True, slots=True)
class Suspicion:
    """What is doubted unless values show that it is right; `porelang.doubts` looks at them.

    `what` says which nodes there are. "total": the two solids that are added or subtracted. "copies": a body, its
    copies, and the size of their cells (none, or three nodes). "apart": two solids of which one is cut by the other.
    "pores": a lattice that was made into walls, and what they are cut with. "seam": a lattice that meets itself along
    y, after how many mm, and what is made of it. "empty": an inward offset, and its body. "period": a lattice, the
    three periods that it is given, and its phase. "still": the three of a direction that is followed, and what is made
    of it. "fold": a lattice, after which part of a turn it should be the same, a place on the axis of that turn
    (three), a direction and the other one of its frame (three each), and what is made of it. "fits": a lattice, what is
    taken for its period along the axis `instead`, and what is made of it. "jump": a lattice and its phase (three).
    "stretched": what is made at other coordinates, and these, then the direction that they follow, `up` and `about`
    where `up` was not given (three each); or a lattice and its phase. "uneven": what was a distance, the length that is
    added to it, and what of it was stretched, scaled or mixed (any number), or the distance that the function `name`
    has found. "bend": what is made along a curve, the radius of its arcs (0 for the greatest), whether it is closed,
    and its points (three each); "rod": the same of a rod that others follow. "beyond": a lattice, and its phase (three)
    that was found within a solid.
    `argument` is the place that an edit would change, `name` the function or the operator, `instead` what might
    stand there, `period` that of the lattice, `beside` what a cut is united with without parentheses, and the whole.
    """

    what: Literal[
        "total", "copies", "apart", "pores", "seam", "empty", "period", "still", "fold", "fits", "jump", "stretched",
        "uneven", "bend", "rod", "beyond",
    ]  # fmt: skip
    span: Span
    nodes: tuple[Node, ...]
    argument: Span | None = None
    name: str = ""
    instead: str = ""
    period: Node | None = None
    beside: tuple[Span, Node] | None = None


@dataclass(frozen=True, slots=True)
class Unread:
    """A let or a param that nothing in its file refers to."""

    name: str
    span: Span
    param: bool
    fixed: bool


@dataclass(slots=True, repr=False)
class Elaborated:
    """All that elaboration finds out about a program. `structure` are the params that have to be fixed."""

    params: dict[str, ParamInfo] = field(default_factory=dict)
    data: dict[str, DataInfo] = field(default_factory=dict)
    structure: set[str] = field(default_factory=set)
    presets: dict[str, Preset] = field(default_factory=dict)
    outputs: dict[str, Output] = field(default_factory=dict)
    lets: dict[str, Scalar] = field(default_factory=dict)
    studies: dict[str, Node] = field(default_factory=dict)  # what each `let` of a study is found by
    checks: list[Requirement] = field(default_factory=list)
    requirements: list[Requirement] = field(default_factory=list)
    contracts: dict[int, Requirement] = field(default_factory=dict)  # by the numbers that `ensure` has
    calls: list[CallRecord] = field(default_factory=list)
    tasks: dict[tuple[Node, Span], None] = field(default_factory=dict)  # each with where it is asked for, in order
    diagnostics: list[Diagnostic] = field(default_factory=list)
    suspicions: list[Suspicion] = field(default_factory=list)
    unread: list[Unread] = field(default_factory=list)
    conditions: dict[Node, tree.Chain] = field(default_factory=dict)  # how the user compared numbers
    lattices: dict[Node, tuple[Span, Node | None]] = field(default_factory=dict)  # where each is, and its period
    values: dict[Span, Value] = field(default_factory=dict)  # of each expression of the text, when first evaluated
    files: dict[str, Value] = field(default_factory=dict)  # what each `use` of the main file stands for
    collection: bool = False  # definitions for other files, and nothing else


def graph_of(found: Elaborated, whole: bool = True) -> Graph:
    """The graph as it was written; of a program with errors only what is asked of its params."""
    return Graph(
        {name: output.nodes for name, output in found.outputs.items()} if whole else {},
        tuple(r.condition for r in found.requirements),
        tuple(c.condition for c in found.checks) if whole else (),
        tuple(n for n, _ in found.tasks) if whole else (),
    )
