"""A compiled program: its params, its outputs, and what can be asked of them. The front door for Python."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import Box, part_box, unbounded_axes
from porelang.backends.numpy import Dtype, GridField, NumpyField
from porelang.backends.uniform import uniform_values
from porelang.contracts import broken_requirements, doubtful_contracts
from porelang.diagnostics import Diagnostic, PoreError, fail, suggest
from porelang.elaborate.prelude import prelude_scope
from porelang.elaborate.results import Elaborated, Output, ParamInfo, Requirement, roots_of
from porelang.elaborate.runtime import room_to_compile
from porelang.elaborate.statements import elaborate_file
from porelang.elaborate.values import Scalar, Vector
from porelang.files import load_used, read_source
from porelang.ir import Node, order
from porelang.rewrites import Graph, run
from porelang.settings import Setting, settle
from porelang.source import Source, Span
from porelang.syntax.parse import parse

if TYPE_CHECKING:
    from porelang.data import Reduced
    from porelang.gpu.fields import DeviceField, DeviceGrid

Backend = Literal["auto", "numpy", "glsl"]
Points = NDArray[np.float64]
#: Coordinates beyond this are taken for a mistake; no field overflows within it.
FARTHEST = 1e9
#: Nobody reads more; the first are the likeliest causes.
MOST_DIAGNOSTICS = 100
#: What a statement that cannot be read was about to bind.
_BINDING = re.compile(r"^[ \t]*(?:let|def|param|use\s.*\sas)\s+(\w+)", re.MULTILINE)


@dataclass(frozen=True, eq=False)
class Program:
    """A program without errors. `warnings` says what is doubtful; `graph` is what the passes make of `lowered`.

    Both have a root for each output (three for a vector: `name.x` ...), contract (`require 0`) and check (`check 0`).
    """

    source: Source
    params: Mapping[str, ParamInfo]
    outputs: Mapping[str, Output]
    warnings: tuple[Diagnostic, ...]
    lowered: Graph
    graph: Graph
    elaborated: Elaborated

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
        name = self.output(name)
        if isinstance(self.outputs[name].value, Vector):
            return tuple(self.graph.roots[f"{name}.{axis}"] for axis in "xyz")
        return (self.graph.roots[name],)

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
        return self.roots(name)[0]

    def settle(self, /, **settings: Setting) -> dict[str, float]:
        """Every param's number in base units, and those found from fields that the outputs need.

        Errors: E083-E085 about settings, E064 where a contract breaks, E090-E095 where a number cannot be found.
        """
        values = settle(self.params, settings)
        values |= self._found([r for name, r in self.graph.roots.items() if not name.startswith("check ")], values)
        # a contract on what `solve` looks for (`t => sphere(t)`) is kept to where it is kept by what was found
        solved = {
            f"?{n.value}": values[name] for name, n in self.graph.reductions if n.op == "solve" and name in values
        }
        known = {**values, **solved}
        broken = [r for i, r in enumerate(self.elaborated.requirements) if not self._holds(f"require {i}", known)]
        if broken:
            raise PoreError(
                [Diagnostic("E064", r.message, r.span, "not with these settings", r.others) for r in broken]
            )
        return values

    def failed_checks(self, measure: bool = False, /, **settings: Setting) -> list[Requirement]:
        """The `check` statements that do not hold with these settings; those about fields only if they are measured."""
        values = settle(self.params, settings)
        failed: list[Requirement] = []
        for i, check in enumerate(self.elaborated.checks):
            found = self._found([self.graph.roots[f"check {i}"]], values, compute=measure)
            if found is not None and not self._holds(f"check {i}", {**values, **found}):
                failed.append(check)
        return failed

    def doubtful_contracts(self, /, **settings: Setting) -> list[Diagnostic]:
        """Warnings about contracts on fields that need numbers found from fields; all others are among `warnings`."""
        hidden = {name for name, _ in self.graph.reductions}
        late = [c for c in self.graph.contracts if any(n.value in hidden for n in order([c[1]]) if n.op == "param")]
        if not late:
            return []
        values = settle(self.params, settings)
        values |= self._found([condition for _, condition in late], values)
        return doubtful_contracts(replace(self.graph, contracts=tuple(late)), self.elaborated.contracts, values)

    def unmeasured_checks(self) -> int:
        """How many `check` statements are about whole fields, and so are only decided by measuring."""
        hidden = {name for name, _ in self.graph.reductions}
        roots = [self.graph.roots[f"check {i}"] for i in range(len(self.elaborated.checks))]
        return sum(any(n.op == "param" and n.value in hidden for n in order([r])) for r in roots)

    def _holds(self, root: str, values: Mapping[str, float]) -> bool:
        condition = self.graph.roots[root]
        if any(n.op == "param" and str(n.value) not in values for n in order([condition])):
            return True  # about a guess of a `solve` within another number: nothing of it is left
        return bool(uniform_values([condition], values)[condition])

    def reduced(self, /, **settings: Setting) -> dict[str, Reduced]:
        """The numbers found from whole fields (`porosity(...)`, ...), by the text that asks for them, with their
        errors. What one text in a def asks for in several calls is counted: `porosity(f, c)`, `porosity(f, c) #2`."""
        return dict(self.numbers(**settings).values())

    def numbers(self, /, **settings: Setting) -> dict[str, tuple[str, Reduced]]:
        """Every number found from whole fields, by the hidden param that stands for it in the graph: its text, unlike
        any other's, and its value."""
        values = settle(self.params, settings)
        out: dict[str, tuple[str, Reduced]] = {}
        seen: dict[str, int] = {}
        for name, n in self.graph.reductions:
            text = str(n.value)
            seen[text] = seen.get(text, 0) + 1
            out[name] = (text if seen[text] == 1 else f"{text} #{seen[text]}", self._number(n, values))
        return out

    def _number(self, n: Node, values: Mapping[str, float]) -> Reduced:
        """A number found from fields; what goes wrong is told at the call that asks for it."""
        from porelang.tasks.numbers import reduction

        try:
            return reduction(n, values)
        except PoreError as error:
            place = self.elaborated.reductions.get(str(n.value))
            raise PoreError([replace(d, span=d.span or place) for d in error.diagnostics]) from None

    @overload
    def _found(self, roots: Sequence[Node], values: Mapping[str, float]) -> dict[str, float]: ...
    @overload
    def _found(self, roots: Sequence[Node], values: Mapping[str, float], compute: bool) -> dict[str, float] | None: ...
    def _found(
        self, roots: Sequence[Node], values: Mapping[str, float], compute: bool = True
    ) -> dict[str, float] | None:
        """The hidden params that these roots read; None where there are some and they are not to be computed."""
        if not self.graph.reductions:
            return {}
        read = {str(n.value) for n in order(roots) if n.op == "param"}
        needed = [(name, n) for name, n in self.graph.reductions if name in read]
        if needed and not compute:
            return None
        return {name: self._number(n, values).value for name, n in needed}

    def field(
        self,
        name: str | None = None,
        /,
        backend: Backend = "numpy",
        dtype: Dtype | None = None,
        threads: int | None = None,
        **settings: Setting,
    ) -> Field:
        """An output as a function of points (n, 3) in mm, with values (n,), or (n, 3) for a vector.

        Settings are params by name: numbers in base units or texts with a unit. `dtype` is f64 unless told otherwise,
        and f32 with `backend="glsl"`.

        >>> import porelang
        >>> program = porelang.compile("sphere(10)")
        >>> program.field("part")([[0, 0, 0], [10, 0, 0]])
        array([-10.,   0.])
        """
        dtype = dtype or ("f32" if backend == "glsl" else "f64")
        return make_field(self.roots(name), self.settle(**settings), self.graph.ranges, backend, dtype, threads)

    def bounds(self, name: str | None = None, /, **settings: Setting) -> Box:
        """The box that holds an output's solid, in mm. Errors: E102 where it has no end, E103 where it is empty."""
        root, chosen = self.solid(name), self.output(name)
        values = self.settle(**settings)
        box = part_box(root, values)
        span = self.outputs[chosen].span
        if box is None:
            raise _empty(chosen, root, values, span)
        if min(box.size) <= 0:
            flat = ", ".join(axis for axis, size in zip("xyz", box.size, strict=True) if size <= 0)
            raise fail(
                "E103", f"`{chosen}` holds no material: it has no thickness along {flat}", span, hint="give it some"
            )
        if axes := unbounded_axes(box):
            raise fail(
                "E102",
                f"`{chosen}` has no end along {axes}",
                span,
                label="solid as far as one looks (100 m)",
                hint="intersect it with a shape, `... & box([50, 50, 50])`, or pass --bounds x0,y0,z0,x1,y1,z1",
            )
        return box

    def mesh(
        self,
        name: str | None = None,
        /,
        voxel: float | None = None,
        resolution: int | None = None,
        bounds: tuple[float, float, float, float, float, float] | None = None,
        backend: Backend = "numpy",
        dtype: Dtype = "f32",
        smooth: bool = False,
        sharp: bool = False,
        simplify: float | None = None,
        **settings: Setting,
    ) -> Any:
        """The surface of an output as a `trimesh.Trimesh` in mm, watertight, normals outward.

        `voxel` is the grid spacing in mm; or `resolution` counts samples along the longest side (128 if neither is
        given). `smooth` moves vertices onto the field, `sharp` makes rims edges of the mesh, `simplify` (mm) takes
        out triangles that matter less than that.
        """
        from porelang.mesh.output import grid_of, mesh_output, refine

        surface = mesh_output(self, name, voxel, resolution, bounds, backend, dtype, settings)
        if smooth or sharp or simplify is not None:
            grid, cut = grid_of(self, name, voxel, resolution, bounds, settings)
            surface = refine(
                surface, self, name, grid, cut, settings, smooth=smooth, sharp=sharp, deviation=simplify
            ).surface
        return surface.to_trimesh()

    def measure(
        self,
        name: str | None = None,
        /,
        within: str | None = None,
        voxel: float | None = None,
        resolution: int | None = None,
        **settings: Setting,
    ) -> dict[str, Any]:
        """Volume, porosity, area, components and topology of an output, each with its error under `"error"`.

        `within` names the envelope: an output or a let. The keys are those of `pore measure`; mm, mm^2, mm^3.
        """
        from porelang.measure import measure

        return measure(self, name, within, voxel, resolution, settings=settings)


def _empty(name: str, root: Node, values: Mapping[str, float], span: Span) -> PoreError:
    """Why a part is empty: the least value of its field that samples find, and where."""
    spread = np.random.default_rng(1)
    points = np.concatenate([spread.uniform(-r, r, (4000, 3)) for r in (10, 100, 1000)])
    found = NumpyField(root, values).at(points)
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


class Field:
    """A field ready to be evaluated. `backend` is the one that runs; `note` says why, where `auto` had to choose."""

    def __init__(self, parts: Sequence[NumpyField | DeviceField], backend: str, note: str = ""):
        self.parts = tuple(parts)
        self.backend = backend
        self.note = note

    def __call__(self, points: Any) -> NDArray[Any]:
        """Values at points (n, 3) in mm: (n,), or (n, 3) for a vector. Errors: E104 for what is no place."""
        places = checked_points(points)
        values = [part.at(places) for part in self.parts]
        return values[0] if len(values) == 1 else np.stack(values, axis=1)

    def on_grid(self, axes: Sequence[NDArray[Any]]) -> GridField | DeviceGrid:
        """The field (of a number) on the grid of three coordinate axes in mm."""
        return self.parts[0].on_grid(axes)


def checked_points(points: Any) -> Points:
    """Points as a float64 array (n, 3). Errors: E104."""
    try:
        array = np.atleast_2d(np.asarray(points, dtype=np.float64))
    except (TypeError, ValueError):
        raise fail("E104", "points must be numbers", hint="give an array of shape (n, 3)") from None
    if array.size == 0:
        return np.empty((0, 3))
    if array.ndim != 2 or array.shape[1] != 3:
        raise fail(
            "E104", f"points have the shape {array.shape}, not (n, 3)", hint="give x, y, z of each point in a row"
        )
    bad = ~np.isfinite(array).all(axis=1)
    if bad.any():
        row = int(np.argmax(bad))
        raise fail(
            "E104",
            f"point {row} is ({', '.join(f'{v:g}' for v in array[row])}), which is no place",
            hint="coordinates are finite numbers, in mm",
        )
    if array.size and np.abs(array).max() > FARTHEST:
        row = int(np.argmax(np.abs(array).max(axis=1)))
        raise fail("E104", f"point {row} lies more than 1000 km from the origin", hint="coordinates are in mm")
    return array


def make_field(
    roots: tuple[Node, ...],
    values: Mapping[str, float],
    ranges: Mapping[str, tuple[float, float]],
    backend: Backend,
    dtype: Dtype,
    threads: int | None = None,
) -> Field:
    """The field of one root, or of three as a vector. `auto` is GLSL for float32 where there is a GPU, else NumPy.

    Errors: E120 where GLSL is asked for and there is no OpenGL, E123 where it is asked for in float64.
    """
    note = ""
    for what, given, known in (("backend", backend, ("auto", "numpy", "glsl")), ("dtype", dtype, ("f32", "f64"))):
        if given not in known:
            raise fail("E108", f"there is no {what} `{given}`", hint=f"choose from {', '.join(known)}")
    if backend == "glsl" and dtype == "f64":
        raise fail("E123", "GLSL computes in float32", hint="ask for f32, or for NumPy where float64 is needed")
    if backend == "glsl" or (backend == "auto" and dtype == "f32"):
        from porelang.gpu import fields as device

        try:
            gpu = device.gpu()
            return Field([device.DeviceField(r, values, ranges, gpu) for r in roots], "glsl")
        except PoreError as error:
            if backend == "glsl":
                raise
            note = f"NumPy is used: {error.diagnostics[0].message}"
    return Field([NumpyField(r, values, dtype, threads) for r in roots], "numpy", note)


def compile(text: str | None = None, *, path: str | Path | None = None, name: str = "<text>") -> Program:
    """Compile a program from a text, or from the file at `path`.

    Errors: `PoreError`, with everything that is wrong in `.diagnostics`.

    >>> import porelang
    >>> program = porelang.compile("gyroid(30) & cylinder(75, 300)")
    >>> program.bounds("part").size
    (150.0, 150.0, 300.0)
    """
    if (text is None) == (path is None):
        raise TypeError("compile takes a text or a path")
    source = read_source(os.path.normpath(path)) if path is not None else Source(name, text or "")
    program, found = try_compile(source)
    if program is None:
        raise PoreError([d for d in found if d.severity == "error"])
    return program


def try_compile(source: Source) -> tuple[Program | None, list[Diagnostic]]:
    """The program, if it has no errors, and all diagnostics in the order of their places."""
    with room_to_compile():
        return _compiled(source)


def _compiled(source: Source) -> tuple[Program | None, list[Diagnostic]]:
    file, found = parse(source)
    lost = frozenset(_BINDING.findall(source.text)) if found else frozenset()
    out = elaborate_file(file, prelude_scope(), load_used, lost)
    diagnostics = [*found, *out.diagnostics]
    program: Program | None = None
    sound = not any(d.severity == "error" for d in diagnostics)
    ranges = {name: (info.low, info.high) for name, info in out.params.items()}
    roots = roots_of(out.outputs) if sound else {}
    roots |= {f"require {i}": r.condition for i, r in enumerate(out.requirements)}
    if sound:
        roots |= {f"check {i}": c.condition for i, c in enumerate(out.checks)}
    lowered = Graph(roots, ranges)
    try:
        graph = run(lowered)
        diagnostics += broken_requirements(graph, out.requirements, out.params)
        if sound:
            diagnostics += doubtful_contracts(graph, out.contracts, settle(out.params, {}))
            program = Program(source, out.params, out.outputs, tuple(diagnostics), lowered, graph, out)
    except PoreError as error:
        span = Span(source, 0, 0)
        diagnostics += [d if d.span else replace(d, span=span) for d in error.diagnostics]
    if any(d.severity == "error" for d in diagnostics):
        program = None
    diagnostics = diagnostics[:MOST_DIAGNOSTICS]
    diagnostics.sort(key=lambda d: (d.span.source is not source, d.span.start) if d.span else (True, 0))
    return program, diagnostics
