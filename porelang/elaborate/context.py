"""What one elaboration knows: what has been said and found, the calls in progress, what is remembered, the budget.

A call evaluates the body of a function, and an expression may be a call: `calls` and `expressions` need each other.
They meet here and nowhere else. A `Context` is made with the function that evaluates an expression
(`expressions.evaluate`), and whoever has an expression hands it to `Context.evaluate`; so every module of this room
imports this one, and this one imports none of those that use it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, TypeVar

from porelang.diagnostics import Diagnostic, Edit, Label, Severity
from porelang.elaborate.journal import Journal, NotedDict, NotedList, NotedSet, Stretch
from porelang.elaborate.natures import Nature
from porelang.elaborate.results import CallRecord, Elaborated, Requirement, Suspicion
from porelang.elaborate.values import POISON, Choice, Function, Given, Poison, Scalar, Scope, Value, describe
from porelang.ir import TASKS, Node, Stage, const, constant, node, order, within
from porelang.ops import TABLE
from porelang.rewrites import Graph, run
from porelang.rewrites.simplify import computed
from porelang.source import Span
from porelang.syntax import tree

#: More expressions than this are not a design but an accident (a doubling of a doubling ...).
MOST_EXPRESSIONS = 1_000_000

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


#: What a param is bound to: the operation of its slot and the slot's payload, a file or what is held in memory.
Bound = tuple[str, ...]


class TooBig(Exception):  # noqa: N818  # ends one elaboration, never shown
    """The program ran over its budget; the diagnostic has been written."""


#: What a call came to: its value, the conditions that it asks of params, and all that was noted in its body.
Remembered = tuple[Value, dict[Requirement, None], Stretch]
C = TypeVar("C")

#: The collections of `Elaborated` that statements add to.
_FOUND: Mapping[str, Callable[[str, Journal], Any]] = {
    **dict.fromkeys(("params", "data", "presets", "outputs", "lets", "studies", "files"), NotedDict),
    **dict.fromkeys(("conditions", "lattices", "values", "contracts", "tasks"), NotedDict),
    **dict.fromkeys(("checks", "calls", "diagnostics", "suspicions"), NotedList),
    "structure": NotedSet,
}


class Context:
    """The state of one elaboration. It belongs to one thread; nothing in it is shared with another elaboration.

    `found` is what is handed on, `call_stack` the calls in progress (name and place, the outermost first), `memo` the
    results of calls by function and arguments, `called` the defs that something refers to, `folder` where relative
    paths of data begin, `structure` the params that are fixed, and at what, `bound` those that have data. `natures` is
    what is known of fields, `totals` where distances were added or subtracted (the operator and its place), `cuts`
    where solids are cut, `declared` the names of all params but those that take data, `unknown` names that were told,
    `lengths` which nodes without a known unit were made of lengths, `in_degrees` the angle of each number of degrees,
    `stretching` coordinates that stretch cells, with the name of what makes them and what to do about it, `lifted` the
    distances that `metric` has found to lattices,
    `given_at` the arguments of calls in the user's text by their place. What is found or noted lies in `collections`
    and is written down in the `journal`, so that a statement that stands as it stood need not be evaluated again.
    """

    def __init__(
        self,
        evaluate: Callable[[Context, tree.Expr, Scope], Value],
        folder: str = "",
        structure: Mapping[str, float] | None = None,
        bound: Mapping[str, Bound] | None = None,
        numbers: dict[Requirement, int] | None = None,
    ) -> None:
        self._evaluate = evaluate
        self.folder = folder
        self.structure = structure or {}
        self.bound = bound or {}
        self.unknown: frozenset[str] = frozenset()
        self.required: dict[Requirement, None] = {}  # in order, each once
        self.call_stack: list[tuple[str, Span]] = []
        self.given_at: dict[Span, Mapping[str, Given]] = {}
        self.journal = Journal()
        self.collections: dict[str, Any] = {}
        self.memo = self._noted("memo", NotedDict[object, Remembered])
        self.called = self._noted("called", NotedSet[tree.Def])
        self.natures = self._noted("natures", NotedDict[Node, Nature | None])
        self.totals = self._noted("totals", NotedDict[Node, tuple[str, Span]])
        self.cuts = self._noted("cuts", NotedList[Suspicion])
        self.declared = self._noted("declared", NotedList[str])
        self.in_degrees = self._noted("in_degrees", NotedDict[Node, Scalar])
        self.lifted = self._noted("lifted", NotedSet[Node])
        self.stretching = self._noted("stretching", NotedDict[Node, tuple[str, str]])
        self.lengths = self._noted("lengths", NotedDict[Node, bool])
        self.found = Elaborated()
        for name, kind in _FOUND.items():
            setattr(self.found, name, self._noted(name, kind))
        self._numbers = {} if numbers is None else numbers
        self._spent = 0
        self._solves = 0
        self._reported: set[tuple[object, ...]] = set()
        self._recorded: set[Span] = set()
        self._suspected: dict[tuple[str, Span], list[Suspicion]] = {}
        self._constants: dict[Node, float | bool] = {}

    def _noted(self, name: str, kind: Callable[[str, Journal], C]) -> C:
        made = kind(name, self.journal)
        self.collections[name] = made
        return made

    # ---- expressions ------------------------------------------------------------------------------------------------

    def evaluate(self, t: tree.Expr, scope: Scope) -> Value:
        """The value of an expression, with what is wrong in it reported; it costs a step of the budget."""
        self.spend(1, t.span)
        value = self._evaluate(self, t, scope)
        if not t.span.source.prelude:
            self.found.values.setdefault(t.span, value)
        return value

    def spend(self, steps: int, span: Span) -> None:
        """Take steps (expressions, items of lists) off the program's budget; ends the elaboration where it is spent."""
        self.expect(steps, span)
        self._spent += steps

    def expect(self, steps: int, span: Span) -> None:
        """End the elaboration now, not after minutes, where so many steps that will be taken are more than are left."""
        if self._spent + steps > MOST_EXPRESSIONS:
            site = self.call_stack[0][1] if self.call_stack else span
            self.error(
                "E070",
                "the program is too big: its calls and lists multiply without end",
                site,
                label="while this was computed",
                hint="use fewer levels, or `repeat` for what repeats",
            )
            raise TooBig

    @property
    def spent(self) -> int:
        """The steps that were taken off the budget."""
        return self._spent

    def spend_again(self, steps: int) -> bool:
        """Take off the budget what a statement took that need not be evaluated again; False where that is too much."""
        enough = self._spent + steps <= MOST_EXPRESSIONS
        self._spent += steps if enough else 0
        return enough

    def refer(self, value: Value) -> Value:
        """The value that a name refers to; a def that something refers to needs no look of its own."""
        if isinstance(value, Function) and value.definition is not None:
            self.called.add(value.definition)
        return value

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
        once: bool = False,
    ) -> Poison:
        """Note a diagnostic; one that is said in the same words of the same place is said already, and with `once` what
        is said of it in others. What goes wrong inside the prelude is told at the user's call that led there."""
        if span.source.prelude:
            for name, site in reversed(self.call_stack):
                if not site.source.prelude:
                    span, message, label = site, f"{message} (in `{name}`)", label and "in this call"
                    others = tuple(o for o in others if not o.span.source.prelude)
                    edit = edit if isinstance(edit, Edit) and not edit.span.source.prelude else None
                    break
        elif self.call_stack and not others:
            name, site = self.call_stack[-1]
            if not site.source.prelude and name and (site.start, site.end) != (span.start, span.end):
                inside = next((f for f in self.call_stack if f[1].start == site.start), None)
                if inside is not None and not (site.start <= span.start and span.end <= site.end):
                    others = (Label(site, f"`{name}` is called here"),)
        made = Edit(*edit) if isinstance(edit, tuple) else edit
        said = Diagnostic(code, message, span, label, others, hint or HINTS.get(code, ""), made, severity)
        self.journal.note(self, Context._report, said, (code, span, "" if once else message))
        return POISON

    def _report(self, said: Diagnostic, identity: tuple[object, ...]) -> None:
        if identity not in self._reported:
            self._reported.add(identity)
            list.append(self.found.diagnostics, said)

    # ---- constants --------------------------------------------------------------------------------------------------

    def constant(self, n: Node) -> float | bool | None:
        """The value of a node that is known now, or None."""
        if n.stage is not Stage.CONST:
            return None
        if n.op == "const":
            return constant(n)
        known = self._constants
        for m in order([n], lambda m: () if m in known or m.op not in TABLE else m.args):
            if m in known:
                continue
            if m.op == "const":
                known[m] = constant(m)
            elif m.op in TABLE:
                known[m] = computed(m.op, [known[a] for a in m.args], m.value)
            else:  # a field at a fixed point
                known[m] = constant(run(Graph({"": (m,)}), after="fold").outputs[""][0])
        return known[n]

    def need_constant(self, value: Value, span: Span, what: str, fixing: bool = False) -> float | None:
        """A number that must be known now; says so where it is not. `fixing` has the params fixed that decide it."""
        if isinstance(value, Poison):
            return None
        if not isinstance(value, Scalar):
            self.error("E060", f"{what} must be a number, not {describe(value)}", span)
            return None
        number = self.constant(value.node)
        if number is None and fixing:
            number = self.need_known(value.node, span, what)
        elif number is None:
            why = "it varies in space" if value.node.stage is Stage.FIELD else "it depends on a param"
            self.error(
                "E063",
                f"{what} must be known when the program is compiled",
                span,
                label=why,
                hint="write the number itself, or bind it with `let`",
            )
        return None if number is None else float(number)

    def need_known(self, n: Node, span: Span, what: str) -> float | bool | None:
        """The value of a number or a condition that must be known now; says so where it can not be.

        Where it depends on params that count or choose, these become the program's structure: it is elaborated again
        with them fixed, and until then the value is None without a word.
        """
        known = self.constant(n)
        if known is None and not self.fix(n):
            message = f"{what} must be known when the program is compiled"
            self.error("E063", message, span, *self._why_unknown(n))
        return known

    def fix(self, n: Node) -> bool:
        """Have the params that a number depends on fixed; False where something else decides it, or one cannot be."""
        names = self._params(n)
        if n.stage is Stage.FIELD or not names or not all(self.found.params[name].countable for name in names):
            return False
        self.found.structure.update(names)
        return True

    def decided(self, value: Value) -> Value:
        """A choice as the option that it has: its param is fixed. Any other value is itself."""
        return POISON if isinstance(value, Choice) and self.fix(value.index) else value

    def _params(self, n: Node) -> list[str]:
        """The params that a number depends on; none where it depends on what is found from fields, too."""
        below = order([n], within)
        if any(m.op in TASKS or m.op == "unknown" for m in below):
            return []
        return [m.value for m in below if m.op == "param" and isinstance(m.value, str)]

    def _why_unknown(self, n: Node) -> tuple[str, tuple[Label, ...], str]:
        if n.stage is Stage.FIELD:
            hint = "what is counted or picked is the same everywhere: a number, or a param of whole numbers"
            return "it varies in space", (), hint
        names = self._params(n)
        if not names:
            return "it is found from a whole field, later", (), "write the number itself, or make it a param"
        info = next(i for i in (self.found.params[name] for name in names) if not i.countable)
        what = f"it depends on `{info.name}`, which is {info.dimension or 'not whole'}"
        hint = "a param that counts has whole numbers, without a unit: `param n = 6 in 3..12`"
        return what, (Label(info.span, "declared here"),), hint

    # ---- what is found ----------------------------------------------------------------------------------------------

    def require(self, condition: Node, message: str, span: Span, others: tuple[Label, ...]) -> None:
        """A condition over params, to be proven over their whole range."""
        self.required[Requirement(condition, message, self.users_place(span), others)] = None

    @contextmanager
    def requiring(self) -> Iterator[dict[Requirement, None]]:
        """While this lasts conditions are collected apart; who asks for that hands on to `required` what becomes of
        them: of a branch they hold where it is taken, of a `solve` for what it finds."""
        outer = self.required
        self.required = own = dict[Requirement, None]()
        try:
            yield own
        finally:
            self.required = outer

    def require_where(self, condition: Node, required: Iterable[Requirement]) -> None:
        """Hand on conditions of a branch, which hold where it is taken if settings decide that, else everywhere."""
        for r in required:
            guarded = node("select", condition, r.condition, const(True))
            self.required[r if condition.stage is Stage.FIELD else replace(r, condition=guarded)] = None

    def contract(self, message: str, span: Span, others: tuple[Label, ...], hint: str) -> int:
        """A condition over space; its number names it in `ensure` nodes."""
        asked = Requirement(const(True), message, self.users_place(span), others, hint=hint)
        number = self._numbers.setdefault(asked, len(self._numbers))
        self.found.contracts[number] = asked
        return number

    def record(self, function: Function, arguments: Mapping[str, Value], site: Span) -> None:
        """Note a call that stands in the user's text, in the order of evaluation, each place once."""
        if not site.source.prelude:
            called = CallRecord(function.name, function.definition, dict(arguments), site)
            self.journal.note(self, Context._record, called)

    def _record(self, called: CallRecord) -> None:
        if called.span not in self._recorded:
            self._recorded.add(called.span)
            list.append(self.found.calls, called)

    def suspect(self, suspicion: Suspicion, often: int = 1) -> None:
        """Note what values may show to be a mistake, the first times that a place gives rise to it: a list may come by
        it often."""
        if not suspicion.span.source.prelude:
            self.journal.note(self, Context._suspect, suspicion, often)

    def _suspect(self, suspicion: Suspicion, often: int) -> None:
        same = self._suspected.setdefault((suspicion.what, suspicion.span), [])
        if len(same) < often and not any(s.nodes[:2] == suspicion.nodes[:2] for s in same):
            same.append(suspicion)
            list.append(self.found.suspicions, suspicion)

    def task(self, asked: Node, site: Span) -> Node:
        """Note where a task is asked for."""
        self.found.tasks.setdefault((asked, self.users_place(site)))
        return asked

    @contextmanager
    def solving(self) -> Iterator[int]:
        """While the function of a `solve` is looked at: by how many it is surrounded, which names what it looks for."""
        self._solves += 1
        try:
            yield self._solves - 1
        finally:
            self._solves -= 1

    def users_place(self, span: Span) -> Span:
        """The place itself, or the user's call that led into the prelude."""
        if span.source.prelude:
            return next((site for _, site in reversed(self.call_stack) if not site.source.prelude), span)
        return span
