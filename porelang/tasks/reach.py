"""Which tasks roots read: of an `if` that settings or numbers decide, none of the branch that is not taken.

A condition is decided when it is met, from what it reads itself, which is found for it. One that is about an unknown
which nobody has tried yet decides nothing, and both of its branches are read.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from porelang.formula import Bindings, Slot, operand, perform
from porelang.ir import TASKS, UNKNOWN, Node, constant, unknown
from porelang.tape import Tape, lower

#: What computes a task from bindings.
Find = Callable[[Node, Bindings], Slot]


class Reach:
    """What is read with some bindings: conditions are decided once, whatever is asked, and what they read is kept."""

    def __init__(self, bindings: Bindings, find: Find):
        self.bindings: dict[Node, Slot] = {n: v for n, v in bindings.items() if v is not None}
        self._find = find
        self._values: dict[Node, Any] = {}  # of what is known before any point; None where it is not decided

    def tasks(self, roots: Sequence[Node]) -> list[Node]:
        """The tasks that roots read, but not those that these read in turn."""
        tape = lower(tuple(roots))
        slots = [i for i in tape.slots if tape.ops[i] in TASKS]
        if tape.choices and slots:
            reached = self._positions(tape)
            slots = [i for i in slots if i in reached]
        return [tape.nodes[i] for i in slots]

    def throughout(self, roots: Sequence[Node]) -> list[Node]:
        """The tasks that roots read, and those that these read in turn."""
        found: dict[Node, None] = {}
        waiting: list[tuple[Reach, Sequence[Node]]] = [(self, roots)]
        while waiting:
            here, some = waiting.pop()
            for n in here.tasks(some):
                if n not in found:
                    found[n] = None
                    waiting.append((here._within(n), n.args))
        return list(found)

    def slot(self, n: Node) -> Slot:
        """What a task has found, found now if need be."""
        if n not in self.bindings:
            self.bindings[n] = self._find(n, self.bindings)
        return self.bindings[n]

    def _within(self, n: Node) -> Reach:
        """What holds for the arguments of a task: a `solve` looks for an unknown of its own."""
        if n.op != "solve":
            return self
        assert isinstance(n.value, int)
        sought = unknown(n.value)
        if sought not in self.bindings:
            return self
        return Reach({m: v for m, v in self.bindings.items() if m is not sought}, self._find)

    def _positions(self, tape: Tape) -> set[int]:
        """The positions of a tape that its roots read."""
        reached: set[int] = set()
        waiting = list(tape.roots)
        while waiting:
            i = waiting.pop()
            if i not in reached:
                reached.add(i)
                waiting.extend(self._read(tape, i))
        return reached

    def _read(self, tape: Tape, i: int) -> Sequence[int]:
        """The positions that one reads."""
        inputs = tape.inputs[i]
        if i not in tape.choices:
            return inputs
        chosen = self._value(tape, inputs[0])
        return inputs if chosen is None else (inputs[0], inputs[1] if chosen else inputs[2])

    def _value(self, tape: Tape, wanted: int) -> Any:
        """The value of a position that is known before any point, of what it reads found now; None: not decided."""
        values = self._values
        waiting = [wanted]
        while waiting:
            i = waiting[-1]
            n = tape.nodes[i]
            if n in values:
                waiting.pop()
                continue
            inputs = tape.inputs[i]
            if i in tape.choices:
                condition = tape.nodes[inputs[0]]
                if condition not in values:
                    waiting.append(inputs[0])
                    continue
                if values[condition] is not None:
                    inputs = (inputs[1] if values[condition] else inputs[2],)
            missing = [a for a in inputs if tape.nodes[a] not in values]
            if missing:
                waiting.extend(missing)
                continue
            known = [values[tape.nodes[a]] for a in inputs]
            if not inputs:
                values[n] = self._leaf(n)
            elif any(v is None for v in known):
                values[n] = None
            elif i in tape.choices:
                values[n] = known[0]
            else:
                with np.errstate(all="ignore"):
                    values[n] = perform(tape, i, known)
        return values[tape.nodes[wanted]]

    def _leaf(self, n: Node) -> Any:
        if n.op == "const":
            return operand(constant(n))
        if n.op in TASKS and not self._guesses(n):
            return operand(self.slot(n))
        return operand(self.bindings.get(n))

    def _guesses(self, n: Node) -> bool:
        """Whether a task reads an unknown that nobody has tried."""
        tried = sum(m.depends for m in self.bindings if m.op == "unknown")
        return bool(n.depends // UNKNOWN * UNKNOWN & ~tried)
