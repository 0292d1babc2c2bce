"""The syntax tree of a `.pore` file: what was written, with places, and nothing that was inferred."""

from __future__ import annotations

import re
from dataclasses import dataclass

from porelang.source import Source, Span


@dataclass(frozen=True, slots=True, eq=False)
class Number:
    """`30`, `2.5mm`, `45%`: the value as written and its unit suffix (empty if bare)."""

    span: Span
    value: float
    unit: str


@dataclass(frozen=True, slots=True, eq=False)
class Text:
    """`"part.stl"`, with its escapes resolved."""

    span: Span
    value: str


@dataclass(frozen=True, slots=True, eq=False)
class Boolean:
    """`true` or `false`."""

    span: Span
    value: bool


@dataclass(frozen=True, slots=True, eq=False)
class Name:
    """A use of a name."""

    span: Span
    name: str


@dataclass(frozen=True, slots=True, eq=False)
class Member:
    """`study.von_mises`, `q.x`; `name_span` is the member's name."""

    span: Span
    target: Expr
    name: str
    name_span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Index:
    """`points[2]`."""

    span: Span
    target: Expr
    index: Expr


@dataclass(frozen=True, slots=True, eq=False)
class Argument:
    """An argument of a call; `name` is None for a positional one."""

    span: Span
    name: str | None
    value: Expr


@dataclass(frozen=True, slots=True, eq=False)
class Call:
    """`f(1, r=2)`."""

    span: Span
    function: Expr
    arguments: tuple[Argument, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Unary:
    """`-a`, `~a`, `not a`."""

    span: Span
    op: str
    operand: Expr


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """Operators of one level of precedence, read from the left: `a + b - c` is `first=a, rest=(("+", b), ("-", c))`.

    Kept flat, so that a sum of ten thousand terms is not ten thousand levels deep. `^` (from the right) and the
    comparisons, which do not chain, are chains with one entry in `rest`. `op_spans` are the operators' places.
    """

    span: Span
    first: Expr
    rest: tuple[tuple[str, Expr], ...]
    op_spans: tuple[Span, ...]


@dataclass(frozen=True, slots=True, eq=False)
class If:
    """`if c then a else if d then b else e`: the branches in order (kept flat), and the last `else`."""

    span: Span
    branches: tuple[tuple[Expr, Expr], ...]
    otherwise: Expr


@dataclass(frozen=True, slots=True, eq=False)
class Lambda:
    """`t => expr` or `(a, b) => expr`."""

    span: Span
    parameters: tuple[Name, ...]
    body: Expr


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """`{ let k = tau / w; expr }`: bindings (let or def), then the value."""

    span: Span
    bindings: tuple[Let | Def, ...]
    value: Expr


@dataclass(frozen=True, slots=True, eq=False)
class List:
    """`[a, b, c]`."""

    span: Span
    items: tuple[Expr, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Clause:
    """`for j in range(i) if i != j`: a name, the list that it runs through, and what an item must satisfy."""

    name: Name
    items: Expr
    filters: tuple[Expr, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Comprehension:
    """`[for i in range(3) for j in range(i) if i != j: expr]`: the last clause runs fastest."""

    span: Span
    clauses: tuple[Clause, ...]
    value: Expr


Expr = (
    Number | Text | Boolean | Name | Member | Index | Call | Unary | Chain | If | Lambda | Block | List | Comprehension
)


@dataclass(frozen=True, slots=True, eq=False)
class Parameter:
    """A parameter of a def: `b: length where b > 0 = 2mm`, in either order of contract and default.

    `kinds` are the declared kinds (`a: length | vector`), empty if none. In `w: period or phase = p / w` exactly one
    of the two is given by a caller: `w` has `alternative="phase"`, and the default of `phase` is computed from it.
    """

    span: Span
    name: str
    name_span: Span
    kinds: tuple[Name, ...]
    where: Expr | None
    default: Expr | None
    alternative: str | None


@dataclass(frozen=True, slots=True, eq=False)
class Use:
    """`use "lib/plates.pore" as plates`."""

    span: Span
    path: Text
    name: str
    name_span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Param:
    """`param w = 30mm in 10mm..60mm step 1mm "unit cell"`; a choice has `choices` and no `low`, `high`.

    `param stress: field = 0MPa "von Mises"` takes data: it has a `kind`, at `kind_span`, and none of them.
    """

    span: Span
    name: str
    name_span: Span
    default: Expr
    low: Expr | None
    high: Expr | None
    step: Expr | None
    choices: tuple[Expr, ...]
    doc: str
    kind: str = ""
    kind_span: Span | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Let:
    """`let k = tau / w`."""

    span: Span
    name: str
    name_span: Span
    value: Expr


@dataclass(frozen=True, slots=True, eq=False)
class Def:
    """`def twist(f, rate) = f @ [...]`; `doc` is the text of the `##` lines before it."""

    span: Span
    name: str
    name_span: Span
    parameters: tuple[Parameter, ...]
    body: Expr
    doc: str

    def fact(self, word: str) -> str | None:
        """What a line `WORD: ...` of the documentation says; None where there is none."""
        line = re.search(rf"^{word}:(.*)$", self.doc, re.MULTILINE)
        return line[1].strip() if line else None


@dataclass(frozen=True, slots=True, eq=False)
class Out:
    """`out skin = expr`; a bare last expression is `out part` with an empty `name_span`."""

    span: Span
    name: str
    name_span: Span
    value: Expr


@dataclass(frozen=True, slots=True, eq=False)
class Check:
    """`check w > 2 * t, "walls would touch"`."""

    span: Span
    condition: Expr
    message: str


@dataclass(frozen=True, slots=True, eq=False)
class Setting:
    """`w = 6mm` of a preset; `name` may be that of a param of a used file, `plates.t`."""

    span: Span
    name: str
    name_span: Span
    value: Expr


@dataclass(frozen=True, slots=True, eq=False)
class Preset:
    """`preset "fine": w = 6mm, t = 0.4mm`: a named set of params."""

    span: Span
    name: str
    name_span: Span
    settings: tuple[Setting, ...]


Statement = Use | Param | Preset | Let | Def | Out | Check


@dataclass(frozen=True, slots=True, eq=False)
class File:
    """The statements of a source that could be read."""

    source: Source
    statements: tuple[Statement, ...]
