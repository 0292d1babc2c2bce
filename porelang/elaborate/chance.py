"""Chance: random numbers of places, and random sites in cells of size 1."""

from __future__ import annotations

from porelang.elaborate.context import Context
from porelang.elaborate.values import ABSENT, POISON, Builtin, Record, Scalar, Value, Vector, as_vector, describe
from porelang.ir import Node, Stage, const, node
from porelang.ops.points import FARTHEST
from porelang.source import Span
from porelang.syntax import tree
from porelang.units import RATIO

_SEED, _JITTER = Scalar(const(0.0)), Scalar(const(1.0))


def _place(ctx: Context, value: Value, span: Span, call: str) -> Vector | None:
    """A place in cells: three plain numbers."""
    place = as_vector(value)
    if place is None:
        ctx.error("E060", f"`{call}` needs a place, not {describe(value)}", span, label=f"this is {describe(value)}",
                  hint=f"as in `{call}(p / 10)`, for cells of 10 mm")  # fmt: skip
        return None
    if place.dimension not in (None, RATIO):
        ctx.error("E062", f"`{call}` counts in cells, and this is {place.dimension}", span,
                  hint="divide it by the size of a cell, as in `p / 10mm`")  # fmt: skip
        return None
    return place


def _number(ctx: Context, value: Value, default: Scalar, span: Span, what: str) -> Node | None:
    """A number that is the same everywhere."""
    given = default if value is ABSENT else value
    if not isinstance(given, Scalar):
        ctx.error("E060", f"{what} must be a number, not {describe(given)}", span)
        return None
    if given.node.stage is Stage.FIELD:
        ctx.error("E063", f"{what} must be one number", span, label="this varies in space")
        return None
    return given.node


def _seed(ctx: Context, value: Value, span: Span, call: str) -> Node | None:
    """A seed, which float32 tells from the next one."""
    seed = _number(ctx, value, _SEED, span, f"the seed of `{call}`")
    if seed is None:
        return None
    known = ctx.constant(seed)
    words = f"a seed lies between 0 and {FARTHEST - 1:,.0f}"
    if known is not None and not 0 <= known < FARTHEST:
        ctx.error("E064", f"`{call}` has no such seed", span, label=f"this is {known:g}", hint=words)
        return None
    if seed.stage is Stage.UNIFORM:
        ctx.require(node("lt", seed, const(FARTHEST)), f"{words}, and not this of `{call}`", span, ())
    return seed


def _random(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    place = _place(ctx, values[0], places[0], "random")
    seed = _seed(ctx, values[1], places[1], "random")
    if place is None or seed is None:
        return POISON
    x, y, z = (node("random", *place.nodes, seed, value=name) for name in "xyz")
    return Vector(x, y, z, RATIO)


def _nearest_site(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    place = _place(ctx, values[0], places[0], "nearest_site")
    seed = _seed(ctx, values[1], places[1], "nearest_site")
    jitter = _number(ctx, values[2], _JITTER, places[2], "the jitter of `nearest_site`")
    if place is None or seed is None or jitter is None:
        return POISON
    known = ctx.constant(jitter)
    if known is not None and not 0 <= known <= 1:
        return ctx.error("E064", "`nearest_site` needs a jitter from 0 to 1", places[2], label=f"this is {known:g}",
                         hint="0 puts sites in the middle of their cells, 1 anywhere in them")  # fmt: skip

    def result(name: str) -> Scalar:
        return Scalar(node("sites", *place.nodes, seed, jitter, value=name), RATIO)

    def away(which: str) -> Vector:
        x, y, z = (result(axis + which).node for axis in "xyz")
        return Vector(x, y, z, RATIO)

    numbers = {name: result(name) for name in ("f1", "f2", "f3", "wall", "number")}
    return Record("nearest_site", {**numbers, "outward": away("1"), "across": away("w")})


BUILTINS = (
    Builtin("random", ("v", "seed"), _random, 1, 2, "Three random numbers, 0 to 1, of the cell of size 1 that the "
            "place v lies in, as a vector: the same for a seed on every machine. `random(p / 10)` has cells of 10 mm.",
            True),
    Builtin("nearest_site", ("v", "seed", "jitter"), _nearest_site, 1, 3, "What is nearest to the place v of random "
            "sites, one in each cell of size 1: `.f1`, `.f2`, `.f3`, the distances from the nearest three, `.wall`, "
            "that from the nearest wall half way between two sites, `.outward`, the direction away from the nearest "
            "site, `.across`, that away from the wall, and `.number`, a random number of the site, 0 to 1. Sites lie "
            "anywhere in their cell, or nearer to its middle with a `jitter` below 1; at 0 they lie there.", True),
)  # fmt: skip
