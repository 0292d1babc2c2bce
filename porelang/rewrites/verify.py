"""What every graph must keep to after the rewrites; a breach is our mistake, never a user's."""

from __future__ import annotations

from collections.abc import Sequence

from porelang.ir import TASKS, Node, order
from porelang.ops import TABLE, kind

_LEAVES = ("const", "param", "unknown", "x", "y", "z")


def verify(roots: Sequence[Node], known: dict[Node, None] | None = None) -> list[Node]:
    """The same graph, if every node is a known operation with arguments of the right number and kind; `known` are nodes
    that were looked at before, and is added to."""
    known = {} if known is None else known
    for n in order(roots, lambda n: () if n in known else n.args):
        if n in known:
            continue
        known[n] = None
        if n.op in _LEAVES:
            wanted: tuple[str, ...] = ()
        elif n.op in TABLE:
            wanted = TABLE[n.op].args
        elif n.op in TASKS:
            continue
        else:
            raise AssertionError(f"`{n.op}` is left after the passes")
        got = tuple(kind(a) for a in n.args)
        if len(got) != len(wanted) or any(w not in ("any", g) for w, g in zip(wanted, got, strict=True)):
            raise AssertionError(f"`{n.op}` takes {wanted}, not {got}")
    return list(roots)
