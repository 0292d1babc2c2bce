"""Where a field can be seen: points of the outputs that read it."""

from __future__ import annotations

import numpy as np

from porelang.analysis.sampled import Points, inside_of
from porelang.elaborate.results import Elaborated
from porelang.formula import Bindings
from porelang.ir import Node, order, within


def parts_of(made: Node, found: Elaborated, bindings: Bindings) -> Points | None:
    """Points of the outputs that read a field where it is; None where there are none."""
    for output in found.outputs.values():
        reached = order(output.nodes, lambda n: n.args[1:] if n.op == "at" else within(n))
        if made in reached and len(output.nodes) == 1:
            with np.errstate(over="ignore"):  # of a field without an end
                return inside_of(output.nodes[0], bindings)
    return None
