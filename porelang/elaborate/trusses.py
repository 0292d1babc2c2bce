"""Calls for struts in cells that repeat."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from porelang.data import LONGEST_CELL, NEAREST
from porelang.diagnostics import suggest
from porelang.elaborate import arguments
from porelang.elaborate.calls import Call
from porelang.elaborate.context import Context
from porelang.elaborate.natures import Nature
from porelang.elaborate.results import Suspicion
from porelang.elaborate.values import (
    ABSENT,
    POISON,
    Builtin,
    Function,
    ListValue,
    Poison,
    Scalar,
    Text,
    Value,
    Vector,
    as_list,
    as_vector,
    describe,
)
from porelang.ir import ONE, ZERO, Node, Stage, X, Y, Z, const, node
from porelang.ops.joints import WIDER, WIDEST
from porelang.ops.strut_cells import CELLS
from porelang.source import Span
from porelang.syntax import tree
from porelang.units import LENGTH, RATIO

_HERE = (X, Y, Z)
_LISTED = "[[[0, 0, 0], [1, 1, 1] / 2], ...]"


def _truss(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    cell = _cell(ctx, site, ctx.decided(values[0]), places[0])
    phased = values[3] is not ABSENT
    if values[1] is not ABSENT and phased:
        return ctx.error("E045", "`truss` takes `w` or `phase`, not both", places[3], label="the second")
    for value, name in ((values[3] if phased else values[1], "`w` (or `phase`)"), (values[2], "`r`")):
        if value is ABSENT:
            hint = 'it is called as `truss("octet", 10mm, r=0.6mm)`'
            return ctx.error("E043", f"`truss` needs {name}", site.span, "an argument is missing here", hint=hint)
    r = _radius(ctx, values[2], places[2])
    size = _turns(ctx, values[3], places[3]) if phased else _period(ctx, values[1], places[1])
    k = joint(ctx, values[4], places[4], "truss")
    if cell is None or r is None or size is None or k is None:
        return POISON
    sizes, given = size.nodes, size.nodes
    if not phased and all(n.stage is not Stage.FIELD for n in sizes):
        own = r.node if cell.factors and r.node.stage is not Stage.FIELD else ZERO
        bars = ctx.task(node("truss", cell.bars, *sizes, own, k), site.span)
        distance = surface(bars, _HERE, k)
        found = distance if own is r.node else distance - r.node
    else:
        if not phased:
            given = (X / sizes[0], Y / sizes[1], Z / sizes[2])
        local = _local_size(given)
        of_cell = k if k is ZERO else node("min", k / local, const(WIDEST))
        bars = ctx.task(node("truss", cell.bars, ONE, ONE, ONE, ZERO, k if k is ZERO else const(WIDEST)), site.span)
        found = local * surface(bars, given, of_cell) - r.node
        place = ctx.users_place(site.span)
        if not phased:
            ctx.suspect(Suspicion("period", place, (found, *sizes, *given), None, "truss"))
        else:
            ctx.suspect(Suspicion("beyond", place, (found, *given), places[3], "truss"))
    ctx.natures.setdefault(found, Nature(plain=True))
    one = not phased and sizes[0].stage is not Stage.FIELD and len(set(sizes)) == 1
    ctx.found.lattices.setdefault(found, (ctx.users_place(site.span), sizes[0] if one else None))
    return Scalar(found)


def surface(bars: Node, place: tuple[Node, Node, Node], k: Node) -> Node:
    """The distance from the surface of bars at a place: of the nearest, or of all with fillets between them."""
    if k is ZERO:
        return node("nearest", bars, *place, value="distance")
    return node("joined", bars, *place, k, value="distance")


def joint(ctx: Context, value: Value, place: Span, called: str) -> Node | None:
    """How far apart bars may be that are joined by fillets of a radius, 0 for none; None after saying what is wrong."""
    if value is ABSENT:
        return ZERO
    radius = arguments.uniform_length(ctx, value, place, f"`joint` of `{called}`")
    if radius is None:
        return None
    if radius.node.stage is Stage.UNIFORM:
        ctx.require(node("lt", ZERO, radius.node), f"`{called}` needs joint > 0", place, ())
    known = ctx.constant(radius.node)
    return const(float(known) * WIDER) if known is not None else radius.node * const(WIDER)


def _local_size(turns: tuple[Node, Node, Node]) -> Node:
    """The size in mm that cells of a phase have at a place: the side of the cube of their volume."""
    a, b, c = ([node("d", u, value=axis) for axis in range(3)] for u in turns)
    minors = [b[(i + 1) % 3] * c[(i + 2) % 3] - b[(i + 2) % 3] * c[(i + 1) % 3] for i in range(3)]
    many = a[0] * minors[0] + a[1] * minors[1] + a[2] * minors[2]  # cells in a cubic millimetre
    return node("pow", node("max", node("abs", many), const(1e-18)), const(-1 / 3))


@dataclass(frozen=True, slots=True)
class _Cell:
    """The slot of a cell's bars, in parts of it, and whether these may have radii of their own."""

    bars: Node
    factors: bool = False


def _cell(ctx: Context, site: tree.Call, value: Value, place: Span) -> _Cell | None:
    """The cell that is asked for by name, as a list or from a file; None after saying what is wrong with it."""
    if isinstance(value, Text) and value.value.lower().endswith(".json"):
        path = arguments.beside(site, value.value, ctx)
        return _Cell(ctx.task(node("cell", value=path), site.span), True)
    if isinstance(value, Text):
        if value.value in CELLS:
            return _Cell(ctx.task(node("cell", value=(value.value,)), site.span))
        near = suggest(value.value.replace("-", "_").replace(" ", "_"), CELLS)
        hint = f'did you mean "{near}"?' if near else f"the cells are {', '.join(CELLS)}; a file ends in .json"
        ctx.error("E137", f'there is no cell "{value.value}"', place, hint=hint)
        return None
    items = value.items if isinstance(value, ListValue) else None
    if items is not None:
        bars = [_bar(ctx, item, i, place) for i, item in enumerate(items)]
        if not items:
            ctx.error("E137", "a cell without bars is none", place, hint=f"bars are listed as {_LISTED}")
        if not items or None in bars:
            return None
        ends = [v for bar in bars for v in bar or ()]
        return _Cell(ctx.task(node("cell", value=("", *ends)), site.span))
    if isinstance(value, Poison):
        return None
    hint = f'a cell is a name, as "octet", a list of bars, {_LISTED}, or a file, "mine.json"'
    if isinstance(value, Function | Builtin) and value.name in CELLS:
        hint = f'the name of a cell stands in quotes: "{value.name}"'
    ctx.error("E137", f"{describe(value)} is no cell", place, hint=hint)
    return None


def _bar(ctx: Context, value: Value, i: int, place: Span) -> tuple[float, ...] | None:
    """The ends of a bar, six numbers that are known now."""
    pair = as_list(value) or ()
    vectors = [as_vector(p) for p in pair]
    if len(pair) != 2 or None in vectors:
        ctx.error("E137", f"bar {i} of the cell is {describe(value)}, where two places belong", place,
                  hint=f"bars are listed as {_LISTED}, in parts of the cell")  # fmt: skip
        return None
    ends: list[float] = []
    for vector in vectors:
        assert vector is not None
        if vector.dimension not in (None, RATIO):
            ctx.error("E137", f"bar {i} of the cell is given in {vector.dimension.unit}", place,
                      hint=f"places are in parts of the cell: {_LISTED}")  # fmt: skip
            return None
        for n in vector.nodes:
            known = ctx.need_constant(Scalar(n), place, f"bar {i} of the cell")
            if known is None:
                return None
            ends.append(known)
    if max(abs(a - b) for a, b in zip(ends[:3], ends[3:], strict=True)) < NEAREST or max(map(abs, ends)) > 100:
        what = "has no length" if max(map(abs, ends)) <= 100 else "lies over a hundred cells away"
        ctx.error("E137", f"bar {i} of the cell {what}", place, hint=f"bars are listed as {_LISTED}")
        return None
    return tuple(ends)


def _radius(ctx: Context, value: Value, place: Span) -> Scalar | None:
    r = arguments.field(ctx, value, place, "`r` of `truss`")
    if r is None:
        return None
    if r.dimension not in (None, LENGTH):
        ctx.error("E062", f"`r` of `truss` is a length, not {r.dimension}", place)
        return None
    return _positive(ctx, r, place, "E064", "`truss` needs r > 0")


def _positive(ctx: Context, value: Scalar, place: Span, code: str, message: str) -> Scalar | None:
    known = ctx.constant(value.node)
    if isinstance(known, float) and not known > 0:
        ctx.error(code, message, place, label=f"this is {known:g} mm", hint="give a length above 0")
        return None
    if value.node.stage is Stage.UNIFORM:
        ctx.require(node("lt", ZERO, value.node), message, place, ())
    return value


def _period(ctx: Context, value: Value, place: Span) -> Vector | None:
    vector = as_vector(value)
    if vector is None:
        one = arguments.field(ctx, value, place, "`w` of `truss`")
        vector = None if one is None else Vector(one.node, one.node, one.node, one.dimension)
    if vector is None:
        return None
    if vector.dimension not in (None, LENGTH):
        ctx.error("E062", f"`w` of `truss` is a length, not {vector.dimension}", place)
        return None
    for n in dict.fromkeys(vector.nodes):
        if _positive(ctx, Scalar(n), place, "E147", "`truss` needs w > 0") is None:
            return None
    known = [w for n in vector.nodes if isinstance(w := ctx.constant(n), float)]
    if len(known) == 3 and max(known) > LONGEST_CELL * min(known):
        shown = " x ".join(f"{w:g}" for w in known)
        ctx.error("E138", f"a cell of {shown} mm is over {LONGEST_CELL:g} times as long as it is wide", place,
                  hint="scale the struts instead, as in `truss(...) @ [x, y, z / 200]`")  # fmt: skip
        return None
    return vector


def _turns(ctx: Context, value: Value, place: Span) -> Vector | None:
    vector = as_vector(value)
    if vector is None:
        ctx.error("E060", f"`phase` of `truss` is a vector, not {describe(value)}", place,
                  hint="as in `phase=phase(w, part)`, or `phase=p / 10`")  # fmt: skip
        return None
    if vector.dimension not in (None, RATIO):
        ctx.error("E062", f"`phase` of `truss` is in turns, not {vector.dimension}", place,
                  hint="divide by the size of a cell: `p / 10`")  # fmt: skip
        return None
    return vector


#: What asks for the tasks of these names.
CALLS: Mapping[str, Call] = {"truss": _truss}
