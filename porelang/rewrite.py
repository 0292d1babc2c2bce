"""Rewriting: named local rules, applied to every node until none fits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from porelang.ir import Into, Node, order, rebuild, whole
from porelang.ir import node as make

#: A node is rewritten at most this often: a pair of rules that undo each other is a mistake in the rules.
MOST_STEPS = 50


@dataclass(frozen=True, slots=True)
class Rule:
    """A rewrite of nodes with the operation `op`: `apply` returns the better node, or None where it does not fit."""

    name: str
    op: str
    apply: Callable[[Node], Node | None]


def rewrite(
    roots: Sequence[Node], rules: Sequence[Rule], into: Into = whole, known: dict[Node, Node] | None = None
) -> list[Node]:
    """The graph after all rules, from the leaves up; what a rule makes is rewritten in turn. `known` are nodes that the
    same rules were applied to before, and is added to."""
    by_op: dict[str, list[Rule]] = {}
    for rule in rules:
        by_op.setdefault(rule.op, []).append(rule)
    done: dict[Node, Node] = {} if known is None else known

    def settled(n: Node) -> Node:
        """A node with its arguments as they have been settled."""
        return make(n.op, *(done.get(a, a) for a in n.args), value=n.value) if into(n) else n

    def settle(n: Node) -> Node:
        """A node whose arguments are settled, rewritten until it is settled itself."""
        for _ in range(MOST_STEPS):
            if n in done:
                return done[n]
            made = next((m for r in by_op.get(n.op, ()) if (m := r.apply(n)) is not None and m is not n), None)
            if made is None:
                return n
            for new in order([made], lambda n: () if n in done else into(n)):
                if new is not made and new not in done:
                    done[new] = settle(settled(new))
            n = made if made in done else settled(made)
        raise AssertionError(f"rewriting of `{n.op}` does not end")

    def step(n: Node) -> Node:
        out = settle(n)
        done[n] = out
        done[out] = out
        return out

    return rebuild(roots, step, into, done if known is not None else None)
