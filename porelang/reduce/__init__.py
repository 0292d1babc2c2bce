"""Numbers found from whole fields, before the fields that need them: porosities, volumes, extremes, solutions.

Each comes with an error that holds: a proven gap for extremes, three standard deviations of a randomised estimate
for what is
integrated. Results are remembered by content: the same question about the same fields is computed once.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping

from porelang.backends.uniform import uniform_values
from porelang.diagnostics import fail
from porelang.ir import REDUCTIONS, Node, const, order, show
from porelang.ir import node as make
from porelang.reduce.area import area
from porelang.reduce.extremes import maximum, minimum
from porelang.reduce.integrals import Reduced as Reduced
from porelang.reduce.integrals import mean, offset_for, porosity, volume
from porelang.reduce.roots import root_of

_KEPT = 512
_known: OrderedDict[object, Reduced] = OrderedDict()


def number(n: Node, params: Mapping[str, float]) -> Reduced:
    """The value of a uniform node that may read reductions, with the error of the reduction at its root, if it is
    one."""
    if n.op in REDUCTIONS:
        return reduction(n, params)
    return Reduced(float(uniform_values([resolved(n, params)], params)[resolved(n, params)]), 0.0)


def resolved(root: Node, params: Mapping[str, float]) -> Node:
    """The graph with every reduction replaced by its value."""
    if not any(n.op in REDUCTIONS for n in order([root])):
        return root
    new: dict[Node, Node] = {}
    for n in order([root], lambda n: () if n.op in REDUCTIONS else n.args):
        if n.op in REDUCTIONS:
            new[n] = const(reduction(n, params).value)
        else:
            new[n] = make(n.op, *(new[a] for a in n.args), value=n.value)
    return new[root]


def reduction(n: Node, params: Mapping[str, float]) -> Reduced:
    """The value and error of one reduction, from memory where the same has been asked before."""
    read = sorted({str(m.value) for m in order([n]) if m.op == "param"} & params.keys())
    key = (show({"": n}), tuple((name, params[name]) for name in read))
    found = _known.pop(key, None)
    if found is None:
        found = _compute(n, params)
    _known[key] = found
    if len(_known) > _KEPT:
        _known.popitem(last=False)
    return found


def _compute(n: Node, params: Mapping[str, float]) -> Reduced:
    if n.op == "solve":
        inner, *rest = n.args
        target, low, high = (number(a, params).value for a in rest)
        unknown = f"?{n.value}"
        return root_of(lambda t: number(inner, {**params, unknown: t}), target, low, high)
    fields = [resolved(a, params) for a in n.args]
    match n.op:
        case "porosity":
            return porosity(fields[0], fields[1], params)
        case "volume":
            return volume(fields[0], params)
        case "area":
            return area(fields[0], params)
        case "minimum":
            return minimum(fields[0], fields[1], params)
        case "maximum":
            return maximum(fields[0], fields[1], params)
        case "mean":
            return mean(fields[0], fields[1], params)
    field, phi, within = fields
    share = float(uniform_values([phi], params)[phi])
    if not 0 < share < 1:
        raise fail(
            "E090", f"a porosity of {share:g} cannot be asked for", hint="it lies between 0 and 1: write 50% or 0.5"
        )
    if n.op == "shell_to_porosity":
        found = offset_for(make("abs", field), share, within, params)
        return Reduced(2 * found.value, 2 * found.error)
    return offset_for(field, share, within, params)
