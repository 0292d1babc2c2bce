"""Tasks found when a root reads them, those they read themselves first, and nothing that no root reads."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import cast

from porelang import store
from porelang.data import Data, Reduced
from porelang.diagnostics import PoreError
from porelang.formula import Bindings, Formula, Slot
from porelang.ir import TASKS, Node, order, unknown
from porelang.ops import TASK_TABLE
from porelang.progress import activity, checkpoint
from porelang.source import Span
from porelang.store import Result
from porelang.tape import lower
from porelang.tasks.identity import identity
from porelang.tasks.numbers.roots import root_of
from porelang.tasks.run import OUTSIDE, RUN

#: Where each task is asked for, so that what goes wrong is told there.
Places = Mapping[Node, Span]
_POLL = 0.05  # seconds between two looks at whether a result that another thread computes is still wanted


def tasks_read(roots: Sequence[Node]) -> list[Node]:
    """The tasks that roots read, but not those that these tasks read in turn."""
    tape = lower(tuple(roots))
    return [tape.nodes[i] for i in tape.slots if tape.ops[i] in TASKS]


def bind_files(roots: Sequence[Node], bindings: Bindings, places: Places) -> Bindings:
    """The bindings with the data of every file that the roots read, directly or through tasks."""
    read = {n: slot_value(find(n, bindings, places)) for n in order(roots) if n.op in OUTSIDE and n not in bindings}
    return {**bindings, **read} if read else bindings


def bind_tasks(roots: Sequence[Node], bindings: Bindings, places: Places) -> Bindings:
    """The bindings with what every task that the roots read has found."""
    found = {n: slot_value(find(n, bindings, places)) for n in tasks_read(roots) if n not in bindings}
    return {**bindings, **found} if found else bindings


def slot_value(found: Result) -> float | Data:
    """What a slot is bound to, of what its task has found."""
    return found.value if isinstance(found, Reduced) else found


def find(n: Node, bindings: Bindings, places: Places) -> Result:
    """What a task finds with these bindings: remembered, or computed now. An error is never kept.

    Files are read first, so that the name of a result and the result are of the same data. What else is bound to tasks
    is left out: a number that somebody moves, to see what its error changes, is moved for him alone. Threads that want
    the same at the same time wait for the one that computes it.
    Errors: those of the task, at the place in the program that asks for it.
    """
    try:
        if n.op in OUTSIDE:
            return cast(Data, bindings[n]) if n in bindings else OUTSIDE[n.op](n)
        bindings = {m: v for m, v in bindings.items() if m.op not in TASKS or m.op in OUTSIDE}
        bindings = bind_files([n], bindings, places)
        key = identity(n, bindings, lambda m: cast(Data, bindings[m]).digest if m.op in OUTSIDE else "")
        with _alone(key):
            found = store.get(key)
            if found is None:
                with activity(TASK_TABLE[n.op].activity):
                    found = _computed(n, bindings, places)
                trial = any(m.op == "unknown" for m in bindings)  # a guess of a `solve`, whose answer is kept
                store.put(key, found, label=_label(n, places), disk=not trial)
        return found
    except PoreError as error:
        place = places.get(n)
        raise PoreError([replace(d, span=d.span or place) for d in error.diagnostics]) from None


_flights: dict[str, tuple[threading.RLock, int]] = {}
_flights_lock = threading.Lock()


@contextmanager
def _alone(key: str) -> Iterator[None]:
    """While this lasts no other thread is in it with the same key."""
    with _flights_lock:
        lock, waiting = _flights.get(key, (threading.RLock(), 0))
        _flights[key] = (lock, waiting + 1)
    try:
        while not lock.acquire(timeout=_POLL):
            checkpoint()
        try:
            yield
        finally:
            lock.release()
    finally:
        with _flights_lock:
            lock, waiting = _flights[key]
            if waiting == 1:
                del _flights[key]
            else:
                _flights[key] = (lock, waiting - 1)


def _label(n: Node, places: Places) -> str:
    place = places.get(n)
    return " ".join(place.text.split()) if place is not None else n.op


def _computed(n: Node, bindings: Bindings, places: Places) -> Result:
    """A task with those that it reads found first; what their errors may change is added to its own."""
    if n.op == "solve":
        return _solved(n, bindings, places)
    return _with_errors(n.args, bindings, places, lambda filled: RUN[n.op](Formula(n.args, filled)))


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
    for source in _sources(roots):
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


def _sources(roots: Sequence[Node]) -> list[Node]:
    """The numbers that roots read, directly or through data."""
    out: dict[Node, None] = {}
    for m in tasks_read(roots):
        if TASK_TABLE[m.op].result == "real":
            out[m] = None
        else:
            out.update(dict.fromkeys(_sources(m.args)) if m.args else {})
    return list(out)


def _moved(roots: Sequence[Node], bindings: Bindings, places: Places, source: Node) -> Bindings:
    """The bindings of all that roots read where `source` is already bound to another value than it has."""
    values: dict[Node, Slot] = {}
    for m in tasks_read(roots):
        if m is source:
            continue
        if TASK_TABLE[m.op].result != "real" and m.args and source in _sources(m.args):
            values[m] = slot_value(RUN[m.op](Formula(m.args, _moved(m.args, bindings, places, source))))
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
