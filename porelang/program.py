"""A program, as compiling gives it, and a design: a program with its settings bound, once.

What is asked of a part is asked of a design. It finds what its roots read (porosities, loaded fields) when they are
asked for, and nothing else; the work itself is in free functions that take a design. The methods of a `Program` are
doors: they bind settings and hand on.
"""

from __future__ import annotations

import dataclasses
import struct
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from porelang.analysis.box import Box, Extent, extent_of, reach, unbounded_axes
from porelang.backends.numpy import Dtype, NumpyField
from porelang.data import WORLD, Data, Reduced
from porelang.diagnostics import Diagnostic, PoreError, fail, suggest
from porelang.elaborate.results import Elaborated, Output, ParamInfo, Requirement
from porelang.elaborate.values import Scalar, Vector
from porelang.field import Backend, Bounds, Field, make_field
from porelang.formula import Bindings, Formula
from porelang.ir import NUMBERS, TASKS, UNKNOWN, Node, order, param, within
from porelang.rewrites import Graph, flatten
from porelang.settings import Setting, settle
from porelang.source import Source, Span
from porelang.tasks import all_read, bind_files, bind_tasks, find
from porelang.tasks.run import READERS

Settings = Mapping[str, Setting]
#: Designs that a program remembers.
_DESIGNS = 8


@dataclass(frozen=True, eq=False)
class Program:
    """A program without errors. `warnings` says what is doubtful; `graph` is what the rewrites make of `written`.

    `again` makes it anew from its texts, wherever it is unpickled.
    """

    source: Source
    params: Mapping[str, ParamInfo]
    outputs: Mapping[str, Output]
    warnings: tuple[Diagnostic, ...]
    written: Graph
    graph: Graph
    elaborated: Elaborated
    again: tuple[Callable[..., Program], tuple[Any, ...]]
    # the designs asked for last, so that what one has found is not found again at the next call
    _designs: dict[bytes, Design] = dataclasses.field(default_factory=dict, init=False, repr=False)
    _lock: threading.Lock = dataclasses.field(default_factory=threading.Lock, init=False, repr=False)

    def __repr__(self) -> str:
        outputs = ", ".join(self.outputs) or "no output"
        params = f" of {', '.join(self.params)}" if self.params else ""
        return f"<program {self.source.name}: {outputs}{params}>"

    def __reduce__(self) -> tuple[Callable[..., Program], tuple[Any, ...]]:
        return self.again

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """The range of every param in base units."""
        return {name: (info.low, info.high) for name, info in self.params.items()}

    @cached_property
    def places(self) -> dict[Node, Span]:
        """Where each task of the flat graph is asked for in the text; of several places the first."""
        out: dict[Node, Span] = {}
        for n, (_, span) in zip(self.graph.tasks, self.elaborated.tasks, strict=True):
            out.setdefault(n, span)
        return out

    def output(self, name: str | None = None) -> str:
        """The name of an output: the one asked for, else `part`, else the only one. Errors: E100."""
        if name is None:
            if "part" in self.outputs:
                return "part"
            if len(self.outputs) == 1:
                return next(iter(self.outputs))
            if not self.outputs:
                raise fail(
                    "E100",
                    "the program has no output",
                    Span(self.source, 0, 0),
                    hint="end it with an expression, or write `out part = ...`",
                )
            raise fail(
                "E100",
                "the program has several outputs, and none is called `part`",
                hint=f"choose one of {', '.join(self.outputs)} with --out NAME",
            )
        if name not in self.outputs:
            near = suggest(name, self.outputs)
            hint = f"did you mean `{near}`?" if near else f"it has {', '.join(self.outputs) or 'none'}"
            raise fail("E100", f"the program has no output `{name}`", hint=hint)
        return name

    def roots(self, name: str | None = None) -> tuple[Node, ...]:
        """The flat roots of an output: one, or three for a vector."""
        return self.graph.outputs[self.output(name)]

    def solid(self, name: str | None = None) -> Node:
        """The flat root of an output that is a number. Errors: E101 for a vector or a condition."""
        name = self.output(name)
        output = self.outputs[name]
        if not isinstance(output.value, Scalar):
            what = "a vector" if isinstance(output.value, Vector) else "a condition"
            raise fail(
                "E101",
                f"the output `{name}` is {what}, which has no surface",
                output.span,
                hint="a solid is a number that is negative inside",
            )
        return self.graph.outputs[name][0]

    def named(self, name: str) -> Node | None:
        """The flat root of an output or a let that is a number; None where there is no such thing."""
        if name in self.outputs:
            return self.solid(name)
        let = self.elaborated.lets.get(name)
        return None if let is None else flatten(let.node)[0]

    def design(self, settings: Settings | None = None, **more: Setting) -> Design:
        """The program with settings bound: numbers in base units, or texts with a unit; the others are the defaults.

        A param that is called like an option of some method is set in the mapping. Errors: E083-E085 about settings,
        E064 where a contract breaks.
        """
        if twice := sorted(set(settings or {}) & set(more)):
            raise fail("E084", f"`{twice[0]}` is set twice", hint="in the mapping or by its name, not both")
        values = settle(self.params, {**(settings or {}), **more})
        if self._reads_files:  # which may be others by now
            return Design(self, values)
        key = struct.pack(f"{len(values)}d", *values.values())  # -0 is not 0
        with self._lock:
            found = self._designs.pop(key, None)
        found = found or Design(self, values)
        with self._lock:
            self._designs[key] = found
            if len(self._designs) > _DESIGNS:
                del self._designs[next(iter(self._designs))]
        return found

    @cached_property
    def _reads_files(self) -> bool:
        return any(n.op in READERS for n in order(self.graph.roots))

    def field(
        self,
        name: str | None = None,
        /,
        backend: Backend = "numpy",
        dtype: Dtype | None = None,
        threads: int | None = None,
        settings: Settings | None = None,
        **more: Setting,
    ) -> Field:
        """An output as a function of points (n, 3) in mm, with values (n,), or (n, 3) for a vector.

        Settings are params by name: numbers in base units or texts with a unit. `dtype` is f64 unless told otherwise,
        and f32 with `backend="glsl"`.

        >>> import porelang
        >>> program = porelang.compile("sphere(10)")
        >>> program.field("part")([[0, 0, 0], [10, 0, 0]])
        array([-10.,   0.])
        """
        return self.design(settings, **more).field(name, backend, dtype, threads)

    def bounds(self, name: str | None = None, /, settings: Settings | None = None, **more: Setting) -> Box:
        """The box that holds an output's solid, in mm. Errors: E102 where it has no end, E103 where it is empty."""
        return self.design(settings, **more).bounds(name)

    def mesh(
        self,
        name: str | None = None,
        /,
        voxel: float | None = None,
        resolution: int | None = None,
        bounds: Bounds | None = None,
        backend: Backend = "numpy",
        dtype: Dtype = "f32",
        smooth: bool = False,
        sharp: bool = False,
        simplify: float | None = None,
        settings: Settings | None = None,
        **more: Setting,
    ) -> Any:
        """The surface of an output as a `trimesh.Trimesh` in mm, watertight, normals outward.

        `voxel` is the grid spacing in mm; or `resolution` counts samples along the longest side (128 if neither is
        given). `smooth` moves vertices onto the field, `sharp` makes rims edges of the mesh, `simplify` (mm) takes
        out triangles that matter less than that.
        """
        return self.design(settings, **more).mesh(
            name, voxel, resolution, bounds, backend, dtype, smooth, sharp, simplify
        )

    def measure(
        self,
        name: str | None = None,
        /,
        within: str | None = None,
        voxel: float | None = None,
        resolution: int | None = None,
        settings: Settings | None = None,
        **more: Setting,
    ) -> dict[str, Any]:
        """Volume, porosity, area, components and topology of an output, each with its error under `"error"`.

        `within` names the envelope: an output or a let. The keys are those of `pore measure`; mm, mm^2, mm^3.
        """
        return self.design(settings, **more).measure(name, within, voxel, resolution)

    def reduced(self, settings: Settings | None = None, **more: Setting) -> dict[str, Reduced]:
        """The numbers found from whole fields (`porosity(...)`, ...), by the text that asks for them, with their
        errors, whether or not the contracts hold that are about them. What one text in a def asks for in several calls
        is counted: `porosity(f, c)`, `porosity(f, c) #2`."""
        design = self.design(settings, **more)
        read = set(design.reads(*self._asking))
        return {text: design.number(n) for n, text in self.numbers.items() if n in read}

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
                seen[text] = seen.get(text, 0) + 1
                out[n] = text if seen[text] == 1 else f"{text} #{seen[text]}"
        return out


class Design:
    """A program with its settings bound, once. What its roots read is found when they are asked for, and remembered.

    `settings` has the number of every param in base units. A design never changes; threads may share it.
    """

    def __init__(self, program: Program, settings: Mapping[str, float], files: Mapping[Node, Data] | None = None):
        """`files` is what has been read already, by the tasks that read it: a design goes on with that."""
        self.program = program
        self.settings: Mapping[str, float] = MappingProxyType(dict(settings))
        self._bindings: Bindings = {**{param(name): value for name, value in self.settings.items()}, **(files or {})}
        self._extents: dict[str, Extent] = {}
        self._kept: set[int] = set()  # contracts that were found to hold
        self._lock = threading.RLock()
        self._keep_contracts(lambda i, root: not _about(root))

    def __repr__(self) -> str:
        set_to = ", ".join(f"{name} = {self.program.params[name].shown(v)}" for name, v in self.settings.items())
        return f"<design of {self.program.source.name}{': ' if set_to else ''}{set_to}>"

    def __reduce__(self) -> tuple[type[Design], tuple[Program, dict[str, float], dict[Node, Any]]]:
        files = {n: v for n, v in self._bindings.items() if n.op in READERS}
        return Design, (self.program, dict(self.settings), files)

    # ---- what is bound ----------------------------------------------------------------------------------------------

    def formula(self, *roots: Node) -> Formula:
        """Flat roots with all that they read bound: settings, and what their tasks find, computed now if need be.

        Errors: those of the tasks, at the place in the program that asks; E064 where what was found breaks a contract.
        """
        filled = bind_tasks(roots, self._with_files(roots), self.program.places)
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

    def read_data(self) -> None:
        """Read every file that the program names, so that what is wrong with one is said now. Errors: theirs."""
        for n in order(self.program.graph.roots):
            if n.op in READERS:
                self.task(n)

    def task(self, n: Node) -> Reduced | Data:
        """What a task of the flat graph finds, whether or not contracts hold that are about it."""
        return find(n, self._with_files([n]), self.program.places)

    def number(self, n: Node) -> Reduced:
        """The number that a task finds, with its error."""
        found = self.task(n)
        assert isinstance(found, Reduced)
        return found

    def keep_contracts(self) -> None:
        """Refuse what breaks a contract about settings and numbers, whatever output reads them. Errors: E064."""
        self._keep_contracts(lambda i, root: True)

    def _keep_contracts(self, concerned: Callable[[int, Node], bool]) -> None:
        """Refuse what breaks one of the contracts that are concerned, by index and condition. Errors: E064."""
        broken: list[Requirement] = []
        for i, root in enumerate(self.program.graph.requirements):
            # one that is about the guesses of a `solve` is about nothing that is there
            if i in self._kept or root.depends >= UNKNOWN or not concerned(i, root):
                continue
            bindings = bind_tasks([root], self._with_files([root]), self.program.places)
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
        if solve is not None and self.program.graph.tasks[solve] in read:
            return True
        about = _about(root)
        return not about or any(n in read for n in about)

    def reads(self, *roots: Node) -> list[Node]:
        """The tasks that roots read with these settings, and those that these read: none of a branch not taken."""
        return all_read(roots, self._bindings, self.program.places)

    def holds(self, root: Node) -> bool:
        """Whether a condition on settings and numbers holds; what it reads is found first."""
        return bool(self.formula(root).numbers[0])

    # ---- what can be asked ------------------------------------------------------------------------------------------

    def field(
        self,
        name: str | None = None,
        /,
        backend: Backend = "numpy",
        dtype: Dtype | None = None,
        threads: int | None = None,
    ) -> Field:
        """An output as a function of points; see `Program.field`."""
        dtype = dtype or ("f32" if backend == "glsl" else "f64")
        return make_field(self.formula(*self.program.roots(name)), self.program.ranges, backend, dtype, threads)

    def bounds(self, name: str | None = None, /) -> Box:
        """The box of an output's solid, in mm: nothing of it lies outside, and it ends at the faces to within
        `extent(name).error`. Errors: E102 where it has no end, E103 where it is empty."""
        return self.extent(name).outer

    def extent(self, name: str | None = None, /) -> Extent:
        """How far an output's solid reaches, in mm, and how surely. Errors: those of `bounds`."""
        chosen = self.program.output(name)
        if chosen not in self._extents:
            self._extents[chosen] = self._extent(chosen)
        return self._extents[chosen]

    def _extent(self, name: str) -> Extent:
        formula, span = self.of(name), self.program.outputs[name].span
        extent = extent_of(formula)
        if (extent is None or unbounded_axes(extent.outer)) and (end := reach(formula)) is not None:
            raise fail(
                "E117", f"`{name}` lies more than 100 m from the origin, as far as {end:,.0f} mm", span, hint=WORLD
            )
        if extent is None:
            raise _empty(name, formula, span)
        box = extent.outer
        if min(box.size) <= 0:
            flat = ", ".join(axis for axis, size in zip("xyz", box.size, strict=True) if size <= 0)
            raise fail(
                "E103", f"`{name}` holds no material: it has no thickness along {flat}", span, hint="give it some"
            )
        if axes := unbounded_axes(box):
            raise fail(
                "E102",
                f"`{name}` has no end along {axes}",
                span,
                label="solid as far as one looks (100 m)",
                hint="intersect it with a shape, `... & box([50, 50, 50])`, or pass --bounds x0,y0,z0,x1,y1,z1",
            )
        return extent

    def mesh(self, *wishes: Any, **more: Any) -> Any:
        """The surface of an output as a `trimesh.Trimesh`; see `Program.mesh`."""
        from porelang.mesh.part import mesh

        return mesh(self, *wishes, **more)

    def measure(self, *wishes: Any, **more: Any) -> dict[str, Any]:
        """What an output measures; see `Program.measure`."""
        from porelang.measure import measure

        return measure(self, *wishes, **more)


def _about(root: Node) -> list[Node]:
    """The tasks that a condition is about."""
    return [n for n in order([root], within) if n.op in TASKS]


def _empty(name: str, formula: Formula, span: Span) -> PoreError:
    """Why a part is empty: the least value of its field that samples find, and where."""
    spread = np.random.default_rng(1)
    points = np.concatenate([spread.uniform(-r, r, (4000, 3)) for r in (10, 100, 1000)])
    found = NumpyField(formula).at(points)
    if np.isnan(found).all():
        return fail(
            "E103",
            f"`{name}` holds no material: its field is not a number",
            span,
            label="not a number anywhere",
            hint="look for the square root or the logarithm of something negative",
        )
    at = int(np.nanargmin(found))
    place = ", ".join(f"{v:.4g}" for v in points[at])
    return fail(
        "E103",
        f"`{name}` holds no material: its field is above 0 everywhere within 100 m",
        span,
        label=f"the least that samples found is {found[at]:.4g}, at ({place})",
        hint="solid is negative: check the sign or the offset, and that shapes which are intersected meet",
    )
