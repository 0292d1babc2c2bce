"""Functions that reduce whole fields to numbers: their arguments checked, a node made; computing them comes later."""

from __future__ import annotations

from porelang.elaborate.calls import Given, argument_places, call
from porelang.elaborate.context import Context
from porelang.elaborate.values import POISON, Builtin, Function, Poison, Range, Scalar, Value, describe
from porelang.ir import Node, Stage, node, param
from porelang.syntax import tree
from porelang.units import AREA, RATIO, VOLUME, Dimension

_SELF = "dimension of the field"
_SHAPES: tuple[tuple[str, tuple[str, ...], Dimension | str | None, str], ...] = (
    (
        "porosity",
        ("f", "within"),
        RATIO,
        "The void fraction of a solid within another: 1 - volume(f & within) / volume(within).",
    ),
    ("volume", ("f",), VOLUME, "The volume of a solid, in mm^3."),
    ("area", ("f",), AREA, "The area of a solid's surface, in mm^2."),
    ("minimum", ("f", "within"), _SELF, "The least value of a field within a solid."),
    ("maximum", ("f", "within"), _SELF, "The greatest value of a field within a solid."),
    ("mean", ("f", "within"), _SELF, "The mean value of a field within a solid."),
    (
        "to_porosity",
        ("f", "phi", "within"),
        _SELF,
        "The offset d for which `offset(f, d)` has the porosity phi within a solid.",
    ),
    (
        "shell_to_porosity",
        ("f", "phi", "within"),
        _SELF,
        "The thickness t for which `shell(f, t)` has the porosity phi within a solid.",
    ),
)


def _reduction(name: str, signature: tuple[str, ...], dimension: Dimension | str | None, doc: str) -> Builtin:
    def call_it(e: Context, site: tree.Call, values: list[Value]) -> Value:
        nodes: list[Node] = []
        for value, parameter, place in zip(values, signature, argument_places(site, len(values)), strict=True):
            if not isinstance(value, Scalar):
                hint = f"call it first: `{value.name}(...)`" if isinstance(value, Function) else ""
                return e.error(
                    "E060",
                    f"`{parameter}` of `{name}` must be a field, not {describe(value)}",
                    place,
                    label=f"this is {describe(value)}",
                    hint=hint,
                )
            if parameter == "phi":
                if value.node.stage is Stage.FIELD:
                    return e.error("E063", f"`phi` of `{name}` must be one number", place, label="this varies in space")
                known = e.constant(value.node)
                if isinstance(known, float) and not 0 < known < 1:
                    return e.error(
                        "E064",
                        f"`{name}` needs a porosity between 0 and 1",
                        place,
                        label=f"this is {known:g}",
                        hint="write 50% or 0.5",
                    )
            nodes.append(value.node)
        first = values[0]
        assert isinstance(first, Scalar)
        found = first.dimension if dimension == _SELF else dimension
        return Scalar(node(name, *nodes, value=e.reduction(site.span)), None if isinstance(found, str) else found)

    return Builtin(name, signature, call_it, len(signature), len(signature), doc)


def _solve(e: Context, site: tree.Call, values: list[Value]) -> Value:
    function, target, ends = values
    places = argument_places(site, 3)
    if not isinstance(ends, Range):
        return e.error(
            "E060",
            f"`solve` looks in a range, not in {describe(ends)}",
            places[2],
            label=f"this is {describe(ends)}",
            hint="write it as `lo..hi`: `solve(t => ..., 0.5, 0.1..3)`",
        )
    if not isinstance(target, Scalar):
        return e.error("E060", f"the target of `solve` is a number, not {describe(target)}", places[1])
    text = e.reduction(site.span)
    unknown = f"?{text}"
    dimension = ends.low.dimension or ends.high.dimension
    value = call(e, function, [Given(None, Scalar(param(unknown), dimension), places[0])], site)
    if isinstance(value, Poison):
        return POISON
    if not isinstance(value, Scalar):
        return e.error("E060", f"`solve` needs a function that gives a number, not {describe(value)}", places[0])
    for what, n, place in (
        ("the function of `solve`", value.node, places[0]),
        ("the target of `solve`", target.node, places[1]),
        ("an end of the range", ends.low.node, places[2]),
        ("an end of the range", ends.high.node, places[2]),
    ):
        if n.stage is Stage.FIELD:
            return e.error(
                "E063",
                f"{what} must be one number",
                place,
                label="this varies in space",
                hint="reduce it first: `porosity(f, within)`, `mean(f, within)`, ...",
            )
    if None not in (value.dimension, target.dimension) and value.dimension != target.dimension:
        return e.error("E062", f"the function gives {value.dimension}, the target is {target.dimension}", places[1])
    return Scalar(node("solve", value.node, target.node, ends.low.node, ends.high.node, value=text), dimension)


BUILTINS = (
    *(_reduction(*row) for row in _SHAPES),
    Builtin(
        "solve",
        ("f", "target", "range"),
        _solve,
        3,
        3,
        "The number t in lo..hi for which a function that rises or falls throughout takes a value.",
    ),
)
