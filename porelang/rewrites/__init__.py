"""From the graph as written to the flat graph that is evaluated: the passes, in order, as data."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from porelang import ir
from porelang.analysis.enclose import EXACT, enclose, everywhere
from porelang.interval import interval
from porelang.ir import Node, Stage
from porelang.rewrites.gradient import gradient
from porelang.rewrites.place import place
from porelang.rewrites.simplify import fold, share, simplify
from porelang.rewrites.verify import verify

Note = Callable[[Node], str]
#: What is assumed of a number that is found from fields, where shaders are made for all settings.
HIDDEN = (-1e30, 1e30)


@dataclass(frozen=True, slots=True)
class Graph:
    """A program between passes: its named roots, the range of every param, and what the passes moved out of the values.

    `contracts` are conditions on fields by number; `reductions` are numbers found from fields, by the name of the
    hidden
    param that stands for each, in an order in which each comes after those it needs.
    """

    roots: Mapping[str, Node]
    ranges: Mapping[str, tuple[float, float]]
    contracts: tuple[tuple[int, Node], ...] = ()
    reductions: tuple[tuple[str, Node], ...] = ()


@dataclass(frozen=True, slots=True)
class Pass:
    """A named step. `note` says what the step knows about a node, for `pore show --after`."""

    name: str
    doc: str
    run: Callable[[Graph], Graph]
    note: Callable[[Graph], Note] | None = None


def _over(step: Callable[[dict[str, Node]], dict[str, Node]]) -> Callable[[Graph], Graph]:
    """A pass over the roots and the contracts alike."""

    def run(graph: Graph) -> Graph:
        roots = dict(graph.roots) | {f"contract {i}": ok for i, (_, ok) in enumerate(graph.contracts)}
        new = step(roots)
        contracts = tuple((which, new.pop(f"contract {i}")) for i, (which, _) in enumerate(graph.contracts))
        return replace(graph, roots=new, contracts=contracts)

    return run


def _contracts(graph: Graph) -> Graph:
    """`ensure` nodes taken out of the values; what they ensure is kept beside the roots."""
    found: dict[tuple[int, Node], None] = {}
    new: dict[Node, Node] = {}
    for n in ir.order(graph.roots.values()):
        args = tuple(new[a] for a in n.args)
        if n.op == "ensure":
            found[int(n.value or 0), args[1]] = None
            new[n] = args[0]
        else:
            new[n] = ir.node(n.op, *args, value=n.value)
    return replace(graph, roots={name: new[r] for name, r in graph.roots.items()}, contracts=tuple(found))


def _stages(graph: Graph) -> Graph:
    """Each number that is found from whole fields replaced by a hidden param, to be computed before what needs it."""
    roots = {**graph.roots, **{f"contract {i}": ok for i, (_, ok) in enumerate(graph.contracts)}}
    tops = [n for n in ir.order(roots.values(), _above) if n.op in ir.REDUCTIONS]
    if not tops:
        return graph
    hidden = {n: ir.param(f"#{i}") for i, n in enumerate(tops)}
    new: dict[Node, Node] = {}
    for n in ir.order(roots.values(), _above):
        new[n] = hidden[n] if n in hidden else ir.node(n.op, *(new[a] for a in n.args), value=n.value)
    contracts = tuple((which, new[ok]) for which, ok in graph.contracts)
    kept = {name: new[root] for name, root in graph.roots.items()}
    ranges = {**graph.ranges, **{str(p.value): HIDDEN for p in hidden.values()}}
    return replace(
        graph,
        roots=kept,
        contracts=contracts,
        ranges=ranges,
        reductions=tuple((str(p.value), n) for n, p in hidden.items()),
    )


def _above(n: Node) -> tuple[Node, ...]:
    """The arguments of a node, but not the fields that a reduction looks into."""
    return () if n.op in ir.REDUCTIONS else n.args


def _stage_note(graph: Graph) -> Note:
    return lambda n: n.stage.name.lower()


def _axes_note(graph: Graph) -> Note:
    return lambda n: "".join(a for i, a in enumerate("xyz") if n.axes >> i & 1) or "-"


def _bounds_note(graph: Graph) -> Note:
    """The range of every node over all of space and every param's range."""
    params = {name: interval(np.array(lo), np.array(hi)) for name, (lo, hi) in graph.ranges.items()}
    nodes = ir.order(graph.roots.values())
    known = dict(zip(nodes, enclose(nodes, everywhere(), params, EXACT), strict=True))

    def note(n: Node) -> str:
        r = known[n].range
        lo, hi = float(np.min(r.lo)), float(np.max(r.hi))
        return f"{lo:.6g} .. {hi:.6g}{' or not a number' if np.any(r.nan) else ''}"

    return note


PIPELINE: tuple[Pass, ...] = (
    Pass("lower", "the graph as the program was written", lambda g: g),
    Pass("gradient", "derivatives replaced by their formulas", _over(gradient)),
    Pass("place", "fields evaluated at other points get those coordinates", _over(place)),
    Pass("contracts", "contracts moved beside the values they speak of", _contracts),
    Pass("fold", "constants computed", _over(fold)),
    Pass("simplify", "identities used", _over(simplify)),
    Pass("share", "commutative arguments in one order, so that equals are one", _over(share)),
    Pass(
        "stages", "numbers found from fields moved before what needs them; the stage of each node", _stages, _stage_note
    ),
    Pass("separate", "which coordinates each node depends on", lambda g: g, _axes_note),
    Pass("bounds", "the range of each node over all space and all params", lambda g: g, _bounds_note),
    Pass("verify", "the graph checked against the table", _over(verify)),
)


def run(graph: Graph, after: str | None = None, leave_out: frozenset[str] = frozenset()) -> Graph:
    """The graph after all passes, or after the pass named; `leave_out` skips passes (to compare with and without)."""
    for step in PIPELINE:
        if step.name not in leave_out:
            graph = step.run(graph)
        if step.name == after:
            break
    return graph


def uniforms(root: Node) -> list[Node]:
    """The frontier of the field stage: uniform nodes that a field node reads, and the root if it is no field."""
    if root.stage < Stage.FIELD:
        return [root]
    frontier: dict[Node, None] = {}
    for n in ir.order([root], lambda n: n.args if n.stage is Stage.FIELD else ()):
        if n.stage is Stage.UNIFORM:
            frontier[n] = None
    return list(frontier)
