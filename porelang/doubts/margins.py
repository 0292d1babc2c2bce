"""What points of a part show of a mesh that it was made of: that they lie where its distance is known only roughly.

Beyond the grid of a mesh its distance lies between two: by Pythagoras from the nearest place of the grid's box, which
is what the field is, and the sum of the way there and the distance there (`elaborate.solids`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np

from porelang.analysis.sampled import MOST, sampler
from porelang.data import SampledField, shown
from porelang.diagnostics import Diagnostic
from porelang.doubts.data import points_of
from porelang.doubts.elsewhere import Reading
from porelang.ir import ZERO, Node, node, order, within
from porelang.source import Span

#: So much of what is solid by either distance makes a doubt.
_SHARE, _FEW = 0.01, 8
#: How much more than what is needed is proposed; and how far beyond a part, in its sizes, it is looked at.
_ROOM, _ABOUT = 1.1, 0.2


def thin_margins(readings: Iterable[Reading], places: Mapping[Node, Span]) -> list[Diagnostic]:
    """W241 for each mesh of which a part depends where its distance is known only roughly."""
    out: dict[Node, Diagnostic] = {}
    for reading in readings:
        flat = order([reading.body], within)
        for n in flat if reading.task is None else ():
            if n.op == "select" and n.args[0].op == "covers" and (grid := n.args[0].args[0]).op == "mesh":
                data = reading.bindings.get(grid)
                found = isinstance(data, SampledField) and _beyond(reading, n)
                if isinstance(data, SampledField) and found and grid not in out:
                    out[grid] = _told(data, found, places.get(grid))
    return list(out.values())


def _beyond(reading: Reading, distance: Node) -> float:
    """How far (mm) from the grid the solid is another with the one distance than with the other; 0 for hardly."""
    body, (covered, known, least) = reading.body, distance.args
    away = node("sqrt", node("max", node("sub", node("square", least), node("square", known)), ZERO))
    most = node("select", covered, known, node("add", known, away))
    new: dict[Node, Node] = {distance: most}
    for n in order([body], within):
        if n is not distance and within(n):
            new[n] = node(n.op, *(new.get(a, a) for a in n.args), value=n.value)
    at, inside = sampler([body, new.get(body, body), away, covered], reading.bindings), points_of(reading)
    if at is None or inside is None or not len(inside):
        return 0.0
    low, high = inside.min(axis=0), inside.max(axis=0)
    more = _ABOUT * (high - low)
    points = np.random.default_rng(1).uniform(low - more, high + more, (8 * MOST, 3))
    one, other, far, near = at(points)
    solid, differs = (one < 0) | (other < 0), ((one < 0) != (other < 0)) & ~near.astype(np.bool_)
    if differs.sum() < max(_FEW, _SHARE * solid.sum()):
        return 0.0
    return float(far[differs].max())


def _told(data: SampledField, far: float, place: Span | None) -> Diagnostic:
    from porelang.tasks.shape.found import Found

    found = Found.of(data)
    margin = min(a - b for a, b in zip(found.low, data.origin, strict=True))
    said = f"the part reaches {shown(far)} mm beyond where this mesh was measured: what is 7 mm there may be 10"
    label = f"measured {shown(margin)} mm about the mesh"
    enough = (margin + far) * _ROOM
    step = 10.0 ** (math.floor(math.log10(enough)) - 1)
    hint = f"say so: `margin={shown(math.ceil(enough / step) * step)}mm`"
    return Diagnostic("W241", said, place, label, hint=hint, severity="warning")
