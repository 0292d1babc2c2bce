"""Tasks found when a root reads them, those they read themselves first, and nothing that no root reads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from porelang import store
from porelang.data import Data, Reduced
from porelang.diagnostics import PoreError
from porelang.formula import Bindings, Formula
from porelang.ir import TASKS, Node, unknown
from porelang.ops.tasks import TASKS as TABLE
from porelang.progress import activity
from porelang.source import Span
from porelang.store import Result
from porelang.tape import lower
from porelang.tasks.identity import identity
from porelang.tasks.numbers.roots import root_of
from porelang.tasks.run import OUTSIDE, RUN

#: Where each task is asked for, so that what goes wrong is told there.
Places = Mapping[Node, Span]


def read(roots: Sequence[Node]) -> list[Node]:
    """The tasks that roots read, but not those that these tasks read in turn."""
    tape = lower(tuple(roots))
    return [tape.nodes[i] for i in tape.slots if tape.ops[i] in TASKS]


def bound(roots: Sequence[Node], bindings: Bindings, places: Places) -> Bindings:
    """The bindings with what every task that the roots read has found."""
    found = {n: value(result(n, bindings, places)) for n in read(roots) if n not in bindings}
    return {**bindings, **found} if found else bindings


def value(found: Result) -> float | Data:
    """What a slot is bound to, of what its task has found."""
    return found.value if isinstance(found, Reduced) else found


def result(n: Node, bindings: Bindings, places: Places) -> Result:
    """What a task finds with these bindings: remembered, or computed now. An error is never kept.

    Errors: those of the task, at the place in the program that asks for it.
    """
    try:
        if n.op in OUTSIDE:
            return OUTSIDE[n.op](n)
        key = identity(n, bindings, lambda m: _content(m, places))
        trial = any(m.op == "unknown" for m in bindings)  # one of many guesses of a `solve`, whose answer is kept
        found = store.get(key)
        if found is None:
            with activity(TABLE[n.op].activity):
                found = _computed(n, bindings, places)
            store.put(key, found, label=_label(n, places), disk=not trial)
        return found
    except PoreError as error:
        place = places.get(n)
        raise PoreError([replace(d, span=d.span or place) for d in error.diagnostics]) from None


def _content(n: Node, places: Places) -> str:
    """The digest of what a task reads from outside the program."""
    if n.op not in OUTSIDE:
        return ""
    found = result(n, {}, places)
    assert not isinstance(found, Reduced)
    return found.digest


def _label(n: Node, places: Places) -> str:
    place = places.get(n)
    return " ".join(place.text.split()) if place is not None else n.op


def _computed(n: Node, bindings: Bindings, places: Places) -> Result:
    """A task with those that it reads found first; what their errors may change is added to its own."""
    if n.op == "solve":
        return _solved(n, bindings, places)
    below = {m: result(m, bindings, places) for m in read(n.args)}
    return _spread(lambda values: RUN[n.op](Formula(n.args, {**bindings, **values})), below)


def _spread(compute: object, below: Mapping[Node, Result]) -> Result:
    """What is computed from what was found, with the errors of those numbers added to its own."""
    assert callable(compute)
    values = {m: value(r) for m, r in below.items()}
    out: Result = compute(values)
    if not isinstance(out, Reduced):
        return out
    error = out.error
    for m, known in below.items():
        if isinstance(known, Reduced) and known.error:
            moved = [compute({**values, m: known.value + side * known.error}).value for side in (-1, 1)]
            error += max(abs(v - out.value) for v in moved)
    return Reduced(out.value, error)


def _solved(n: Node, bindings: Bindings, places: Places) -> Reduced:
    """The number for which a function, any formula of numbers, takes a value."""
    assert isinstance(n.value, int)
    inner, *ends = n.args
    sought = unknown(n.value)

    def function(t: float) -> Reduced:
        tried = {**bindings, sought: t}
        below = {m: result(m, tried, places) for m in read([inner])}
        found = _spread(lambda values: Reduced(float(Formula((inner,), {**tried, **values}).numbers[0]), 0.0), below)
        assert isinstance(found, Reduced)
        return found

    def solution(values: Bindings) -> Reduced:
        target, low, high = (float(v) for v in Formula(tuple(ends), {**bindings, **values}).numbers)
        return root_of(function, target, low, high)

    found = _spread(solution, {m: result(m, bindings, places) for m in read(ends)})
    assert isinstance(found, Reduced)
    return found
