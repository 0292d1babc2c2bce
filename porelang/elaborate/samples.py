"""Calls for samples: of a file (`load` and its kin), of a field (`sample`), of one that is averaged (`blur`).

Samples are no values of the language: they become the fields that look them up.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from porelang.diagnostics import suggest
from porelang.elaborate import arguments, bare
from porelang.elaborate.calls import Call
from porelang.elaborate.context import Context
from porelang.elaborate.values import (
    ABSENT,
    POISON,
    TENSOR,
    Builtin,
    Record,
    Scalar,
    Text,
    Value,
    Vector,
    as_vector,
    describe,
)
from porelang.ir import ONE, ZERO, Node, Stage, X, Y, Z, const, node
from porelang.ops import TASK_TABLE
from porelang.source import Span
from porelang.syntax import tree
from porelang.units import LENGTH, SPELT, UNITS, Dimension, written

_HERE = (X, Y, Z)


@dataclass(frozen=True, slots=True)
class _Loaded:
    """What is read from a file: a field for each number at a node."""

    grid: Node
    smooth: bool
    masked: bool
    components: int
    scale: Node
    dimension: Dimension | None

    def fields(self, outside: Sequence[Node | None]) -> list[Node]:
        """The field of each number, with what is beyond what the file covers."""
        return [self._field(k, beyond) for k, beyond in enumerate(outside)]

    def _field(self, component: int, outside: Node | None) -> Node:
        found = arguments.looked_up(self.grid, component, self.smooth, None)
        if self.scale is not ONE:
            found = node("mul", found, self.scale)
        if outside is None:
            return found
        covered = node("covers", self.grid, *_HERE)
        if self.masked:  # where the component that says how far outside of the cells a place lies is below 0
            away = arguments.looked_up(self.grid, self.components, False, None)
            covered = node("and", covered, node("le", away, ZERO))
        return node("select", covered, found, outside)


def _unit(ctx: Context, value: Value, place: Span, name: str, called: str) -> tuple[Node, Dimension | None] | None:
    """By what values are multiplied, and what they then are; None after saying what is wrong with a unit."""
    if value is ABSENT:
        return ONE, None
    if isinstance(value, Text) and value.value in UNITS:
        return const(UNITS[value.value].scale), UNITS[value.value].dimension
    units = UNITS if name == "unit" else [u for u, known in UNITS.items() if known.dimension == LENGTH]
    at, known = bare.value_of(place), f"the units are {', '.join(map(written, units))}"
    example = "unit=MPa" if name == "unit" else "lengths=m"
    if isinstance(value, Text):
        near = SPELT.get(value.value) or suggest(value.value, units)
        near = None if near is None else written(near)
        hint = f"did you mean `{near}`?" if near else f"write it without quotes, as in `{example}`; {known}"
        ctx.error("E153", f"`{value.value}` is not a unit", place, hint=hint, edit=(at, near) if near else None)
        return None
    scale = ctx.need_constant(value, place, f"`{name}` of `{called}`")
    if scale is None or not isinstance(value, Scalar):
        return None
    if value.dimension is None or not 0 < scale < math.inf:
        what = f"this is {scale:g}" if value.dimension is None else f"this is {scale:g}{value.dimension.unit}"
        ctx.error("E153", f"`{name}` of `{called}` is no unit", place, what, hint=f"as in `{example}`; {known}")
        return None
    return const(scale), value.dimension


def _loaded(
    ctx: Context, values: list[Value], places: list[Span], site: tree.Call, called: str, components: int
) -> _Loaded | None:
    """The slot of what is loaded; its file has to hold so many numbers at each node."""
    unit = _unit(ctx, values[5], places[5], "unit", called)
    lengths = _unit(ctx, values[6], places[6], "lengths", called)
    smooth = arguments.flag(ctx, values[3], places[3], "smooth")
    voxel = arguments.length_now(ctx, values[4], places[4], f"`voxel` of `{called}`")
    path = arguments.text(ctx, values[0], places[0], f"the path of the file that `{called}` reads")
    name = arguments.text(ctx, values[1], places[1], f"the name of what `{called}` takes from a file", "von_mises")
    if path is None or name is None or smooth is None or voxel is None or unit is None or lengths is None:
        return None
    if lengths[1] not in (None, LENGTH):
        ctx.error("E062", f"`lengths` of `{called}` is a length, not {lengths[1]}", places[6], hint="as in `lengths=m`")
        return None
    mm = 0.0 if values[6] is ABSENT else float(ctx.constant(lengths[0]) or 0.0)
    masked = values[2] is not ABSENT
    more = (voxel, int(masked), mm) if voxel or masked or mm else ()
    grid = ctx.task(node("load", value=(*arguments.beside(site, path, ctx), name, components, *more)), site.span)
    return _Loaded(grid, smooth, masked, components, *unit)


def _dimension_of(ctx: Context, loaded: _Loaded, outside: Scalar | Vector | None, place: Span) -> Dimension | None:
    """What is loaded is measured in; says so where what is outside is of another dimension."""
    beyond = None if outside is None else outside.dimension
    if None not in (beyond, loaded.dimension) and beyond != loaded.dimension:
        ctx.error("E062", f"inside this is {loaded.dimension}, outside {beyond}", place, hint="give both one unit")
    return loaded.dimension or beyond


def _load(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    outside = None if values[2] is ABSENT else arguments.field(ctx, values[2], places[2], "`outside` of `load`")
    loaded = _loaded(ctx, values, places, site, "load", 1)
    if loaded is None or (outside is None and values[2] is not ABSENT):
        return POISON
    (field,) = loaded.fields([None if outside is None else outside.node])
    return Scalar(field, _dimension_of(ctx, loaded, outside, places[2]))


def _load_vector(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    outside = None if values[2] is ABSENT else as_vector(values[2])
    if outside is None and values[2] is not ABSENT:
        return ctx.error(
            "E060", f"`outside` of `load_vector` is a vector, not {describe(values[2])}", places[2],
            hint="write three numbers: `outside=[0, 0, 0]`",
        )  # fmt: skip
    loaded = _loaded(ctx, values, places, site, "load_vector", 3)
    if loaded is None:
        return POISON
    x, y, z = loaded.fields(outside.nodes if outside is not None else (None,) * 3)
    return Vector(x, y, z, _dimension_of(ctx, loaded, outside, places[2]))


def _load_tensor(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    outside = None if values[2] is ABSENT else arguments.field(ctx, values[2], places[2], "`outside` of `load_tensor`")
    loaded = _loaded(ctx, values, places, site, "load_tensor", 6)
    if loaded is None or (outside is None and values[2] is not ABSENT):
        return POISON
    # outside it is the same in all directions: a pressure, or nothing
    beyond = (None,) * 6 if outside is None else (*(outside.node,) * 3, *(ZERO,) * 3)
    fields = loaded.fields(beyond)
    dimension = _dimension_of(ctx, loaded, outside, places[2])
    return Record("tensor", {c: Scalar(f, dimension) for c, f in zip(TENSOR, fields, strict=True)})


def _sample(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    vector = as_vector(values[0])
    field = vector if vector is not None else arguments.field(ctx, values[0], places[0], "`f` of `sample`")
    if field is None:
        return POISON
    voxel = arguments.field(ctx, values[1], places[1], "`voxel` of `sample`")
    within = arguments.field(ctx, values[2], places[2], "`within` of `sample`")
    smooth = arguments.flag(ctx, values[3], places[3], "smooth")
    if voxel is None or within is None or smooth is None:
        return POISON
    if voxel.node.stage is Stage.FIELD:
        return ctx.error("E063", "`voxel` of `sample` must be one number", places[1], label="this varies in space")
    if voxel.dimension not in (None, LENGTH):
        return ctx.error("E062", f"`voxel` of `sample` is a length, not {voxel.dimension}", places[1])
    known = ctx.constant(voxel.node)
    if known is not None and not known > 0:
        return ctx.error("E096", f"a voxel of {known:g} mm cannot be sampled at", places[1],
                         hint="give a length above 0, as in 1mm")  # fmt: skip
    fields = field.nodes if isinstance(field, Vector) else (field.node,)
    grid = ctx.task(node("sample", *fields, voxel.node, within.node), site.span)
    found = [arguments.looked_up(grid, k, smooth, None) for k in range(len(fields))]
    if isinstance(field, Vector):
        return Vector(found[0], found[1], found[2], field.dimension)
    return Scalar(found[0], field.dimension)


def _blur(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    vector = as_vector(values[0])
    if isinstance(values[0], Record):
        hint = "blur its components, each by itself, as in `blur(T.xx, 2mm, body)`, and make a `tensor(...)` of them"
        return ctx.error("E060", f"`f` of `blur` is {describe(values[0])}", places[0], hint=hint)
    field = vector if vector is not None else arguments.field(ctx, values[0], places[0], "`f` of `blur`")
    sigma = arguments.uniform_length(ctx, values[1], places[1], "`sigma` of `blur`")
    within = arguments.field(ctx, values[2], places[2], "`within` of `blur`")
    voxel = sigma if values[3] is ABSENT else arguments.uniform_length(ctx, values[3], places[3], "`voxel` of `blur`")
    smooth = arguments.flag(ctx, values[4], places[4], "smooth")
    if field is None or sigma is None or within is None or voxel is None or smooth is None:
        return POISON
    wide, step = ctx.constant(sigma.node), ctx.constant(voxel.node)
    if None not in (wide, step) and float(step or 0) > float(wide or 0):
        return ctx.error("E156", f"samples every {step:g} mm do not tell what is averaged over {wide:g} mm", places[3],
                         hint=f"take {float(wide or 0) / 2:.3g}mm, or leave `voxel` out")  # fmt: skip
    step_node = node("mul", sigma.node, const(0.5)) if values[3] is ABSENT else voxel.node
    fields = field.nodes if isinstance(field, Vector) else (field.node,)
    grid = ctx.task(node("blur", *fields, sigma.node, step_node, within.node), site.span)
    found = [arguments.looked_up(grid, k, smooth, None) for k in range(len(fields))]
    if isinstance(field, Vector):
        return Vector(found[0], found[1], found[2], field.dimension)
    return Scalar(found[0], field.dimension)


#: What asks for the tasks of these names.
CALLS: Mapping[str, Call] = {"load": _load, "sample": _sample, "blur": _blur}
BUILTINS = (
    Builtin(
        "load_vector",
        TASK_TABLE["load"].parameters,
        _load_vector,
        2,
        len(TASK_TABLE["load"].parameters),
        "A vector field from samples in a file, as `load`; its array holds three numbers a node: (nx, ny, nz, 3).",
        True,
    ),
    Builtin(
        "load_tensor",
        TASK_TABLE["load"].parameters,
        _load_tensor,
        2,
        len(TASK_TABLE["load"].parameters),
        "A symmetric tensor from samples in a file, as `load`: a stress, with the members `.xx`, `.yy`, `.zz`, `.xy`, "
        "`.yz` and `.xz`. Its array holds these six a node, in this order, or all nine. `outside` is one number, for "
        "`.xx`, `.yy` and `.zz`.",
        True,
    ),
)
