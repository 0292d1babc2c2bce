"""Where things are: operations in the text, parts in the box that is written about them."""

from __future__ import annotations

from porelang.analysis.box import Box
from porelang.elaborate.values import Scalar, Vector
from porelang.ir import TASKS, Node, order
from porelang.program import Design
from porelang.source import Span

#: Beside a part that ends of itself there is this share of its longest side: no reader closes it at the box then.
AROUND = 1 / 64


def place_of(design: Design, name: str, op: str | None) -> Span:
    """The least expression of the text that an operation of an output, as it is written, comes from, but no bare name
    of it; else all of the output."""
    output = design.program.outputs[name]
    below = set(order(output.nodes))
    found = [(len(below), 0, output.span)]
    for span, value in design.program.elaborated.values.items():
        nodes = value.nodes if isinstance(value, Vector) else (value.node,) if isinstance(value, Scalar) else ()
        made = order(nodes, _here)
        if below.issuperset(nodes) and any(n.op == op for n in made) and not span.text.isidentifier():
            found.append((len(made), span.end - span.start, span))
    return min(found, key=lambda f: f[:2])[-1]


def _here(n: Node) -> tuple[Node, ...]:
    """The arguments of a node that are computed at a point, and not within a task."""
    return () if n.op in TASKS else n.args


def roomy(box: Box) -> Box:
    """A box with room about it."""
    room = AROUND * max(box.size)
    (x0, y0, z0), (x1, y1, z1) = box.lo, box.hi
    return Box((x0 - room, y0 - room, z0 - room), (x1 + room, y1 + room, z1 + room))
