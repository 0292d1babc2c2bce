"""From the graph as written to the flat graph that is evaluated: the rewrites, in order, as data."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

from porelang import ir
from porelang.ir import Node
from porelang.rewrites.gradient import gradient
from porelang.rewrites.place import place
from porelang.rewrites.simplify import Known, fold, share, simplify
from porelang.rewrites.verify import verify

Rewrite = Callable[[Sequence[Node]], list[Node]]
#: A rewrite that takes what it has made of nodes before, and adds to it.
Pure = Callable[[Sequence[Node], Known], list[Node]]


@dataclass(frozen=True, slots=True)
class Graph:
    """The roots of a program, by what they are.

    `outputs` by name, one root each or the three of a vector; `requirements` and `checks` are conditions over settings
    and numbers, in the order of the text; `contracts` are conditions on fields, each with the number of what it is
    about; `tasks` are all calls of the text that ask for one, each with its place there.
    """

    outputs: Mapping[str, tuple[Node, ...]] = field(default_factory=dict)
    requirements: tuple[Node, ...] = ()
    checks: tuple[Node, ...] = ()
    tasks: tuple[Node, ...] = ()
    contracts: tuple[tuple[int, Node], ...] = ()

    @property
    def roots(self) -> list[Node]:
        """All roots; the same one may be there more than once."""
        several = (r for roots in self.outputs.values() for r in roots)
        return [*several, *self.requirements, *self.checks, *(n for _, n in self.contracts), *self.tasks]

    def mapped(self, rewrite: Rewrite) -> Graph:
        """The graph with all of its roots rewritten together."""
        new = iter(rewrite(self.roots))
        outputs = {name: tuple(next(new) for _ in roots) for name, roots in self.outputs.items()}
        requirements, checks = (tuple(next(new) for _ in roots) for roots in (self.requirements, self.checks))
        contracts = tuple((which, next(new)) for which, _ in self.contracts)
        return Graph(outputs, requirements, checks, tuple(new), contracts)


@dataclass(frozen=True, slots=True)
class Pass:
    """A named step of the pipeline."""

    name: str
    doc: str
    run: Callable[[Graph, Known], Graph]


def _over(rewrite: Pure) -> Callable[[Graph, Known], Graph]:
    return lambda graph, known: graph.mapped(lambda roots: rewrite(roots, known))


def _contracts(graph: Graph, known: Known) -> Graph:
    """`ensure` nodes taken out of the values; what they ensure is kept beside the roots. `known` are nodes below which
    nothing is ensured: they stay as they are."""
    found: dict[tuple[int, Node], None] = {}

    def taken_out(roots: Sequence[Node]) -> list[Node]:
        new: dict[Node, Node] = {}
        for n in ir.order(roots, lambda n: () if n in known else n.args):
            if n in known:
                continue
            args = tuple(known[a] if a in known else new[a] for a in n.args)
            if n.op == "ensure":
                assert isinstance(n.value, int)
                found[n.value, args[1]] = None
                new[n] = args[0]
            elif all(a in known for a in n.args):
                known[n] = n
            else:
                new[n] = ir.node(n.op, *args, value=n.value)
        return [known[r] if r in known else new[r] for r in roots]

    return replace(graph.mapped(taken_out), contracts=tuple(found))


PIPELINE: tuple[Pass, ...] = (
    Pass("gradient", "derivatives replaced by their formulas", _over(gradient)),
    Pass("place", "fields evaluated at other points get those coordinates", _over(place)),
    Pass("contracts", "contracts moved beside the values they speak of", _contracts),
    Pass("fold", "constants computed", _over(fold)),
    Pass("simplify", "identities used", _over(simplify)),
    Pass("share", "commutative arguments in one order, so that equals are one", _over(share)),
    Pass("verify", "the graph checked against the table", _over(verify)),
)


def run(graph: Graph, after: str | None = None, leave_out: frozenset[str] = frozenset()) -> Graph:
    """The graph after all passes, or after the pass named; `leave_out` skips passes (to compare with and without)."""
    for step in PIPELINE:
        if step.name not in leave_out:
            graph = step.run(graph, {})
        if step.name == after:
            break
    return graph


class Passes:
    """The passes, and what each has made of the nodes of a graph that is changed a little at a time: what it has seen
    it does not do again. The graph that comes out is the one that `run` makes."""

    def __init__(self) -> None:
        self._known: dict[str, Known] = {}

    def run(self, graph: Graph) -> Graph:
        """The graph after all passes. Errors: theirs."""
        for step in PIPELINE:
            graph = step.run(graph, self._known.setdefault(step.name, {}))
        if sum(len(known) for known in self._known.values()) > MOST_KNOWN:
            self._known = {}
        return graph


#: What passes have made of more nodes than this is forgotten: a graph that is larger is rewritten as a whole.
MOST_KNOWN = 600_000

#: So many flat graphs are remembered: doubts, bounds and samples ask for the same few one after the other.
_REMEMBERED = 64


@lru_cache(_REMEMBERED)
def flatten(*roots: Node) -> tuple[Node, ...]:
    """Roots after all passes, contracts left out."""
    return run(Graph({"": roots})).outputs[""]
