"""Numbers found from whole fields, before the fields that need them: porosities, volumes, extremes, solutions.

Each comes with an error that holds: a proven gap for extremes, three standard deviations of a randomised estimate for
what is integrated. Where a number depends on numbers that were found before, their errors count too. Results are
remembered by content, in the process and on disk: the same question about the same fields is computed once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from porelang.backends.uniform import uniform_values
from porelang.data import Reduced as Reduced
from porelang.diagnostics import fail
from porelang.ir import REDUCTIONS, Node, const, order
from porelang.ir import node as make
from porelang.tasks.numbers.area import area
from porelang.tasks.numbers.extremes import maximum, minimum
from porelang.tasks.numbers.integrals import mean, porosity, volume
from porelang.tasks.numbers.quantiles import offset_for
from porelang.tasks.numbers.roots import root_of
from porelang.tasks.store import remembered

Found = Mapping[Node, float]


def reduction(n: Node, params: Mapping[str, float]) -> Reduced:
    """The value and error of one reduction, from memory where the same has been asked before."""
    return remembered(n, params, lambda: _compute(n, params))


def _compute(n: Node, params: Mapping[str, float]) -> Reduced:
    """A reduction with the numbers that it depends on found first; what their errors may change is added to its own."""
    below = {r: reduction(r, params) for r in _tops(n.args[1:] if n.op == "solve" else n.args)}
    return _spread(lambda found: _reduced(n, found, params), below)


def _spread(compute: Callable[[Found], Reduced], below: Mapping[Node, Reduced]) -> Reduced:
    """What is computed from numbers that were found, each with its error: the error of all together."""
    found = {r: known.value for r, known in below.items()}
    out = compute(found)
    error = out.error
    for r, known in below.items():
        if known.error:
            moved = [compute({**found, r: known.value + side * known.error}).value for side in (-1, 1)]
            error += max(abs(v - out.value) for v in moved)
    return Reduced(out.value, error)


def _tops(roots: Sequence[Node]) -> list[Node]:
    """The reductions below some nodes, but not those within reductions."""
    return [n for n in order(roots, lambda n: () if n.op in REDUCTIONS else n.args) if n.op in REDUCTIONS]


def _filled(root: Node, found: Found) -> Node:
    """The graph with its reductions replaced by numbers."""
    if not found:
        return root
    new: dict[Node, Node] = {}
    for n in order([root], lambda n: () if n in found else n.args):
        new[n] = const(found[n]) if n in found else make(n.op, *(new[a] for a in n.args), value=n.value)
    return new[root]


def _number(n: Node, found: Found, params: Mapping[str, float]) -> float:
    flat = _filled(n, found)
    return float(uniform_values([flat], params)[flat])


def _of_unknown(inner: Node, params: Mapping[str, float]) -> Reduced:
    """The value of what `solve` asks for, which may be any formula of reductions."""
    below = {r: reduction(r, params) for r in _tops([inner])}
    return _spread(lambda found: Reduced(_number(inner, found, params), 0.0), below)


def _reduced(n: Node, found: Found, params: Mapping[str, float]) -> Reduced:
    if n.op == "solve":
        inner, *rest = n.args
        target, low, high = (_number(a, found, params) for a in rest)
        unknown = f"?{n.value}"
        return root_of(lambda t: _of_unknown(inner, {**params, unknown: t}), target, low, high)
    fields = [_filled(a, found) for a in n.args]
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
        half = offset_for(make("abs", field), share, within, params)
        return Reduced(2 * half.value, 2 * half.error)
    return offset_for(field, share, within, params)
