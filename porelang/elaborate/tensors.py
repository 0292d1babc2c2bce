"""Symmetric tensors, such as stresses: six numbers under their names, and their principal values and directions."""

from __future__ import annotations

from porelang.elaborate.context import Context
from porelang.elaborate.values import POISON, TENSOR, Builtin, Record, Scalar, Value, Vector, as_list, describe
from porelang.ir import node
from porelang.source import Span
from porelang.syntax import tree
from porelang.units import RATIO, Dimension


def _tensor(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    parts = _numbers(ctx, values, places)
    return POISON if parts is None else Record("tensor", dict(zip(TENSOR, parts, strict=True)))


def _numbers(ctx: Context, values: list[Value], places: list[Span]) -> tuple[Scalar, ...] | None:
    """Six numbers of one dimension, or None after saying what is wrong."""
    parts: list[Scalar] = []
    first: tuple[Dimension, Span] | None = None
    for name, value, place in zip(TENSOR, values, places, strict=True):
        if not isinstance(value, Scalar):
            ctx.error(
                "E060", f"`{name}` of `tensor` must be a number, not {describe(value)}", place,
                label=f"this is {describe(value)}", hint="its six components are xx, yy, zz, xy, yz, xz",
            )  # fmt: skip
            return None
        if value.dimension is not None and first is not None and value.dimension != first[0]:
            ctx.error("E062", f"`{name}` of `tensor` is {value.dimension}, the others are {first[0]}", place)
            return None
        if value.dimension is not None:
            first = first or (value.dimension, place)
        parts.append(value)
    return tuple(parts)


def _principal(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    given, which = values
    items = [given.members.get(p) for p in TENSOR] if isinstance(given, Record) else as_list(given)
    if items is None or len(items) != len(TENSOR) or any(i is None for i in items):
        return ctx.error(
            "E060", f"`principal` needs a tensor, not {describe(given)}", places[0], label=f"this is {describe(given)}",
            hint="write its six components: `tensor(xx, yy, zz, xy, yz, xz)`",
        )  # fmt: skip
    parts = _numbers(ctx, [i for i in items if i is not None], [places[0]] * len(TENSOR))
    number = ctx.need_constant(which, places[1], "which value `principal` gives", fixing=True)
    if parts is None or number is None:
        return POISON
    if number not in (1, 2, 3):
        return ctx.error(
            "E064", "`principal` needs i to be 1, 2 or 3", places[1], label=f"`i` is {number:g} here",
            hint="1 is the largest value (most tension), 3 the least (most compression)",
        )  # fmt: skip
    k = f"{number:.0f}"
    value, x, y, z = (node("principal", *(s.node for s in parts), value=axis + k) for axis in "vxyz")
    dimension = next((s.dimension for s in parts if s.dimension is not None), None)
    return Record("principal", {"value": Scalar(value, dimension), "direction": Vector(x, y, z, RATIO)})


BUILTINS = (
    Builtin("tensor", TENSOR, _tensor, 6, 6, "A symmetric tensor, such as a stress, from its six components: a "
            "collection with these names. Interpolate tensors, and take their principal directions afterwards: "
            "directions have no sign, and a mean of them means nothing."),
    Builtin("principal", ("T", "i"), _principal, 2, 2, "The i-th principal value of a tensor (1 is the largest) "
            "and its direction, as fields: `.value`, and `.direction`, a unit vector. Those of 1, 2, 3 are at right "
            "angles, right-handed; of the two opposite ones the first and the second lie on the side of [9, 3, 1]. "
            "Where two values are one, or all are 0, there is a frame all the same, of any directions in their plane; "
            "beside such places directions turn quickly: an error of e in the tensor turns them by e over the gap "
            "between the values."),
)  # fmt: skip
