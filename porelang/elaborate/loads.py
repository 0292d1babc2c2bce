"""What holds and loads a part in a study: `held(where)`, `force(where, [0, 0, -1kN])` and their kin."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

from porelang.elaborate.bare import value_of
from porelang.elaborate.context import Context
from porelang.elaborate.values import (
    ABSENT,
    POISON,
    Acting,
    Bool,
    Builtin,
    ListValue,
    Poison,
    Scalar,
    Text,
    Value,
    Vector,
    as_vector,
    describe,
)
from porelang.ir import ONE, TRUE, ZERO, Node, Stage, const, node
from porelang.ops.studies import ACTIONS
from porelang.source import Span
from porelang.syntax import tree
from porelang.units import FORCE, LENGTH, RATIO, STRESS, Dimension

_TORQUE = FORCE * LENGTH
#: Some of the axes, each once, in any order.
_ALONG = frozenset("".join(some) for n in (1, 2, 3) for some in permutations("xyz", n))
_DOES = {row.name: row.does for row in ACTIONS}
#: What may stand in `fix=` and in `load=`, for what is said of anything else.
_HOLDS = "a condition, as `z < -149mm`, `held(...)` or `moved(...)`, or a list of such"
_LOADS = "`force(...)`, `pressure(...)`, `torque(...)`, `weight(...)` or `moved(...)`, or a list of such"


def number(
    ctx: Context, value: Value, place: Span, of: str, dimension: Dimension | None, example: str, field: bool = False
) -> Node | None:
    """A number of a dimension, or a bare one; the same everywhere, unless it may be a `field`. None after saying what
    is wrong with it."""
    if not isinstance(value, Scalar):
        hint = f"as in `{example}`"
        ctx.error("E060", f"{of} is a number, not {describe(value)}", place, f"this is {describe(value)}", hint=hint)
        return None
    if dimension is not None and value.dimension not in (None, dimension):
        hint = f"as in `{example}`"
        ctx.error("E062", f"{of} is {dimension}, not {value.dimension}", place, hint=hint)
        return None
    if value.node.stage is Stage.FIELD and not field:
        ctx.error("E063", f"{of} must be one number", place, label="this varies in space")
        return None
    return value.node


def vector(
    ctx: Context, value: Value, place: Span, of: str, dimension: Dimension, example: str
) -> tuple[Node, Node, Node] | None:
    """Three numbers of a dimension that are the same everywhere; None after saying what is wrong with them."""
    found = as_vector(value)
    if found is None:
        hint = f"it has a direction: `{example}`"
        ctx.error("E060", f"{of} is a vector, not {describe(value)}", place, f"this is {describe(value)}", hint=hint)
        return None
    if found.dimension not in (None, dimension):
        hint = f"as in `{example}`"
        ctx.error("E062", f"{of} is {dimension}, not {found.dimension}", place, hint=hint)
        return None
    if any(n.stage is Stage.FIELD for n in found.nodes):
        ctx.error("E063", f"{of} must be the same everywhere", place, label="this varies in space")
        return None
    return found.nodes


def where(ctx: Context, value: Value, place: Span, of: str) -> Node | None:
    """A condition on places; None after saying that it is none."""
    if isinstance(value, Bool):
        return value.node
    text = value_of(place).text
    varies = isinstance(value, Scalar) and value.node.stage is Stage.FIELD
    hint = f"write where: `{text} < 0`" if varies else "as in `z < -149mm`"
    ctx.error("E060", f"{of} is a condition, not {describe(value)}", place, f"this is {describe(value)}", hint=hint)
    return None


def something(ctx: Context, numbers: Sequence[Node], place: Span, what: str, hint: str) -> bool:
    """Whether any of some numbers is not 0, or may be; says that it is not, or asks that it be for all settings."""
    known = [ctx.constant(n) for n in numbers]
    if all(v == 0 for v in known):
        ctx.error("E186", f"{what} of 0 does nothing", place, label="this is 0", hint=hint)
        return False
    if any(isinstance(v, float) and v != 0 for v in known):
        return True
    total = ZERO
    for n in numbers:
        total = node("add", total, node("abs", n))
    ctx.require(node("lt", ZERO, total), f"{what} of 0 does nothing", place, ())
    return True


def _axes(ctx: Context, value: Value, place: Span, of: str) -> tuple[Node, Node, Node] | None:
    """Along which axes something is held, of a text of their letters: all where it is left out."""
    if value is ABSENT:
        return ONE, ONE, ONE
    value = ctx.decided(value)
    if isinstance(value, Text) and value.value in _ALONG:
        x, y, z = (const(float(a in value.value)) for a in "xyz")
        return x, y, z
    if not isinstance(value, Poison):
        hint = 'as in `along="z"`, or "xy" for two'
        ctx.error(
            "E187",
            f"{of} is a text of the axes x, y and z, each once at most",
            place,
            f"this is {describe(value)}",
            hint=hint,
        )
    return None


def _held(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    place = where(ctx, values[0], places[0], "`where` of `held`")
    along = _axes(ctx, values[1], places[1], "`along` of `held`")
    return POISON if place is None or along is None else Acting("held", {}, place, along)


def _moved(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    place = where(ctx, values[0], places[0], "`where` of `moved`")
    by = vector(ctx, values[1], places[1], "`by` of `moved`", LENGTH, "moved(z > 9mm, [0, 0, -0.1mm])")
    along = _axes(ctx, values[2], places[2], "`along` of `moved`")
    if place is None or by is None or along is None:
        return POISON
    return Acting("moved", {}, place, (*along, *by))


def _force(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    place = where(ctx, values[0], places[0], "`where` of `force`")
    total = vector(ctx, values[1], places[1], "`total` of `force`", FORCE, "force(z > 9mm, [0, 0, -1kN])")
    if place is None or total is None or not something(ctx, total, places[1], "a force", "as in `[0, 0, -1kN]`"):
        return POISON
    return Acting("force", {}, place, total)


def _pressure(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    place = where(ctx, values[0], places[0], "`where` of `pressure`")
    p = number(ctx, values[1], places[1], "`p` of `pressure`", STRESS, "pressure(z > 9mm, 2MPa)")
    if place is None or p is None or not something(ctx, (p,), places[1], "a pressure", "as in `2MPa`"):
        return POISON
    return Acting("pressure", {}, place, (p,))


def _torque(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    place = where(ctx, values[0], places[0], "`where` of `torque`")
    example = "torque(z > 9mm, [0, 0, 5N * 1m])"
    total = vector(ctx, values[1], places[1], "`total` of `torque`", _TORQUE, example)
    if place is None or total is None or not something(ctx, total, places[1], "a torque", f"as in `{example}`"):
        return POISON
    return Acting("torque", {}, place, total)


def _weight(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    if values[0] is ABSENT:
        return Acting("weight", {}, TRUE, (ZERO, ZERO, const(-1.0)))
    total = vector(ctx, values[0], places[0], "`g` of `weight`", RATIO, "weight([0, 0, -1])")
    if total is None or not something(ctx, total, places[0], "a weight", "as in `weight([0, 0, -1])`"):
        return POISON
    return Acting("weight", {}, TRUE, total)


def acting(ctx: Context, value: Value, place: Span, parameter: str) -> list[Acting] | None:
    """What `fix` or `load` of `study` is: one thing that acts, or a list; None after saying that it is none.

    A condition by itself holds. What is moved may stand in both.
    """
    items = value.items if isinstance(value, ListValue) else (value,)
    found: list[Acting] = []
    for item in items:
        if isinstance(item, Bool) and parameter == "fix":
            item = Acting("held", {}, item.node, (ONE, ONE, ONE))
        fits = isinstance(item, Acting) and (_DOES[item.name] == ("holds" if parameter == "fix" else "loads"))
        if isinstance(item, Acting) and (fits or item.name == "moved"):
            found.append(item)
            continue
        if isinstance(item, Poison):
            return None
        what = f"`{item.name}`" if isinstance(item, Acting) else describe(item)
        hint = f"`{parameter}` takes {_HOLDS if parameter == 'fix' else _LOADS}"
        if isinstance(item, Vector) or isinstance(value, Vector):
            hint = f"say where it acts: `force(z > 9mm, {value_of(place).text})`"
        elif isinstance(item, Acting):
            hint = f"give it to `{'load' if parameter == 'fix' else 'fix'}`"
        elif isinstance(item, Scalar) and item.node.stage is Stage.FIELD and parameter == "fix":
            hint = f"write where: `{value_of(place).text} < 0`"
        ctx.error("E187", f"`{parameter}` of `study` cannot be {what}", place, f"this is {what}", hint=hint)
        return None
    return found


BUILTINS = (
    Builtin("held", ("where", "along"), _held, 1, 2, "Holds a part in a study where a condition is true of its surface:"
            ' `held(z < 0mm)` along all axes, `held(z < 0mm, along="z")` so that it may slide.', True),
    Builtin("moved", ("where", "by", "along"), _moved, 2, 3, "Moves the surface of a part in a study by a vector, where"
            ' a condition is true: `moved(z > 9mm, [0, 0, -0.1mm])`; with `along="z"` along that axis only.', True),
    Builtin("force", ("where", "total"), _force, 2, 2, "A force on the surface of a part in a study, where a condition "
            "is true, spread evenly: `force(z > 9mm, [0, 0, -1kN])`; the vector is all of it."),
    Builtin("pressure", ("where", "p"), _pressure, 2, 2, "A pressure on the surface of a part in a study, where a "
            "condition is true, into the material: `pressure(z > 9mm, 2MPa)`."),
    Builtin("torque", ("where", "total"), _torque, 2, 2, "A torque on the surface of a part in a study, where a "
            "condition is true, about the middle of that place: `torque(z > 9mm, [0, 0, 5N * 1m])`."),
    Builtin("weight", ("g",), _weight, 0, 1, "The weight of a part in a study, downwards (-z), or by the vector `g` in "
            "multiples of 9.80665 m/s^2: `weight([0, -1, 0])`. It takes a density.", True),
)  # fmt: skip
