"""A program, as compiling gives it, and a design: a program with its settings bound, once.

What is asked of a part is asked of a design. It finds what its roots read (porosities, loaded fields) when they are
asked for, and nothing else; the work itself is in free functions that take a design (see `doors`).
"""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np

from porelang import outputs
from porelang.analysis.box import Extent
from porelang.analysis.enclose import enclose
from porelang.bound import Bindable, Within, array_bound, no_idle_options, no_such_data, samples_of
from porelang.contracts import doubtful_contracts
from porelang.data import Data, Reduced, SampledField, Triple
from porelang.diagnostics import MOST_DIAGNOSTICS, Diagnostic, PoreError, in_order
from porelang.doors import Doors, Settings, options
from porelang.doubts import borne_out, of_data
from porelang.doubts.data import SAMPLES, specks, strays
from porelang.doubts.elsewhere import Reading, sources
from porelang.doubts.margins import thin_margins
from porelang.elaborate.context import Bound
from porelang.elaborate.results import DataInfo, Elaborated, Listed, Output, ParamInfo, Requirement
from porelang.elaborate.values import Scalar
from porelang.extents import Cut, part_extent
from porelang.formula import Bindings, Formula
from porelang.html import brief, table, title
from porelang.interval import interval
from porelang.ir import NUMBERS, TASKS, UNKNOWN, Node, node, order, param, unmoved, within
from porelang.once import Recent
from porelang.ops import TASK_TABLE
from porelang.ops.studies import number_of
from porelang.rewrites import Graph, flatten
from porelang.settings import Setting, given, settle
from porelang.source import Source, Span
from porelang.tasks.bake import region
from porelang.tasks.resolve import all_read, bind_files, bind_tasks, find, look
from porelang.tasks.run import LOOKERS, READERS, within_of
from porelang.tasks.telling import TELL, told
from porelang.units import RATIO


class Again(Protocol):
    """Makes a program anew from its texts: with params fixed, data bound, what is held of it, `more` text before it."""

    def __call__(
        self,
        structure: Mapping[str, float],
        bound: Mapping[str, Bound],
        held: Mapping[Node, SampledField],
        more: str = "",
        /,
    ) -> Program: ...


@dataclass(frozen=True, eq=False)
class Program(Doors):
    """A program without errors. `said` is what compiling has warned of; `graph` is what the rewrites make of `written`.

    `structure` are the params that something is counted or picked by, fixed at a value each; `again` makes the program
    anew from its texts for other values, or for these wherever it is unpickled; `used` are those of the files it uses.
    `bound` says of params that take data what they have, `held` is what of it is in memory.
    """

    source: Source
    params: Mapping[str, ParamInfo]
    outputs: Mapping[str, Output]
    said: tuple[Diagnostic, ...]
    written: Graph
    graph: Graph
    elaborated: Elaborated
    structure: Mapping[str, float]
    again: Again
    used: Mapping[str, Source]
    bound: Mapping[str, Bound]
    held: Mapping[Node, SampledField]
    # the designs asked for last, so that what one has found is not found again at the next call
    _designs: Recent[Design] = dataclasses.field(default_factory=Recent, init=False, repr=False)
    _variants: Recent[Program] = dataclasses.field(default_factory=Recent, init=False, repr=False)

    def __repr__(self) -> str:
        outputs = ", ".join(self.outputs) or "no output"
        params = f" of {', '.join(self.params)}" if self.params else ""
        return f"<program {self.source.name}: {brief(outputs + params)}>"

    def _repr_html_(self) -> str:
        shown = [title(f"program {self.source.name}")]
        shown += [Listed(some)._repr_html_() for some in (self.params, self.outputs) if some]
        return "".join([*shown, *(d._repr_html_() for d in self.warnings)])

    def __reduce__(self) -> tuple[Callable[..., Program], tuple[Any, ...]]:
        return self.again, (dict(self.structure), dict(self.bound), dict(self.held))

    @property
    def presets(self) -> dict[str, dict[str, Setting]]:
        """The named sets of params, as settings."""
        return {name: dict(preset.settings) for name, preset in self.elaborated.presets.items()}

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """The range of every param in base units."""
        return {name: (info.low, info.high) for name, info in self.params.items()}

    @property
    def files(self) -> tuple[str, ...]:
        """The files that it comes from: its own (or the name of its text), those that it uses, and its data."""
        reads = (n.value for n in order(self.graph.roots) if n.op in READERS and isinstance(n.value, tuple))
        # a cell by its name is one word, and one of listed bars has none
        data = (str(value[1]) for value in reads if value[0] and len(value) > 1)
        return tuple(dict.fromkeys([self.source.name, *(s.name for s in self.used.values()), *data]))

    @cached_property
    def places(self) -> dict[Node, Span]:
        """Where each task of the flat graph is asked for in the text; of several places the first."""
        out: dict[Node, Span] = {}
        for n, (_, span) in zip(self.graph.tasks, self.elaborated.tasks, strict=True):
            out.setdefault(n, span)
        return out

    @cached_property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """All that is doubtful, in the order of its places: what compiling has warned of, and what values show with the
        params at their defaults: contracts on fields that break, and what was suspected. It is sampled when it is first
        asked for."""
        graph, out = self.graph, self.elaborated
        solids = [root for roots in graph.outputs.values() for root in roots]
        bindings: Bindings = {**{param(k): v for k, v in settle(out.params, {}).items()}, **self.held}
        shown = [*doubtful_contracts(graph.contracts, out.contracts, solids, bindings), *borne_out(out, bindings)]
        return tuple(in_order([*self.said, *shown][:MOST_DIAGNOSTICS], self.source))

    @cached_property
    def _flat_tasks(self) -> dict[Node, Node]:
        """The task of the flat graph that each became that was written."""
        return {n: flat for (n, _), flat in zip(self.elaborated.tasks, self.graph.tasks, strict=True)}

    def output(self, name: str | None = None) -> str:
        """The name of an output: the one asked for, else `part`, else the only one. Errors: E100."""
        return outputs.chosen(self.elaborated, self.source, name)

    def roots(self, name: str | None = None) -> tuple[Node, ...]:
        """The flat roots of an output: one, or three for a vector."""
        return self.graph.outputs[self.output(name)]

    def solid(self, name: str | None = None) -> Node:
        """The flat root of an output that is a number. Errors: E101 for a vector or a condition."""
        name = self.output(name)
        outputs.must_be_solid(self.outputs[name], name)
        return self.graph.outputs[name][0]

    def field_roots(self, name: str | None = None) -> tuple[Node, ...]:
        """The flat roots of an output, or of a `let` that is a number. Errors: E100."""
        if name is None or name in self.outputs:
            return self.roots(name)
        found = self.named(name)
        if found is None:
            raise outputs.no_number(self.elaborated, name)
        return (found,)

    def named(self, name: str) -> Node | None:
        """The flat root of an output or a let that is a number; None where there is no such thing."""
        if name in self.outputs:
            return self.solid(name)
        let = self.elaborated.lets.get(name)
        return None if let is None else flatten(let.node)[0]

    @cached_property
    def studies(self) -> Mapping[str, Node]:
        """The flat tasks of the studies that a `let` names, by that name."""
        return {name: flatten(n)[0] for name, n in self.elaborated.studies.items()}

    @property
    def data(self) -> Mapping[str, DataInfo]:
        """The params that take data (`param stress: field = ...`), by name; `bind` gives them some."""
        return self.elaborated.data

    def bind(
        self,
        fields: Mapping[str, Bindable] | None = None,
        /,
        *,
        voxel: float | str | None = None,
        within: Within | None = None,
        **more: Bindable,
    ) -> Program:
        """The program with data for its params `param stress: field = ...`, in base units (mm, rad, N, MPa).

        Data are a `SampledField`; or a function of points (n, 3) in mm, which is sampled every `voxel` over `within`,
        the corners `((x0, y0, z0), (x1, y1, z1))` of a box or the name of an output or a `let` that is a solid; or an
        array (nx, ny, nz) whose nodes span `within`, (nx, ny, nz, 3) for a vector; or a text `"FILE:ARRAY"`, which is
        read as `--bind` has it. Beyond their ends they go on as at the boundary. What else is bound stays.
        Errors: E155, and those of what it makes of the program.
        """
        given = {**(fields or {}), **more}
        bound, held = dict(self.bound), dict(self.held)
        box = within if not isinstance(within, str) else self._box(within)
        for name, data in given.items():
            if name not in self.data:
                raise PoreError(no_such_data(name, self.data, self.params))
            if isinstance(data, str):
                bound[name] = ("load", *array_bound(self.data[name], data))
                continue
            made = samples_of(self.data[name], data, voxel, box)
            bound[name] = ("bound", made.digest)
            held[node("bound", value=(made.digest,))] = made
        no_idle_options(self.data, given, voxel, within)
        read = {node("bound", value=tuple(payload)) for op, *payload in bound.values() if op == "bound"}
        return self.again(self.structure, bound, {n: held[n] for n in held if n in read})

    def also(self, text: str) -> Program:
        """The program with more text before its own. Errors: what is wrong with that."""
        return self.again(self.structure, self.bound, self.held, text)

    def _box(self, name: str) -> tuple[Triple, Triple]:
        """The corners of the box of an output, or of a `let` that is a solid."""
        box = region(self.design().formula(*self.field_roots(name)), "what is bound")
        return box.lo, box.hi

    def design(self, settings: Settings | None = None, *, preset: str | None = None, **more: Setting) -> Design:
        """The program with settings bound: numbers in base units, or texts with a unit; the others are those of the
        preset, or the defaults.

        A param that is called like an option of some method is set in the mapping. Errors: E083-E085 about settings,
        E088 where there is no such preset, E064 where a contract breaks. A value between two steps of its param is a
        `PoreWarning` (W219).
        """
        return self._designed(settle(self.params, given(self.elaborated, settings, preset, more, options())))

    def _designed(self, values: Mapping[str, float]) -> Design:
        structure = {name: values[name] for name in self.structure}
        if structure != self.structure:
            variant = self._variant(structure)
            return variant._designed(settle(variant.params, values))
        if self._reads_files:  # which may be others by now
            return Design(self, values)
        return self._designs.get(tuple(values.values()), lambda: Design(self, values))

    def _variant(self, structure: Mapping[str, float]) -> Program:
        """The program as it is for other values of what counts and picks. Errors: what is wrong with it there."""

        def make() -> Program:
            try:
                return self.again(structure, self.bound, self.held)
            except PoreError as error:
                changed = [(n, v) for n, v in structure.items() if v != self.structure[n]]
                where = " and ".join(f"{n} = {self.params[n].shown(v)}" for n, v in changed)
                hint = f"narrow the range of {', '.join(f'`{n}`' for n, _ in changed)}"
                told = [
                    dataclasses.replace(
                        d, message=f"{d.message}, with {where}", hint=hint if d.code == "E070" else d.hint
                    )
                    for d in error.diagnostics
                ]
                raise PoreError(told) from None

        return self._variants.get(tuple(structure.values()), make)

    @cached_property
    def _reads_files(self) -> bool:
        return any(n.op in READERS for n in order(self.graph.roots))

    def reduced(
        self, settings: Settings | None = None, preset: str | None = None, **more: Setting
    ) -> dict[str, Reduced]:
        """The numbers found from whole fields (`porosity(...)`, ...), by the text that asks for them, with their
        errors, whether or not the contracts hold that are about them. What one text in a def asks for in several calls
        is counted: `porosity(f, c)`, `porosity(f, c) #2`."""
        design = self.design(settings, preset=preset, **more)
        made = design.program  # another than this one where a param counts what is there
        read = set(design.reads(*made._asking))
        return {text: design.number(n) for n, text in made.numbers.items() if n in read}

    @cached_property
    def _asking(self) -> tuple[Node, ...]:
        """All roots that may ask for numbers: of outputs, checks and contracts."""
        graph = self.graph
        several = (r for roots in graph.outputs.values() for r in roots)
        return (*several, *graph.requirements, *graph.checks, *(c for _, c in graph.contracts))

    @cached_property
    def numbers(self) -> dict[Node, str]:
        """The numbers found from fields that outputs, checks and contracts read, each by a text of its own."""
        out: dict[Node, str] = {}
        seen: dict[str, int] = {}
        for n in order(self._asking, within):
            if n.op in NUMBERS and n.depends < UNKNOWN:  # else it is another for every guess of a `solve`
                text = " ".join(self.places[n].text.split()) if n in self.places else n.op
                text += f".{name}" if (name := number_of(n)) else ""  # of a study, which is what has the place
                seen[text] = seen.get(text, 0) + 1
                out[n] = text if seen[text] == 1 else f"{text} #{seen[text]}"
        return out

    @cached_property
    def units(self) -> dict[Node, str]:
        """What the numbers found from fields are measured in, as far as an expression of the text tells."""
        known = {v.node: v.dimension for v in self.elaborated.values.values() if isinstance(v, Scalar)}
        flat = zip(self.elaborated.tasks, self.graph.tasks, strict=True)
        found = {n: known.get(written) for (written, _), n in flat if n in self.numbers}
        return {n: d.called.replace("^", "") for n, d in found.items() if d not in (None, RATIO)}


class Design(Doors):
    """A program with its settings bound, once. What its roots read is found when they are asked for, and remembered.

    `settings` has the number of every param in base units. A design never changes; threads may share it.
    """

    def __init__(self, program: Program, settings: Mapping[str, float], files: Mapping[Node, Data] | None = None):
        """`files` is what has been read already, by the tasks that read it: a design goes on with that."""
        self.program = program
        self.settings: Mapping[str, float] = MappingProxyType(dict(settings))
        numbers = {param(name): value for name, value in self.settings.items()}
        self._bindings: Bindings = {**numbers, **program.held, **(files or {})}
        self._extents: dict[str, Extent] = {}
        self._kept: set[int] = set()  # contracts that were found to hold
        self._lock = threading.RLock()
        self._keep_contracts(lambda i, root: not _about(root))

    def __repr__(self) -> str:
        set_to = ", ".join(f"{name} = {self.program.params[name].shown(v)}" for name, v in self.settings.items())
        return f"<design of {self.program.source.name}{': ' if set_to else ''}{brief(set_to)}>"

    def _repr_html_(self) -> str:
        infos = self.program.params
        rows = [(name, infos[name].shown(v), infos[name].range, infos[name].doc) for name, v in self.settings.items()]
        heads = ("param", "set to", "range", "what it is")
        return title(f"design of {self.program.source.name}") + (table(heads, rows) if rows else "")

    def __reduce__(self) -> tuple[type[Design], tuple[Program, dict[str, float], dict[Node, Any]]]:
        files = {n: v for n, v in self._bindings.items() if n.op in READERS}
        return Design, (self.program, dict(self.settings), files)

    def design(self, settings: Settings | None = None, *, preset: str | None = None, **more: Setting) -> Design:
        """This design, or the one with something else set as well. Errors: those of `Program.design`."""
        program = self.program
        changed = given(program.elaborated, settings, preset, more, options())
        return program._designed(settle(program.params, {**self.settings, **changed})) if changed else self

    # ---- what is bound ----------------------------------------------------------------------------------------------

    def formula(self, *roots: Node) -> Formula:
        """Flat roots with all that they read bound: settings, and what their tasks find, computed now if need be.

        Errors: those of the tasks, at the place in the program that asks; E064 where what was found breaks a contract.
        """
        try:
            filled = bind_tasks(roots, self._with_files(roots), self.program.places)
        except PoreError:  # for a number that breaks a contract, perhaps: that is what is wrong then
            read = frozenset(self.reads(*roots))
            self._keep_contracts(lambda i, root: self._concerns(i, root, read), as_far_as_found=True)
            raise
        with self._lock:  # None, for what is not read, is for this formula alone
            self._bindings = {**self._bindings, **{n: v for n, v in filled.items() if v is not None}}
        read = frozenset(self.reads(*roots))
        self._keep_contracts(lambda i, root: self._concerns(i, root, read))
        return Formula(roots, filled)

    def _with_files(self, roots: Sequence[Node]) -> Bindings:
        """What is bound, with the files that roots read: a design goes on with what was in one when it was read."""
        found = bind_files(roots, self._bindings, self.program.places)
        with self._lock:  # what another thread has read meanwhile stays
            self._bindings = {**found, **self._bindings}
            return self._bindings

    def of(self, name: str | None = None) -> Formula:
        """An output that is a number, as a formula. Errors: E100, E101, and those of its tasks."""
        return self.formula(self.program.solid(name))

    def read_data(self, measure: bool = True) -> None:
        """Read every file that the program names, so that what is wrong with one is said now; without `measure` of
        those that take long the beginning. Errors: theirs."""
        for n in order(self.program.graph.roots):
            if n.op in LOOKERS and not measure:
                look(n, self.program.places)
            elif n.op in READERS:
                self.task(n)

    def task(self, n: Node) -> Reduced | Data:
        """What a task of the flat graph finds, whether or not contracts hold that are about it."""
        return find(n, self._with_files([n]), self.program.places)

    def number(
        self, name: str | Node, /, settings: Settings | None = None, preset: str | None = None, **more: Setting
    ) -> Reduced:
        """An output or a `let` that is one number; or the number that a task finds. With its error."""
        if not isinstance(name, Node):
            return super().number(name, settings, preset, **more)
        found = self.task(name)
        assert isinstance(found, Reduced)
        return found

    def valued(self, root: Node) -> Reduced:
        """The value of a flat root that is one number, and how far it may be off: for all values that the numbers which
        it reads may have within their errors. Errors: those of its tasks."""
        if root.op in NUMBERS:
            return self.number(root)
        formula = self.formula(root)
        value, numbers = float(formula.numbers[0]), self.own_numbers(root)
        if all(not r.error for r in numbers.values()):
            return Reduced(value, 0.0)
        reach = enclose(formula.bind(_ranges(numbers)))[0].range
        return Reduced(value, max(float(np.max(reach.hi)) - value, value - float(np.min(reach.lo))))

    def own_numbers(self, root: Node) -> dict[Node, Reduced]:
        """The numbers found from fields that stand in a root itself, of the branches that are taken."""
        read = set(self.reads(root))
        return {n: self.number(n) for n in order([root], within) if n in read and n.op in NUMBERS}

    def decided(self, root: Node) -> bool | None:
        """Whether a condition holds for all values that its numbers may have; None where their errors leave it open."""
        numbers = self.own_numbers(root)
        if all(not r.error for r in numbers.values()):
            return self.holds(root)
        reach = enclose(self.formula(root).bind(_ranges(numbers)))[0].range
        return True if bool((reach.lo >= 1).all()) else False if bool((reach.hi < 1).all()) else None

    def keep_contracts(self) -> None:
        """Refuse what breaks a contract about settings and numbers, whatever output reads them. Errors: E064."""
        self._keep_contracts(lambda i, root: True)

    def _keep_contracts(self, concerned: Callable[[int, Node], bool], as_far_as_found: bool = False) -> None:
        """Refuse what breaks one of the contracts that are concerned, by index and condition; `as_far_as_found` leaves
        out those about numbers that cannot be found. Errors: E064."""
        broken: list[Requirement] = []
        for i, root in enumerate(self.program.graph.requirements):
            # one that is about the guesses of a `solve` is about nothing that is there
            if i in self._kept or root.depends >= UNKNOWN or not concerned(i, root):
                continue
            try:
                bindings = bind_tasks([root], self._with_files([root]), self.program.places)
            except PoreError:
                if as_far_as_found:
                    continue
                raise
            if Formula((root,), bindings).numbers[0]:
                with self._lock:
                    self._kept.add(i)
            else:
                broken.append(self.program.elaborated.requirements[i])
        if broken:
            raise PoreError(
                [Diagnostic("E064", r.message, r.span, "not with these settings", r.others) for r in broken]
            )

    def _concerns(self, i: int, root: Node, read: frozenset[Node]) -> bool:
        """Whether a condition is about settings alone, or about a task among those `read`."""
        solve = self.program.elaborated.requirements[i].solve  # a condition may be on a number of what it finds
        if solve is not None and self.program._flat_tasks[solve] in read:
            return True
        about = _about(root)
        return not about or any(n in read for n in about)

    def reads(self, *roots: Node) -> list[Node]:
        """The tasks that roots read with these settings, and those that these read: none of a branch not taken."""
        return all_read(roots, self._bindings, self.program.places)

    def told(self, *roots: Node, measure: bool = True) -> list[Diagnostic]:
        """What the tasks that roots read tell of what they found: notes and warnings, at the places that ask for them;
        and what is doubtful of lattices that read them.

        They are found if need be: without `measure` only those that take no time. Errors: theirs.
        """
        out: dict[Diagnostic, None] = {}
        read = self.reads(*roots) if measure else [n for n in order(roots) if n.op in TASKS]
        known = {n for n in read if n.depends < UNKNOWN and (measure or _takes_no_time(n))}
        for n in read:
            if n in known and n.op in TELL:
                out.update(dict.fromkeys(told(n, self.task(n), self.program.places.get(n))))
        readings = list(self._readings(roots, measure))
        found = [d for look in (strays, thin_margins) for d in look(readings, self.program.places)]
        seen = {d.span for d in found}
        direct = [n for n in order(roots) if n.op in READERS and (measure or TASK_TABLE[n.op].cost == "instant")]
        small = specks(roots, {n: self._bindings[n] for n in direct if n in self._bindings}, self.program.places)
        late = of_data(self.program.elaborated, self.formula, known, self.program.warnings)
        return list(dict.fromkeys([*out, *found, *(d for d in small if d.span not in seen), *late]))

    def _readings(self, roots: Sequence[Node], measure: bool) -> Iterator[Reading]:
        """The solids among roots, and what their tasks look at within others; without `measure` what takes no time."""
        graph, outputs = self.program.graph, self.program.outputs
        solids = {graph.outputs[name][0] for name, output in outputs.items() if output.solid}
        asked: list[tuple[tuple[Node, ...], Node, Node | None]] = [((r,), r, None) for r in roots if r in solids]
        for n in self.reads(*roots) if measure else order(roots):
            if n.op in TASKS and n.depends < UNKNOWN and (region := within_of(n)) is not None:
                asked.append((n.args, region, n))
        for fields, body, task in asked:
            read = order([*fields, body])
            if not any(n.op in SAMPLES or n.op == "mesh" for n in read):
                continue
            if measure or all(TASK_TABLE[n.op].cost == "instant" for n in read if n.op in TASKS):
                known = [f for n in read if n.depends < UNKNOWN for f in sources(n)]
                yield Reading(fields, body, self.formula(*fields, body, *known).bindings, task)

    def holds(self, root: Node) -> bool:
        """Whether a condition on settings and numbers holds; what it reads is found first."""
        return bool(self.formula(root).numbers[0])

    def extent(self, name: str | None = None, /) -> Extent:
        """How far an output's solid reaches, in mm, and how surely. Errors: those of `bounds`."""
        chosen = self.program.output(name)
        if chosen not in self._extents:
            output = self.program.outputs[chosen]
            self._extents[chosen] = part_extent(chosen, self.of(chosen), output.span, lambda: self._cut(output))
        return self._extents[chosen]

    def _cut(self, output: Output) -> Cut | None:
        """Of an output that is one solid cut by another, or an inward offset, which, and where that is written."""
        for s in self.program.elaborated.suspicions:
            if s.what == "empty" and s.nodes[0] in [unmoved(n) for n in output.nodes]:
                return Cut(s.name, s.span, s.argument, self.formula(*flatten(s.nodes[1])))
            if s.what == "apart" and node("max", *s.nodes) in output.nodes:
                return Cut(s.name, s.span, s.argument, self.formula(*flatten(s.nodes[0])))
        return None


def _ranges(numbers: Mapping[Node, Reduced]) -> Bindings:
    return {n: interval(r.value - r.error, r.value + r.error) for n, r in numbers.items()}


def _takes_no_time(task: Node) -> bool:
    """Whether a task is found at once, and so are those that it reads."""
    return all(TASK_TABLE[n.op].cost == "instant" for n in order([task]) if n.op in TASKS)


def _about(root: Node) -> list[Node]:
    """The tasks that a condition is about."""
    return [n for n in order([root], within) if n.op in TASKS]
