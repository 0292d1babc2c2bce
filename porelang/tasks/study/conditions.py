"""Conditions on places, and where they have no answer: where what they compare is not a number."""

from __future__ import annotations

from porelang.ir import Node, node


def certain_and_possible(condition: Node) -> tuple[Node, Node]:
    """What is true where a condition holds whatever the numbers are that are none, and what is true where it might.

    A comparison with what is not a number is false, and so is its contrary (IEEE 754). Where the two differ a condition
    has no answer (Kleene's strong logic of three values, 1938); elsewhere both are the condition.
    """
    known = _Known()
    return known.of(condition, False), known.of(condition, True)


class _Known:
    """The forms of conditions that are true where they hold for sure, or possibly."""

    def __init__(self) -> None:
        self.found: dict[tuple[Node, bool], Node] = {}

    def of(self, n: Node, might: bool) -> Node:
        """The form of a condition, whose graph may share much."""
        if (n, might) not in self.found:
            self.found[n, might] = self._formed(n, might)
        return self.found[n, might]

    def _formed(self, n: Node, might: bool) -> Node:
        match n.op, n.args:
            case "not", (a,):
                return node("not", self.of(a, not might))
            case "and" | "or", (a, b):
                return node(n.op, self.of(a, might), self.of(b, might))
            case "select", (c, a, b):
                first = node("and", self.of(c, might), self.of(a, might))
                return node("or", first, node("and", node("not", self.of(c, not might)), self.of(b, might)))
            case "lt", (a, b) if might:
                return node("not", node("le", b, a))
            case "le", (a, b) if might:
                return node("not", node("lt", b, a))
            case "eq", (a, b) if might:
                return node("not", node("or", node("lt", a, b), node("lt", b, a)))
        return n
