"""Lengths that are added to what was a distance: what they are in mm, where the part has its surface."""

from __future__ import annotations

import numpy as np

from porelang.analysis.sampled import inside_of, keeps_lengths, sampler
from porelang.diagnostics import Diagnostic, Edit
from porelang.doubts.parts import seen_from, way_to
from porelang.elaborate.results import Elaborated, Suspicion
from porelang.formula import Bindings
from porelang.ir import order, within

#: By how much a length may miss what it says, at as many of the points that were looked at, before it is said.
OFF, SHARE, FEW = 0.1, 0.05, 20
#: Points that are looked at, and how far apart (mm) the values of which a slope is taken.
_MOST, _STEP = 500, 1e-4


def uneven(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """A length that is not what it says, because the field it is added to does not rise by 1 mm in each mm.

    Where a field rises by g, what is added to it is 1/g times as far, to first order.
    """
    field, length = s.nodes
    for output in found.outputs.values():
        if len(output.nodes) != 1 or field not in order(output.nodes, within):
            continue
        way = way_to(field, output.nodes[0])
        if way is None or not all(keeps_lengths(n.args[1:], bindings) for n, _ in way if n.op == "at"):
            continue
        points = inside_of(output.nodes[0], bindings)
        at = sampler([seen_from(way, field), seen_from(way, length)], bindings)
        if points is None or at is None:
            return None
        values, lengths = at(points)
        points = points[np.abs(values) <= np.abs(lengths)][:_MOST]
        if len(points) < FEW:
            return None
        steps = _STEP * np.eye(3)
        rises = [(at(points + e)[0] - at(points - e)[0]) / (2 * _STEP) for e in steps]
        with np.errstate(divide="ignore"):
            real = 1 / np.sqrt(sum(r * r for r in rises))
        off = np.abs(np.log(real)) > np.log(1 + OFF)
        if np.isnan(real).any() or off.mean() < SHARE:
            return None
        low, high = np.quantile(real, [0.05, 0.95])
        return Diagnostic(
            "W238",
            f"a length is added to what is a distance no longer: 1 mm of it is {low:.2g} to {high:.2g} mm long"
            if high - low > 0.05
            else f"a length is added to what is a distance no longer: 1 mm of it is {high:.2g} mm long",
            s.span,
            "stretched, turned or mixed, its values are no mm",
            hint=f"write `{s.instead}`: the distance to what was made" if s.instead
            else "put `metric(...)` about the field that the length is added to",
            edit=Edit(s.argument, s.instead) if s.argument is not None else None,
            severity="warning",
        )  # fmt: skip
    return None
