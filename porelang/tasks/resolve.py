"""Finds tasks when a root reads them, those that they read themselves first, and nothing that no root reads.

Of an `if` that settings decide only the branch that is taken is read; what only the other one reads is bound to None,
which stands for anything.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import cast

from porelang import store
from porelang.data import Data, Reduced
from porelang.diagnostics import PoreError
from porelang.formula import Bindings, Formula, Slot
from porelang.ir import TASKS, UNKNOWN, Node, order, unknown, within
from porelang.once import alone
from porelang.ops import TASK_TABLE
from porelang.progress import activity
from porelang.source import Span
from porelang.store import Result
from porelang.tape import lower
from porelang.tasks.identity import identity
from porelang.tasks.numbers.roots import root_of
from porelang.tasks.run import READERS, RUN

#: Where each task is asked for, so that what goes wrong is told there.
Places = Mapping[Node, Span]


def tasks_read(roots: Sequence[Node]) -> list[Node]:
    """The tasks that roots read, but not those that these tasks read in turn."""
    tape = lower(tuple(roots))
    return [tape.nodes[i] for i in tape.slots if tape.ops[i] in TASKS]


def tasks_reached(roots: Sequence[Node], bindings: Bindings, places: Places) -> list[Node]:
    """The tasks that roots read with these bindings: none of a branch that is not taken."""
    tape = lower(tuple(roots))
    if not tape.choices or not any(tape.ops[i] in TASKS for i in tape.slots):
        return tasks_read(roots)
    reached = set(tape.roots)
    for i in reversed(range(len(tape))):
        if i not in reached:
            continue
        inputs = tape.inputs[i]
        if i in tape.choices:
            chosen = _decided(tape.nodes[inputs[0]], bindings, places)
            inputs = inputs if chosen is None else (inputs[0], inputs[1] if chosen else inputs[2])
        reached.update(inputs)
    return [tape.nodes[i] for i in tape.slots if i in reached and tape.ops[i] in TASKS]


def _decided(condition: Node, bindings: Bindings, places: Places) -> bool | None:
    """Whether a condition on settings and numbers holds; None where it is on the unknown of a `solve` around it."""
    if any(n.op == "unknown" and n not in bindings for n in order([condition], within)):
        return None
    return bool(Formula((condition,), bind_tasks([condition], bindings, places)).numbers[0])


def all_reached(roots: Sequence[Node], bindings: Bindings, places: Places) -> list[Node]:
    """The tasks that roots read with these bindings, and those that these read in turn."""
    found: dict[Node, None] = {}
    new = tasks_reached(roots, bindings, places)
    while new:
        found.update(dict.fromkeys(new))
        inner = [m for n in new if n.args for m in tasks_reached(n.args, bindings, places)]
        new = [m for m in dict.fromkeys(inner) if m not in found]
    return list(found)


def bind_files(roots: Sequence[Node], bindings: Bindings, places: Places) -> Bindings:
    """The bindings with the data of every file that the roots read, directly or through tasks."""
    if not any(n.op in READERS and n not in bindings for n in order(roots)):
        return bindings
    read = [n for n in all_reached(roots, bindings, places) if n.op in READERS and n not in bindings]
    return {**bindings, **{n: slot_value(find(n, bindings, places)) for n in read}}


def bind_tasks(roots: Sequence[Node], bindings: Bindings, places: Places) -> Bindings:
    """The bindings with what every task that the roots read has found, and None for those of branches not taken."""
    reached = [n for n in tasks_reached(roots, bindings, places) if n not in bindings]
    found: dict[Node, Slot] = {n: slot_value(find(n, bindings, places)) for n in reached}
    found |= {n: None for n in tasks_read(roots) if n not in bindings and n not in found}
    return {**bindings, **found} if found else bindings


def slot_value(found: Result) -> float | Data:
    """What a slot is bound to, of what its task has found."""
    return found.value if isinstance(found, Reduced) else found


def find(n: Node, bindings: Bindings, places: Places) -> Result:
    """What a task finds with these bindings: remembered, or computed now. An error is never kept.

    Files are read first, so that the name of a result and the result are of the same data. Numbers that are bound to
    tasks, moved to see what their errors change, are left out: no other task may find them so. Threads that want the
    same at the same time wait for the one that computes it.
    Errors: those of the task, at the place in the program that asks for it.
    """
    try:
        if n.op in READERS:
            return cast(Data, bindings[n]) if n in bindings else _read(n)
        guessed = n.depends >= UNKNOWN  # it reads what a `solve` tries: the answer of the search is kept, not this
        bindings = {m: v for m, v in bindings.items() if _settled(m) or (guessed and m.op == "unknown")}
        bindings = bind_files([n], bindings, places)
        key = identity(n, bindings, partial(_content, bindings))
        with alone(key):
            found = store.get(key)
            if found is None:
                with activity(TASK_TABLE[n.op].activity):
                    found = _computed(n, bindings, places)
                store.put(key, found, label=_label(n, places), disk=not guessed)
        return found
    except PoreError as error:
        place = places.get(n)
        raise PoreError([replace(d, span=d.span or place) for d in error.diagnostics]) from None


def _read(n: Node) -> Data:
    with activity(TASK_TABLE[n.op].activity):
        return READERS[n.op](n)


def _settled(m: Node) -> bool:
    """Whether a slot holds what the design has: a setting or a file, and no number that somebody moves."""
    return m.op == "param" or m.op in READERS


def _content(bindings: Bindings, n: Node) -> str:
    """The digest of what a task has read from outside; of what no branch that is taken reads, that it has not."""
    if n.op not in READERS:
        return ""
    data = bindings.get(n)
    return "not read" if data is None else cast(Data, data).digest


def _label(n: Node, places: Places) -> str:
    place = places.get(n)
    return " ".join(place.text.split()) if place is not None else n.op


def _computed(n: Node, bindings: Bindings, places: Places) -> Result:
    """A task with those that it reads found first; what their errors may change is added to its own."""
    if n.op == "solve":
        return _solved(n, bindings, places)
    return _with_errors(n.args, bindings, places, lambda filled: RUN[n.op](Formula(n.args, filled).taken))


def _with_errors(
    roots: Sequence[Node], bindings: Bindings, places: Places, compute: Callable[[Bindings], Result]
) -> Result:
    """What is computed from roots and all that they read, with the errors of those numbers added to its own.

    A number may be read through data: samples of a field that reads it are sampled again with the number moved. Where a
    moved number is one that cannot be (a porosity below 0), the other side tells what its error may change.
    """
    out = compute(bind_tasks(roots, bindings, places))
    if not isinstance(out, Reduced):
        return out
    error = out.error
    for source in _sources(roots, bindings, places):
        known = find(source, bindings, places)
        assert isinstance(known, Reduced)
        if not known.error:
            continue
        changes: list[float] = []
        for side in (-1, 1):
            try:
                moved = compute(_moved(roots, {**bindings, source: known.value + side * known.error}, places, source))
            except PoreError:
                continue
            assert isinstance(moved, Reduced)
            changes.append(abs(moved.value - out.value))
        error += max(changes, default=math.inf)
    return Reduced(out.value, error)


def _sources(roots: Sequence[Node], bindings: Bindings, places: Places) -> list[Node]:
    """The numbers that roots read, directly or through data."""
    out: dict[Node, None] = {}
    for m in tasks_reached(roots, bindings, places):
        if TASK_TABLE[m.op].result == "real":
            out[m] = None
        else:
            out.update(dict.fromkeys(_sources(m.args, bindings, places)) if m.args else {})
    return list(out)


def _moved(roots: Sequence[Node], bindings: Bindings, places: Places, source: Node) -> Bindings:
    """The bindings of all that roots read where `source` is already bound to another value than it has."""
    values: dict[Node, Slot] = dict.fromkeys(tasks_read(roots))
    for m in tasks_reached(roots, bindings, places):
        if m is source:
            values[m] = bindings[m]
        elif TASK_TABLE[m.op].result != "real" and m.args and source in _sources(m.args, bindings, places):
            values[m] = slot_value(RUN[m.op](Formula(m.args, _moved(m.args, bindings, places, source)).taken))
        else:
            values[m] = slot_value(find(m, bindings, places))
    return {**bindings, **values}


def _solved(n: Node, bindings: Bindings, places: Places) -> Result:
    """The number for which a function, any formula of numbers, takes a value."""
    assert isinstance(n.value, int)
    inner, *ends = n.args
    sought = unknown(n.value)

    def function(t: float) -> Reduced:
        def at(filled: Bindings) -> Reduced:
            return Reduced(float(Formula((inner,), filled).numbers[0]), 0.0)

        found = _with_errors([inner], {**bindings, sought: t}, places, at)
        assert isinstance(found, Reduced)
        return found

    def solution(filled: Bindings) -> Reduced:
        target, low, high = (float(v) for v in Formula(tuple(ends), filled).numbers)
        return root_of(function, target, low, high)

    return _with_errors(ends, bindings, places, solution)
