"""Finds tasks when a root reads them, those that they read themselves first, and nothing that no root reads.

Of an `if` that settings decide only the branch that is taken is read; what only the other one reads is bound to None,
which stands for anything.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import cast

import numpy as np

from porelang import store
from porelang.analysis.enclose import enclose
from porelang.data import Data, Reduced
from porelang.diagnostics import PoreError
from porelang.formula import Bindings, Formula, Slot
from porelang.interval import interval
from porelang.ir import TASKS, UNKNOWN, Node, node, order, unknown, within
from porelang.once import alone
from porelang.ops import TASK_TABLE
from porelang.progress import activity
from porelang.source import Span
from porelang.store import Result
from porelang.tape import lower
from porelang.tasks.identity import identity
from porelang.tasks.numbers.places import Line
from porelang.tasks.numbers.roots import answer_of, checked, root_of
from porelang.tasks.numbers.trends import one_way, trend
from porelang.tasks.reach import Reach
from porelang.tasks.run import LOOKERS, READERS, RUN

#: What `solve` says where a number within its error has several answers, or none for a jump.
_SEVERAL = ("E098", "E099")
#: Where each task is asked for, so that what goes wrong is told there.
Places = Mapping[Node, Span]


def tasks_below(roots: Sequence[Node]) -> list[Node]:
    """The tasks of all branches of roots, but not those that these tasks read in turn."""
    tape = lower(tuple(roots))
    return [tape.nodes[i] for i in tape.slots if tape.ops[i] in TASKS]


def all_read(roots: Sequence[Node], bindings: Bindings, places: Places) -> list[Node]:
    """The tasks that roots read with these bindings, and those that these read in turn; conditions are decided."""
    return _reach(bindings, places).throughout(roots)


def bind_files(roots: Sequence[Node], bindings: Bindings, places: Places) -> Bindings:
    """The bindings with the data of the files that the roots read, directly or through tasks, and of no others.

    To know which these are may take numbers that decide between branches: they are found.
    """
    others = {n: v for n, v in bindings.items() if n.op not in READERS}
    if not any(n.op in READERS for n in order(roots)):
        return others
    reach = _reach(bindings, places)
    return {**others, **{n: reach.slot(n) for n in reach.throughout(roots) if n.op in READERS}}


def bind_tasks(roots: Sequence[Node], bindings: Bindings, places: Places) -> Bindings:
    """The bindings with what every task that the roots read has found, and None for those of branches not taken."""
    reach = _reach(bindings, places)
    nothing: dict[Node, Slot] = dict.fromkeys(tasks_below(roots))
    return {**nothing, **bindings, **{n: reach.slot(n) for n in reach.tasks(roots)}}


def _reach(bindings: Bindings, places: Places) -> Reach:
    return Reach(bindings, lambda n, bound: slot_value(find(n, bound, places)))


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
        if n.op in READERS or n.op == "bound":
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
        raise _told_at(error, places.get(n)) from None


def leave(n: Node, bindings: Bindings, places: Places, found: Result) -> None:
    """Keep what a task finds with these bindings, as `find` would have: who has it from elsewhere spares that."""
    bindings = bind_files([n], {m: v for m, v in bindings.items() if _settled(m)}, places)
    store.put(identity(n, bindings, partial(_content, bindings)), found, label=_label(n, places))


def named(n: Node, bindings: Bindings) -> str:
    """What `find` would keep the result of a task by: a digest of all that it depends on."""
    return identity(n, bindings, partial(_content, bindings))


def look(n: Node, places: Places) -> None:
    """Say what is plainly wrong with the file that a task takes long to read. Errors: as those of `find`."""
    try:
        LOOKERS[n.op](n)
    except PoreError as error:
        raise _told_at(error, places.get(n)) from None


def _told_at(error: PoreError, place: Span | None) -> PoreError:
    return PoreError([replace(d, span=d.span or place) for d in error.diagnostics])


def _read(n: Node) -> Data:
    with activity(TASK_TABLE[n.op].activity):
        return READERS[n.op](n)


def _settled(m: Node) -> bool:
    """Whether a slot holds what the design has: a setting, data or a file, and no number that somebody moves."""
    return m.op in ("param", "bound") or m.op in READERS


def _content(bindings: Bindings, n: Node) -> str:
    """The digest of what a task has read from outside; of what no branch that is taken reads, that it has not."""
    if n.op == "bound":
        return cast(Data, bindings[n]).digest
    if n.op not in READERS:
        return ""
    return cast(Data, bindings[n]).digest if n in bindings else "not read"


def _label(n: Node, places: Places) -> str:
    place = places.get(n)
    return " ".join(place.text.split()) if place is not None else n.op


def _computed(n: Node, bindings: Bindings, places: Places) -> Result:
    """A task with those that it reads found first; what their errors may change is added to its own."""
    if n.op == "solve":
        return _solved(n, bindings, places)
    with np.errstate(all="ignore"):  # a field may be infinite somewhere
        return _with_errors(
            n.args, bindings, places, lambda roots, filled: RUN[n.op](Formula(tuple(roots), filled).taken)
        )


def _with_errors(
    roots: Sequence[Node], bindings: Bindings, places: Places, compute: Callable[[Sequence[Node], Bindings], Result]
) -> Result:
    """What is computed from roots and all that they read, with the errors of those numbers added to its own.

    A number may be read through data: samples of a field that reads it are sampled again with the number moved. Where a
    moved number is one that cannot be (a porosity below 0), the other side tells what its error may change. Where an
    `if` may go either way for values within the error, both ways count.
    """
    filled = bind_tasks(roots, bindings, places)
    out = compute(roots, filled)
    if not isinstance(out, Reduced):
        return out
    error = out.error
    for source in _sources(roots, bindings, places):
        known = find(source, bindings, places)
        assert isinstance(known, Reduced)
        if not known.error:
            continue
        changes: list[float] = []
        met = [(0.0, out.value)]

        def change(others: Sequence[Node], bound: Bindings, changes: list[float] = changes) -> float:
            other = compute(others, bound)
            assert isinstance(other, Reduced)
            changes.append(abs(other.value - out.value) + max(0.0, other.error - out.error))
            return other.value

        for side in _looked_at(roots, filled, source, known):
            try:
                bound = {**bindings, source: known.value + side * known.error}
                met.append((side, change(roots, _moved(roots, bound, places, source))))
            except PoreError as error_there:  # a number that cannot be; but of several answers any may be meant
                if any(d.code in _SEVERAL for d in error_there.diagnostics):
                    changes.append(math.inf)
        for condition in _undecided(roots, filled, source, known):
            for way in (True, False):
                others = tuple(_with_choice(root, condition, way) for root in roots)
                try:
                    change(others, bind_tasks(others, bindings, places))
                except PoreError:  # an `if` may guard against just that: nothing is known then, but what was found
                    changes.append(math.inf)
        error += math.inf if _oscillates(met, out.error) else max(changes, default=math.inf)
    return replace(out, error=error)


#: Where a result is looked at that may turn within the error of a number: so far from it, in errors to either side.
_BETWEEN = (-1.0, -0.7, -0.3, 0.3, 0.7, 1.0)
_ROUNDED = 2.0**-48  # of a number: of one that is known so well there are a dozen others at most within its error


def _looked_at(roots: Sequence[Node], filled: Bindings, source: Node, known: Reduced) -> Sequence[float]:
    """How many errors from a number its effect is looked at: the ends tell where one root alone reads it, and is proven
    to rise or to fall with it throughout; and of a number that is known to its rounding, between which nothing lies."""
    if known.error <= _ROUNDED * abs(known.value):
        return (-1.0, 1.0)
    reading = [root for root in roots if source in order([root], within)]
    ends = known.value - known.error, known.value + known.error
    if len(reading) == 1 and math.isfinite(known.error) and one_way(reading[0], source, *ends, filled):
        return (-1.0, 1.0)
    return _BETWEEN


def _oscillates(met: Sequence[tuple[float, float]], noise: float) -> bool:
    """Whether values turn more than once, by more than `noise`, so that between them they may be anything."""
    values = [value for _, value in sorted(met)]
    steps = [b - a for a, b in pairwise(values) if abs(b - a) > max(noise, 1e-9 * abs(a))]
    return sum((a > 0) != (b > 0) for a, b in pairwise(steps)) > 1


def _undecided(roots: Sequence[Node], filled: Bindings, source: Node, known: Reduced) -> list[Node]:
    """The conditions of roots that may go either way for a number within its error."""
    tape = lower(tuple(roots))
    conditions = dict.fromkeys(tape.nodes[tape.inputs[i][0]] for i in sorted(tape.choices))
    within_error = interval(known.value - known.error, known.value + known.error)
    found: list[Node] = []
    for condition in conditions:
        if source in order([condition], within):
            truth = enclose(Formula((condition,), {**filled, source: within_error}))[0].range
            if truth.lo < 1 and truth.hi > 0:
                found.append(condition)
    return found


def _with_choice(root: Node, condition: Node, way: bool) -> Node:
    """A root in which every `if` of a condition goes one way."""
    new: dict[Node, Node] = {}
    for n in order([root], within):
        if n.op == "select" and n.args[0] is condition:
            new[n] = new[n.args[1 if way else 2]]
        else:
            new[n] = node(n.op, *(new[a] for a in n.args), value=n.value) if within(n) else n
    return new[root]


def _sources(roots: Sequence[Node], bindings: Bindings, places: Places) -> list[Node]:
    """The numbers that roots read, directly or through data; but not through a study, which errs more by its elements
    than by them, and takes too long to be solved again for each."""
    out: dict[Node, None] = {}
    for m in _reach(bindings, places).tasks(roots):
        if TASK_TABLE[m.op].result == "real":
            out[m] = None
        elif m.op != "study":
            out.update(dict.fromkeys(_sources(m.args, bindings, places)) if m.args else {})
    return list(out)


def _moved(roots: Sequence[Node], bindings: Bindings, places: Places, source: Node) -> Bindings:
    """The bindings of all that roots read where `source` is already bound to another value than it has."""
    values: dict[Node, Slot] = dict.fromkeys(tasks_below(roots))
    for m in _reach(bindings, places).tasks(roots):
        if m is source:
            values[m] = bindings[m]
        elif TASK_TABLE[m.op].result != "real" and m.args and source in _sources(m.args, bindings, places):
            values[m] = slot_value(RUN[m.op](Formula(m.args, _moved(m.args, bindings, places, source)).taken))
        else:
            values[m] = slot_value(find(m, bindings, places))
    return {**bindings, **values}


def _solved(n: Node, bindings: Bindings, places: Places) -> Result:
    """The one number for which a function, any formula of numbers, takes a value."""
    assert isinstance(n.value, int)
    inner, *ends = n.args
    sought = unknown(n.value)
    lines = _lines(inner, sought, bindings, places)

    def function(t: float) -> Reduced:
        def at(roots: Sequence[Node], filled: Bindings) -> Reduced:
            return Reduced(float(Formula(tuple(roots), filled).numbers[0]), 0.0)

        found = _with_errors([inner], {**bindings, sought: t}, places, at)
        assert isinstance(found, Reduced)
        return found

    def solution(roots: Sequence[Node], filled: Bindings) -> Reduced:
        target, low, high = (float(v) for v in Formula(tuple(roots), filled).numbers)
        checked(target, low, high)
        if lines is not None:
            settled, ranged = (Line(formula, sought, target) for formula in lines)
            return answer_of(ranged, settled, target, low, high)
        return root_of(function, target, low, high, trend(inner, sought, low, high, bindings) != 0)

    return _with_errors(ends, bindings, places, solution)


def _lines(inner: Node, sought: Node, bindings: Bindings, places: Places) -> tuple[Formula, Formula] | None:
    """A formula of what a `solve` looks for, with the numbers that it reads as they are, and as ranges by their errors;
    None where it asks for numbers again for each value, or reads them in ways that a range does not cover."""
    if any(m.op in TASKS and m.depends & sought.depends for m in order([inner], within)):
        return None
    try:
        filled = {m: v for m, v in bind_tasks([inner], bindings, places).items() if m is not sought}
        moved = {m: found for m in _sources([inner], bindings, places) if (found := _number(m, bindings, places)).error}
    except PoreError:  # of a branch that no value reads, perhaps
        return None
    settled = Formula((inner,), filled)
    direct = {settled.tape.nodes[i] for i in settled.tape.slots}
    conditions = {settled.tape.nodes[settled.tape.inputs[i][0]] for i in settled.tape.choices}
    if not moved.keys() <= direct or any(c.depends & sought.depends == 0 and _reads(c, moved) for c in conditions):
        return None
    ranges = {m: interval(r.value - r.error, r.value + r.error) for m, r in moved.items()}
    return settled, settled.bind(ranges)


def _reads(root: Node, numbers: Mapping[Node, Reduced]) -> bool:
    return any(m in numbers for m in order([root], within))


def _number(m: Node, bindings: Bindings, places: Places) -> Reduced:
    found = find(m, bindings, places)
    assert isinstance(found, Reduced)
    return found
