"""What tasks tell of what they found: what it is, in a line, and what is doubtful about it.

It is made from what is kept with the result (the facts of samples, whether an answer is the only one), so that one
that was found yesterday tells the same.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from porelang.data import Reduced, SampledField
from porelang.diagnostics import Diagnostic
from porelang.ir import Node
from porelang.source import Span
from porelang.store import Result
from porelang.tasks.shape.found import told_of
from porelang.tasks.told import Doubt, Told


def _solve(found: Result) -> Told:
    assert isinstance(found, Reduced)
    if found.sole:
        return Told()
    said = f"this function rises and falls: {found.value:.6g} is one answer, and there may be others"
    hint = "narrow the range to where it rises or falls throughout"
    return Told(doubts=(Doubt("W206", said, "looked at in some places only", hint),))


def _mesh(found: Result) -> Told:
    assert isinstance(found, SampledField)
    return told_of(found) if found.facts else Told()


#: By the name of the task; what is not here has nothing to tell.
TELL: Mapping[str, Callable[[Result], Told]] = {"solve": _solve, "mesh": _mesh}


def told(n: Node, found: Result, place: Span | None) -> list[Diagnostic]:
    """What a task tells of what it found, as diagnostics at the place that asks for it: a note, and warnings."""
    if n.op not in TELL:
        return []
    of = TELL[n.op](found)
    notes = [Diagnostic("", f"{n.op}: {of.note}", place, severity="note")] if of.note else []
    return notes + [Diagnostic(d.code, d.message, place, d.label, hint=d.hint, severity="warning") for d in of.doubts]
