"""From the tree to the graph: expressions evaluated to values, once, with everything that is wrong said on the way.

The elaborator is an abstract interpreter. Functions, lists, texts and records exist only here; numbers and
conditions become
nodes of the graph. It never stops at a mistake: a wrong expression is poison, what uses poison is silent, and the
rest of the file is looked at all the same.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field

from porelang.diagnostics import Diagnostic, Edit, Label, PoreError, Severity, suggest
from porelang.elaborate import names as resolution
from porelang.elaborate import operators
from porelang.elaborate.expressions import evaluate
from porelang.elaborate.kinds import KINDS
from porelang.elaborate.params import ParamInfo, declare
from porelang.elaborate.values import (
    POISON,
    Bool,
    Function,
    ListValue,
    Poison,
    Record,
    Scalar,
    Scope,
    Value,
    Vector,
    as_vector,
    describe,
)
from porelang.ir import Node, Stage, const, order
from porelang.ops import TABLE
from porelang.rewrites import Graph, run
from porelang.rewrites.simplify import computed
from porelang.source import Source, Span
from porelang.syntax import tree

#: More expressions than this are not a design but an accident (a doubling of a doubling ...).
MOST_STEPS = 1_000_000
#: The tree is walked by recursion; its depth is limited by the parser, and calls by `calls.DEEPEST`.
_RECURSION = 60_000

#: Finds the file of a `use` statement: (path as written, source of the statement) -> the parsed file.
Loader = Callable[[str, Source], "tuple[tree.File, list[Diagnostic]]"]


#: What to do, where nothing better can be said at the place itself.
HINTS = {
    "E042": "leave one of the two out",
    "E045": "leave one of the two out",
    "E060": "give it what it asks for; `pore explain E060` says how kinds become each other",
    "E061": "`pore explain E061` shows what can be called and combined",
    "E062": "change the unit; a bare number fits anywhere",
    "E064": "change the value, or the contract",
    "E081": "write `lo..hi` with lo below hi",
    "E082": "let all choices be of one kind",
}


class TooBig(Exception):  # noqa: N818  # ends one elaboration, never shown
    """The program ran over its budget; the diagnostic has been written."""


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
    """A call that the user wrote: the function's name, its arguments by parameter, and the place."""

    name: str
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


class Elaborator:
    """The state of one elaboration: what was found, the calls in progress and the budget."""

    def __init__(self, base: Scope, load: Loader | None = None) -> None:
        self.base = base
        self.load = load
        self.out = Elaborated()
        self.frames: list[tuple[str, Span]] = []
        self.memo: dict[object, Value] = {}
        self.steps = 0
        self._said: set[tuple[object, ...]] = set()
        self._constants: dict[Node, float | bool] = {}
        self._files: list[str] = []
        self.called: set[tree.Def] = set()

    # ---- saying what is wrong ---------------------------------------------------------------------------------------

    def error(
        self,
        code: str,
        message: str,
        span: Span,
        label: str = "",
        others: tuple[Label, ...] = (),
        hint: str = "",
        edit: Edit | tuple[Span, str] | None = None,
        severity: Severity = "error",
    ) -> Poison:
        """Note a diagnostic. What goes wrong inside the prelude is told at the user's call that led there."""
        if span.source.prelude:
            for name, site in reversed(self.frames):
                if not site.source.prelude:
                    span, message, label = site, f"{message} (in `{name}`)", label and "in this call"
                    others, edit = tuple(o for o in others if not o.span.source.prelude), None
                    break
        elif self.frames and not others:
            name, site = self.frames[-1]
            if not site.source.prelude and name and (site.start, site.end) != (span.start, span.end):
                inside = next((f for f in self.frames if f[1].start == site.start), None)
                if inside is not None and not (site.start <= span.start and span.end <= site.end):
                    others = (Label(site, f"`{name}` is called here"),)
        said = (code, span.source, span.start, span.end, message)
        if said not in self._said:
            self._said.add(said)
            made = Edit(*edit) if isinstance(edit, tuple) else edit
            hint = hint or HINTS.get(code, "")
            self.out.diagnostics.append(Diagnostic(code, message, span, label, others, hint, made, severity))
        return POISON

    # ---- constants --------------------------------------------------------------------------------------------------

    def constant(self, n: Node) -> float | bool | None:
        """The value of a node that is known now, or None."""
        if n.stage is not Stage.CONST:
            return None
        if n.op == "const":
            return n.value  # type: ignore[return-value]  # a const holds a number
        known = self._constants
        for m in order([n], lambda m: () if m in known or m.op not in TABLE else m.args):
            if m in known:
                continue
            if m.op == "const":
                known[m] = m.value  # type: ignore[assignment]  # a const holds a number
            elif m.op in TABLE:
                known[m] = computed(m.op, [known[a] for a in m.args])
            else:  # a field at a fixed point
                known[m] = run(Graph({"value": m}, {}), after="fold").roots["value"].value  # type: ignore[assignment]  # folded
        return known[n]

    def need_constant(self, value: Value, span: Span, what: str) -> float | None:
        """A number that must be known now; says so where it is not."""
        if isinstance(value, Poison):
            return None
        if not isinstance(value, Scalar):
            self.error("E060", f"{what} must be a number, not {describe(value)}", span)
            return None
        number = self.constant(value.node)
        if number is None:
            why = "it varies in space" if value.node.stage is Stage.FIELD else "it depends on a param"
            self.error(
                "E063",
                f"{what} must be known when the program is compiled",
                span,
                label=why,
                hint="write the number itself, or bind it with `let`",
            )
            return None
        return float(number)

    def require(self, condition: Node, message: str, span: Span, others: tuple[Label, ...]) -> None:
        """A condition over params, to be proven over their whole range."""
        self.out.requirements.append(Requirement(condition, message, self._outside(span), others))

    def contract(self, message: str, span: Span, others: tuple[Label, ...]) -> int:
        """A condition over space; its number names it in `ensure` nodes."""
        self.out.contracts.append(Requirement(const(True), message, self._outside(span), others))
        return len(self.out.contracts) - 1

    def record(self, name: str, arguments: Mapping[str, Value], site: Span) -> None:
        """Note a call that stands in the user's text, in the order of evaluation, each place once."""
        if not site.source.prelude and (site.source, site.start, site.end) not in self._said:
            self._said.add((site.source, site.start, site.end))
            self.out.calls.append(CallRecord(name, dict(arguments), site))

    def reduction(self, site: Span) -> str:
        """The text of a call that reduces fields, by which its number is known; its place is kept."""
        place = self._outside(site)
        text = " ".join(place.text.split())
        self.out.reductions.setdefault(text, place)
        return text

    def _outside(self, span: Span) -> Span:
        """The place itself, or the user's call that led into the prelude."""
        if span.source.prelude:
            return next((site for _, site in reversed(self.frames) if not site.source.prelude), span)
        return span

    # ---- statements -------------------------------------------------------------------------------------------------

    def program(self, file: tree.File, lost: frozenset[str] = frozenset()) -> Elaborated:
        """All statements of the main file; of `lost`, the names of those that could not be read, no more is said."""
        if lost:
            self.base = Scope(dict.fromkeys(lost, POISON), self.base)
        self._files.append(file.source.name)
        with room_to_compile(), suppress(TooBig):
            self._file(file, "")
        return self.out

    def _file(self, file: tree.File, prefix: str) -> dict[str, Value]:
        """The definitions of a file as values; `prefix` names the params of a used file."""
        known = frozenset(self.base.visible())
        bound, twice = resolution.bound(file.statements, known)
        uses, unknown = resolution.resolve(file.statements, bound.keys() | known)
        index = {s: i for i, s in enumerate(file.statements)}
        order, rings = resolution.evaluation_order(bound, {n: uses[index[s]] for n, s in bound.items()})
        self.out.diagnostics += [*twice, *unknown, *rings]
        in_ring = {d.span for d in rings} | {o.span for d in rings for o in d.others}
        members: dict[str, Value] = {}
        scope = Scope(members, self.base)
        for name in order:
            binding = bound[name]
            members[name] = POISON if binding.name_span in in_ring else self._define(binding, scope, prefix)
        for s in file.statements:
            if isinstance(s, tree.Out) and not prefix:
                self._output(s, members[s.name] if bound.get(s.name) is s else self.expr(s.value, scope))
            elif isinstance(s, tree.Check):
                self._check(s, scope)
        for d in bound.values():
            if isinstance(d, tree.Def) and d not in self.called and members.get(d.name) is not POISON:
                self._try_body(d, scope)
        return members

    def _define(self, s: resolution.Bound, scope: Scope, prefix: str) -> Value:
        match s:
            case tree.Let():
                value = self.expr(s.value, scope)
                if isinstance(value, Scalar) and value.literal and not s.span.source.prelude:
                    value = Scalar(value.node, value.dimension)
                if isinstance(value, Scalar) and not prefix:
                    self.out.lets[s.name] = value
                return value
            case tree.Out():
                return self.expr(s.value, scope)
            case tree.Def():
                self.declared_kinds(s)
                return Function(s.name, s.parameters, s.body, scope, s)
            case tree.Param():
                return declare(self, s, scope, prefix)
            case tree.Use():
                return self._use(s)

    def declared_kinds(self, s: tree.Def) -> None:
        first: dict[str, Span] = {}
        for p in s.parameters:
            if p.name in first:
                self.error(
                    "E031",
                    f"the parameter `{p.name}` is bound twice",
                    p.name_span,
                    label="bound again here",
                    others=(Label(first[p.name], "first bound here"),),
                    hint="give one of them another name",
                )
            first.setdefault(p.name, p.name_span)
            for k in p.kinds:
                if k.name not in KINDS:
                    near = suggest(k.name, KINDS)
                    self.error(
                        "E034",
                        f"there is no kind `{k.name}`",
                        k.span,
                        label="not a kind of value",
                        hint=f"did you mean `{near}`?" if near else f"the kinds are {', '.join(KINDS)}",
                        edit=Edit(k.span, near) if near else None,
                    )

    def _use(self, s: tree.Use) -> Value:
        if self.load is None:
            return self.error("E035", "files cannot be used here", s.span, hint="compile the program from a file")
        try:
            file, found = self.load(s.path.value, s.span.source)
        except PoreError as failed:
            d = failed.diagnostics[0]
            return self.error(d.code, d.message, s.path.span, label=d.label, hint=d.hint)
        self.out.diagnostics.extend(found)
        if file.source.name in self._files:
            way = " -> ".join(f"`{f}`" for f in [*self._files[self._files.index(file.source.name) :], file.source.name])
            return self.error(
                "E035", f"files use each other in a ring: {way}", s.path.span, label="this closes the ring"
            )
        self._files.append(file.source.name)
        members = self._file(file, f"{s.name}.")
        self._files.pop()
        return Record(s.name, members)

    def _output(self, s: tree.Out, value: Value) -> None:
        if isinstance(value, ListValue) and (vector := as_vector(value)) is not None:
            value = vector
        if isinstance(value, Scalar | Vector | Bool):
            self.out.outputs.setdefault(s.name, Output(s.name, value, s.value.span))
        elif not isinstance(value, Poison):
            hint = operators._call_it(value) or "an output is a field: a number that varies in space"
            self.error(
                "E066",
                f"the output `{s.name}` is {describe(value)}, which has no surface",
                s.value.span,
                label=f"this is {describe(value)}",
                hint=hint,
            )

    def _check(self, s: tree.Check, scope: Scope) -> None:
        value = self.expr(s.condition, scope)
        if isinstance(value, Poison):
            return
        if not isinstance(value, Bool):
            self.error(
                "E060",
                f"a check is a condition, not {describe(value)}",
                s.condition.span,
                hint='compare something: `check w > 2 * t, "..."`',
            )
        elif value.node.stage is Stage.FIELD:
            self.error(
                "E067",
                "this check varies in space",
                s.condition.span,
                label="true at some points, perhaps",
                hint="a check is about numbers: constants and params",
            )
        else:
            self.out.checks.append(Requirement(value.node, s.message, s.condition.span))

    def _try_body(self, s: tree.Def, scope: Scope) -> None:
        """A def that nothing calls is looked at all the same, with arguments about which nothing is known."""
        names: dict[str, Value] = {p.name: POISON for p in s.parameters}
        for p in s.parameters:
            if p.default is None or not p.kinds:
                continue
            value = self.expr(p.default, Scope(names, scope))
            kinds = [KINDS[k.name] for k in p.kinds if k.name in KINDS]
            if not isinstance(value, Poison) and kinds and all(k.accept(value) is None for k in kinds):
                self.error(
                    "E062",
                    f"the default of `{p.name}` is {describe(value)}, not {' or '.join(k.words for k in kinds)}",
                    p.default.span,
                    label="this is the default",
                    others=(Label(p.kinds[0].span, "and this is what it is to be"),),
                )
        self.expr(s.body, Scope(names, scope))

    # ---- expressions ------------------------------------------------------------------------------------------------

    def spend(self, steps: int, span: Span) -> None:
        """Take steps (expressions, items of lists) off the program's budget; ends the elaboration where it is spent."""
        self.steps += steps
        if self.steps > MOST_STEPS:
            site = self.frames[0][1] if self.frames else span
            self.error(
                "E070",
                "the program is too big: its calls and lists multiply without end",
                site,
                label="while this was computed",
                hint="use fewer levels, or `repeat` for what repeats",
            )
            raise TooBig

    def expr(self, t: tree.Expr, scope: Scope) -> Value:
        """The value of an expression."""
        self.spend(1, t.span)
        return evaluate(self, t, scope)


@contextmanager
def room_to_compile() -> Iterator[None]:
    """Deep recursion (Python frames do not use the C stack), and no garbage collector: nodes stay. A third faster."""
    before, collecting = sys.getrecursionlimit(), gc.isenabled()
    sys.setrecursionlimit(max(before, _RECURSION))
    gc.disable()
    try:
        yield
    finally:
        sys.setrecursionlimit(before)
        if collecting:
            gc.enable()


def roots_of(outputs: Mapping[str, Output]) -> dict[str, Node]:
    """The graph's roots: an output's node, or three for a vector (`name.x`, `name.y`, `name.z`)."""
    roots: dict[str, Node] = {}
    for name, o in outputs.items():
        if isinstance(o.value, Vector):
            roots |= {f"{name}.{axis}": n for axis, n in zip("xyz", o.value.nodes, strict=True)}
        else:
            roots[name] = o.value.node
    return roots
