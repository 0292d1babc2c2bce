"""The members of a union, those that differ in their numbers alone taken together.

A row of two hundred boxes is one formula with two hundred rows of numbers: what is asked of all of them is asked once,
of arrays, instead of two hundred times.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.formula import Formula
from porelang.interval import interval
from porelang.ir import Node, const, constant, node, order, param, within

Points = NDArray[np.float64]
Ints = NDArray[np.int64]
#: Intersections within each other are followed this deep.
DEEPEST = 12
_NUMBER = -1  # an argument that is a constant


@dataclass(frozen=True, eq=False)
class Kin:
    """Solids of one formula: `numbers` (n, k) are what each of the n has in the place of its k `slots`."""

    formula: Formula
    slots: tuple[Node, ...]
    numbers: Points

    def of(self, rows: Ints) -> Formula:
        """The formula for boxes (or points) that each belong to the member of one of `rows`."""
        if not self.slots:
            return self.formula
        return self.formula.bind({s: interval(self.numbers[rows, k]) for k, s in enumerate(self.slots)})

    def with_root(self, root: Node) -> Kin:
        """The same solids with another root."""
        return Kin(self.formula.with_roots(root), self.slots, self.numbers)

    def some(self, rows: Ints) -> Kin:
        """Some of the solids."""
        return Kin(self.formula, self.slots, self.numbers[rows])

    def __len__(self) -> int:
        return len(self.numbers)


def alone(formula: Formula) -> Kin:
    """One solid."""
    return Kin(formula, (), np.zeros((1, 0)))


def kin_of(formula: Formula, union: Sequence[Node] | None = None) -> list[Kin]:
    """The members of a union by their formulas, or the one that is no union; or of those given."""
    alike: dict[Hashable, list[tuple[Node, Points]]] = {}
    for member in members(formula.root) if union is None else union:
        shape, numbers = _written(member)
        alike.setdefault(shape, []).append((member, numbers))
    return [_taken_together(formula, found) for found in alike.values()]


def members(root: Node, depth: int = DEEPEST) -> list[Node]:
    """The members of a union, or the root itself; of a union that is cut by a shape, its members cut by the shape."""
    stack, seen, out = [root], {root}, []
    while stack:
        n = stack.pop()
        if n.op == "max" and depth:
            out += _cut(n, depth - 1)
            continue
        if n.op != "min":
            out.append(n)
            continue
        for a in n.args:
            if a not in seen:
                seen.add(a)
                stack.append(a)
    return out


def _cut(n: Node, depth: int) -> list[Node]:
    """The members of an intersection, by those of the side that has more."""
    sides = [members(a, depth) for a in n.args]
    if len(sides[0]) == len(sides[1]) == 1:
        return [n]
    if len(sides[0]) < len(sides[1]):
        return [node("max", n.args[0], m) for m in sides[1]]
    return [node("max", m, n.args[1]) for m in sides[0]]


def _written(root: Node) -> tuple[Hashable, Points]:
    """What a graph is but for its constants, and these, in the order of their places."""
    number: dict[Node, int] = {}
    rows: list[Hashable] = []
    constants: list[float] = []
    for n in order([root], within):
        if _is_number(n) and n is not root:
            continue
        arguments = []
        for a in within(n):
            if _is_number(a):
                constants.append(float(constant(a)))
                arguments.append(_NUMBER)
            else:
                arguments.append(number[a])
        number[n] = len(rows)
        rows.append((n.op, n.value, tuple(arguments)) if arguments else n)
    return tuple(rows), np.array(constants)


def _is_number(n: Node) -> bool:
    return n.op == "const" and not isinstance(n.value, bool)


def _taken_together(formula: Formula, found: Sequence[tuple[Node, Points]]) -> Kin:
    """Graphs that are the same but for their constants, as one with slots in the place of those that differ."""
    first = found[0][0]
    if len(found) == 1:
        return alone(formula.with_roots(first))
    numbers = np.array([constants for _, constants in found])
    differs = (numbers != numbers[0]).any(axis=0)
    slots = {int(k): param(f"#{i}") for i, k in enumerate(np.flatnonzero(differs))}  # no param is called so
    new: dict[Node, Node] = {}
    at = 0
    for n in order([first], within):
        if _is_number(n) and n is not first:
            continue
        arguments = []
        for a in within(n):
            if _is_number(a):
                arguments.append(slots.get(at, const(float(numbers[0, at]))))
                at += 1
            else:
                arguments.append(new[a])
        new[n] = node(n.op, *arguments, value=n.value) if arguments else n
    bindings = {**formula.bindings, **dict.fromkeys(slots.values(), 0.0)}
    return Kin(Formula((new[first],), bindings), tuple(slots.values()), numbers[:, differs])
