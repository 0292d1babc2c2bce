"""A formula: roots of the flat graph together with a value for every slot that they read.

Nothing of a formula is open but the point. It is what evaluators, enclosures and searches take; a design makes it
(`porelang.program`), from its settings and from what its tasks found.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from porelang.data import Data
from porelang.interval import Interval
from porelang.ir import SLOTS, Node, Stage, constant, order, param, within
from porelang.ir import node as make
from porelang.ops import TABLE
from porelang.tape import PICK, Tape, lower

#: What a slot can be bound to. Where a whole range of settings is looked at, a number's range; None: anything, as
#: where nothing is known, or where only a branch reads the slot that is not taken.
Slot = float | Interval | Data | None
Bindings = Mapping[Node, Slot]


@dataclass(frozen=True, eq=False)
class Formula:
    """Roots and what their slots are bound to; `bindings` may hold more than these roots read."""

    roots: tuple[Node, ...]
    bindings: Bindings

    @classmethod
    def of(cls, *roots: Node, **params: float) -> Formula:
        """A formula of roots and params by name."""
        return cls(roots, {param(name): float(value) for name, value in params.items()})

    def with_roots(self, *roots: Node) -> Formula:
        """Other roots with the same bindings."""
        return Formula(roots, self.bindings)

    def bind(self, more: Bindings) -> Formula:
        """The same roots with some bindings replaced or added."""
        return Formula(self.roots, {**self.bindings, **more})

    @property
    def root(self) -> Node:
        """The first root; the only one of most formulas."""
        return self.roots[0]

    @cached_property
    def tape(self) -> Tape:
        return lower(self.roots)

    @cached_property
    def known(self) -> dict[int, Any]:
        """The values of all positions that no point changes, in float64: numbers, conditions and data."""
        tape = self.tape
        found: dict[int, Any] = {}
        with np.errstate(all="ignore"):
            for i, n in enumerate(tape.nodes):
                if tape.stages[i] is not Stage.FIELD:
                    found[i] = self._value(i, n, found)
        return found

    def _value(self, i: int, n: Node, found: Mapping[int, Any]) -> Any:
        tape = self.tape
        if n.op == "const":
            return operand(constant(n))
        if n.op in SLOTS:
            value = self.bindings[n]
            return np.float64(np.nan) if value is None and tape.kinds[i] == "real" else operand(value)
        arguments = [found[a] for a in tape.inputs[i]]
        if any(a is None for a in arguments):  # data that no branch which is taken reads
            return (np.float64(np.nan),) * len(TABLE[n.op].results) or np.float64(np.nan)
        return perform(tape, i, arguments)

    @cached_property
    def numbers(self) -> tuple[Any, ...]:
        """The values of roots that are no fields: numbers or conditions."""
        return tuple(self.known[r] for r in self.tape.roots)

    @cached_property
    def taken(self) -> Formula:
        """The formula with every choice that its settings decide made, so that only what is chosen is computed."""
        choices = [n for n in order(self.roots, within) if n.op == "select" and n.args[0].stage is Stage.UNIFORM]
        if not choices:
            return self
        conditions = tuple(dict.fromkeys(n.args[0] for n in choices))
        chosen = dict(zip(conditions, self.with_roots(*conditions).numbers, strict=True))
        new: dict[Node, Node] = {}
        for n in order(self.roots, within):
            if n.op == "select" and n.args[0] in chosen:
                new[n] = new[n.args[1] if chosen[n.args[0]] else n.args[2]]
            elif within(n):
                new[n] = make(n.op, *(new[a] for a in n.args), value=n.value)
            else:
                new[n] = n
        return self.with_roots(*(new[r] for r in self.roots))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickled without what can be lowered anew, and with no more bindings than are read."""
        read = {n: self.bindings[n] for i in self.tape.slots if (n := self.tape.nodes[i]) in self.bindings}
        return Formula, (self.roots, read)


def operand(value: bool | Slot) -> Any:
    """A constant or what a slot is bound to, as operations take it: numbers in float64, the rest as it is."""
    return np.float64(value) if isinstance(value, float | int) and not isinstance(value, bool) else value


def perform(tape: Tape, i: int, arguments: list[Any], out: Any = None) -> Any:
    """The result of the operation at a position, by its NumPy form."""
    if tape.ops[i] == PICK:
        wanted = tape.values[tape.inputs[i][0]]
        assert isinstance(wanted, tuple)
        return arguments[0][wanted.index(str(tape.values[i]))]
    row = TABLE[tape.ops[i]]
    if row.payload or row.results:
        arguments = [*arguments, tape.values[i]]
    return row.numpy(*arguments) if out is None else row.numpy(*arguments, out=out)


def ranges(params: Mapping[str, tuple[float, float]]) -> dict[Node, Slot]:
    """Params over their whole ranges, as bindings."""
    never = np.array(False)
    return {param(name): Interval(np.array(lo), np.array(hi), never) for name, (lo, hi) in params.items()}
