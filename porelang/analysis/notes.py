"""What can be said of each node without evaluating it at a point, as `pore show --note` prints it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from porelang.analysis.enclose import enclose_all, everywhere
from porelang.formula import Formula, ranges
from porelang.ir import Node
from porelang.tape import lower

Note = Callable[[Node], str]
#: Of a graph, given by its roots and the ranges of its params.
Notes = Callable[[Sequence[Node], Mapping[str, tuple[float, float]]], Note]


def _stage(roots: Sequence[Node], params: Mapping[str, tuple[float, float]]) -> Note:
    return lambda n: n.stage.name.lower()


def _axes(roots: Sequence[Node], params: Mapping[str, tuple[float, float]]) -> Note:
    return lambda n: "".join(a for i, a in enumerate("xyz") if n.axes >> i & 1) or "-"


def _bounds(roots: Sequence[Node], params: Mapping[str, tuple[float, float]]) -> Note:
    """The range of every node over all of space and every param's range."""
    tape = lower(tuple(roots))
    anything = {tape.nodes[i]: None for i in tape.slots}
    known = enclose_all(Formula(tuple(roots), {**anything, **ranges(params)}), everywhere())

    def note(n: Node) -> str:
        i = tape.position.get(n)
        if i is None or i not in known:
            return ""  # within the fields of a task, or data
        r = known[i].range
        lo, hi = float(np.min(r.lo)), float(np.max(r.hi))
        return f"{lo:.6g} .. {hi:.6g}{' or not a number' if np.any(r.nan) else ''}"

    return note


NOTES: dict[str, Notes] = {"stage": _stage, "axes": _axes, "bounds": _bounds}
