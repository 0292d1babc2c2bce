"""What points of a part show of a mesh that it was made of: that they lie where its distance is known only roughly.

Beyond the grid of a mesh its distance lies between two: by Pythagoras from the nearest place of the grid's box, which
is what the field is, and the sum of the way there and the distance there (`elaborate.solids`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from porelang.analysis.sampled import MOST, sampler
from porelang.data import SampledField, shown
from porelang.diagnostics import Diagnostic
from porelang.doubts.elsewhere import Reading
from porelang.formula import Bindings
from porelang.ir import ZERO, Node, node, order, within
from porelang.source import Span

#: So much of what is solid by either distance makes a doubt.
_SHARE, _FEW = 0.01, 8
#: How much more than what is needed is proposed.
_ROOM = 1.1


def thin_margins(readings: Iterable[Reading], places: Mapping[Node, Span]) -> list[Diagnostic]:
    """W241 for each mesh of which a part depends where its distance is known only roughly."""
    out: dict[Node, Diagnostic] = {}
    for reading in readings:
        flat = order([reading.body], within)
        for n in flat if reading.task is None else ():
            if n.op == "select" and n.args[0].op == "covers" and (grid := n.args[0].args[0]).op == "mesh":
                data = reading.bindings.get(grid)
                found = isinstance(data, SampledField) and _beyond(reading.body, n, data, reading.bindings)
                if isinstance(data, SampledField) and found and grid not in out:
                    out[grid] = _told(data, found, places.get(grid))
    return list(out.values())


def _beyond(body: Node, distance: Node, data: SampledField, bindings: Bindings) -> float:
    """How far (mm) from the grid the solid is another with the one distance than with the other; 0 for hardly."""
    covered, known, least = distance.args
    away = node("sqrt", node("max", node("sub", node("square", least), node("square", known)), ZERO))
    most = node("select", covered, known, node("add", known, away))
    new: dict[Node, Node] = {distance: most}
    for n in order([body], within):
        if n is not distance and within(n):
            new[n] = node(n.op, *(new.get(a, a) for a in n.args), value=n.value)
    at = sampler([body, new.get(body, body), away, covered], bindings)
    if at is None:
        return 0.0
    low, high = np.array(data.origin), np.array(data.end)
    size = high - low
    points = np.random.default_rng(1).uniform(low - size, high + size, (8 * MOST, 3))
    one, other, far, inside = at(points)
    solid, differs = (one < 0) | (other < 0), ((one < 0) != (other < 0)) & ~inside.astype(np.bool_)
    if differs.sum() < max(_FEW, _SHARE * solid.sum()):
        return 0.0
    return float(far[differs].max())


def _told(data: SampledField, far: float, place: Span | None) -> Diagnostic:
    from porelang.tasks.shape.found import Found

    found = Found.of(data)
    margin = min(a - b for a, b in zip(found.low, data.origin, strict=True))
    said = f"the part reaches {shown(far)} mm beyond where this mesh was measured: what is 7 mm there may be 10"
    label = f"measured {shown(margin)} mm about the mesh"
    hint = f"say so: `margin={shown(float(np.ceil((margin + far) * _ROOM)))}mm`"
    return Diagnostic("W241", said, place, label, hint=hint, severity="warning")
