"""Calls for solids that a file holds: the mesh of a part, as its signed distance."""

from __future__ import annotations

from collections.abc import Mapping

from porelang.elaborate import arguments
from porelang.elaborate.calls import Call
from porelang.elaborate.context import Context
from porelang.elaborate.values import POISON, Scalar, Value
from porelang.ir import X, Y, Z, node
from porelang.ops import TASK_TABLE
from porelang.source import Span
from porelang.syntax import tree

_HERE = (X, Y, Z)


def _mesh(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
    path = arguments.text(ctx, values[0], places[0], "the path of a mesh", "part.stl")
    names = TASK_TABLE["mesh"].parameters[1:]
    given = zip(values[1:], places[1:], names, strict=True)
    lengths = [arguments.length_now(ctx, value, place, f"`{name}` of `mesh`", "E143") for value, place, name in given]
    known = [length for length in lengths if length is not None]
    if path is None or len(known) < len(lengths):
        return POISON
    shown, whole = arguments.beside(site, path, ctx)
    grid, corners = (
        ctx.task(node("mesh", value=(shown, whole, *known, part)), site.span) for part in ("distance", "corners")
    )
    distance = arguments.looked_up(grid, 0, False, None)
    # Let q be the place in the grid's box that is nearest to p. The box is convex and holds the mesh, so that the angle
    # at q between p and any place of the mesh is 90 degrees or more: the mesh is |p - q| and the distance at q away by
    # Pythagoras at least, and their sum at most.
    squares = node("mul", distance, distance)
    for axis, here in enumerate(_HERE):
        away = node("sub", here, arguments.looked_up(corners, axis, False, None))
        squares = node("add", squares, node("mul", away, away))
    return Scalar(node("select", node("covers", grid, *_HERE), distance, node("sqrt", squares)))


#: What asks for the tasks of these names.
CALLS: Mapping[str, Call] = {"mesh": _mesh}
