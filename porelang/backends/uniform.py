"""The uniform stage: what depends on params alone, computed once in float64 and handed to every backend as numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from porelang.ir import Node, Stage, order
from porelang.ir import node as make
from porelang.ops import TABLE

Number = float | bool


def uniform_values(nodes: Iterable[Node], params: Mapping[str, float]) -> dict[Node, Number]:
    """The values of const and uniform nodes for these params."""
    wanted = list(nodes)
    known: dict[Node, object] = {}
    with np.errstate(all="ignore"):
        for n in order(wanted):
            if n.op == "const":
                known[n] = n.value if isinstance(n.value, bool) else np.float64(n.value or 0.0)
            elif n.op == "param":
                known[n] = np.float64(params[str(n.value)])
            else:
                known[n] = TABLE[n.op].numpy(*(known[a] for a in n.args))
    return {n: bool(v) if isinstance(v := known[n], bool | np.bool_) else float(v) for n in wanted}  # type: ignore[arg-type]  # a NumPy scalar


def take_branches(root: Node, params: Mapping[str, float]) -> Node:
    """The graph with every choice that params decide already made, so that only the chosen branch is computed."""
    choices = [n for n in order([root]) if n.op == "select" and n.args[0].stage is Stage.UNIFORM]
    if not choices:
        return root
    chosen = uniform_values({n.args[0] for n in choices}, params)
    new: dict[Node, Node] = {}
    for n in order([root]):
        if n.op == "select" and n.args[0] in chosen:
            new[n] = new[n.args[1] if chosen[n.args[0]] else n.args[2]]
        else:
            new[n] = make(n.op, *(new[a] for a in n.args), value=n.value)
    return new[root]
