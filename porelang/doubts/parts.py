"""Where a lattice can be seen: the outputs that hold it, moved as they move it, and their points that it decides."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from porelang.analysis.sampled import Points, Sampler, inside_of, sampler
from porelang.elaborate.results import Elaborated
from porelang.formula import Bindings
from porelang.ir import TASKS, Node, const, node, order, substitute, within
from porelang.rewrites import flatten

#: From a solid down to a lattice in it: each node on the way, and which of its arguments is next.
Way = list[tuple[Node, int]]


def way_to(lattice: Node, root: Node) -> Way | None:
    """How a lattice is found in a solid; None where it is not, or only in what moves another field."""

    def below(n: Node) -> tuple[Node, ...]:
        return n.args[:1] if n.op == "at" else within(n)

    holds: set[Node] = set()
    for n in order([root], below):  # arguments come first
        if n is lattice or any(a in holds for a in below(n)):
            holds.add(n)
    way: Way = []
    here = root
    if root not in holds:
        return None
    while here is not lattice:
        i = next(i for i, a in enumerate(below(here)) if a in holds)
        way.append((here, i))
        here = here.args[i]
    return way


def seen_from(way: Way, field: Node) -> Node:
    """A field of a lattice's own place as it is seen where the solid is: moved, turned and bent as the lattice is."""
    for n, _ in reversed(way):
        if n.op == "at":
            field = node("at", field, *n.args[1:])
    return field


def reads_tasks(lattice: Node) -> bool:
    """Whether a lattice reads what tasks find: samples, a file or a phase that is known within a box."""
    return any(n.op in TASKS for n in order(flatten(lattice)))


#: More than any value of a lattice, and than any distance in a part: what is larger or smaller by it is void or solid.
MUCH = 1e6


@dataclass(frozen=True, eq=False)
class Part:
    """An output that holds a lattice: its solid, the way down to the lattice, and what solids of it would be if the
    lattice were void, or solid."""

    root: Node
    way: Way
    _solid: Sampler

    def seen(self, field: Node) -> Node:
        """A field of the lattice's own place as it is where the part is."""
        return seen_from(self.way, field)

    def shows(self, points: Points) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Which points are solid because the lattice is: a hub, a skin or a base would be there without it."""
        here, void, solid = self._solid(points)
        return np.asarray((here < 0) & ~((void < 0) & (solid < 0)))


def parts_of(made: Node, found: Elaborated, bindings: Bindings) -> Iterator[tuple[Part, Points]]:
    """The outputs with an end that hold a field, each with points of it where that decides what is solid."""
    for output in found.outputs.values():
        way = way_to(made, output.nodes[0]) if len(output.nodes) == 1 else None
        if way is None:
            continue
        root = output.nodes[0]
        others = [substitute([root], {made: made + const(more)})[0] for more in (MUCH, -MUCH)]
        solid = sampler([root, *others], bindings)
        with np.errstate(over="ignore"):  # of a field without an end
            points = inside_of(root, bindings)
        if solid is None or points is None:
            continue
        part = Part(root, way, solid)
        points = points[part.shows(points)]
        if len(points):
            yield part, points
