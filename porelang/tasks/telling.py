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
from porelang.tasks.readers.got import Got
from porelang.tasks.shape.found import told_of
from porelang.tasks.study.doubts import told as told_of_study
from porelang.tasks.told import Doubt, Told


def _solve(n: Node, found: Result) -> Told:
    assert isinstance(found, Reduced)
    if found.sole:
        return Told()
    said = f"this function rises and falls: {found.value:.6g} is one answer, and there may be others"
    hint = "narrow the range to where it rises or falls throughout"
    return Told(doubts=(Doubt("W206", said, "looked at in some places only", hint),))


def _phase(n: Node, found: Result) -> Told:
    from porelang.tasks.phase.got import told

    assert isinstance(found, SampledField)
    note, doubt, hint = told(found.facts)
    return Told(note, (Doubt("W229", doubt, "what was got is not what was asked for", hint),) if doubt else ())


def _load(n: Node, found: Result) -> Told:
    assert isinstance(found, SampledField)
    assert isinstance(n.value, tuple)
    _, _, _, components, *more = n.value
    got, doubts = Got.of(found), []
    finer = f"take finer ones, `voxel={got.voxel / 2:.2g}mm`"
    if len(more) > 1 and more[1] and got.holed:
        said = f"samples every {got.voxel:.3g} mm are too coarse for walls so thin: `outside` holds in the middles of "
        doubts.append(Doubt("W230", f"{said}{got.lost:.0%} of the tetrahedra into which cells are cut", hint=finer))
    if got.coarse:
        said = f"samples every {got.voxel:.3g} mm are too coarse for this field: a lookup in twenty is off by "
        hint = f"{finer}, or see whether the file has values at single points"
        if got.corners:
            said = "points between the corners of cells are not read, of such as these: a lookup in twenty is off by "
            hint = (
                "export them as tetrahedra (in ParaView: the filter Tessellate), or as cells of VTK's quadratic kinds"
            )
        doubts.append(Doubt("W230", f"{said}{got.error:.3g} or more, {got.share:.0%} of its range", hint=hint))
    return Told(got.told(found, int(components)), tuple(doubts))


def _mesh(n: Node, found: Result) -> Told:
    assert isinstance(found, SampledField)
    return told_of(found) if found.facts else Told()


def _study(n: Node, found: Result) -> Told:
    assert isinstance(found, SampledField)
    return told_of_study(found)


def _truss(n: Node, found: Result) -> Told:
    return Told()  # that it could be laid out is all: what is wrong with sizes is said when it is asked


#: By the name of the task; what is not here has nothing to tell.
TELL: Mapping[str, Callable[[Node, Result], Told]] = {
    "solve": _solve,
    "load": _load,
    "mesh": _mesh,
    "phase": _phase,
    "study": _study,
    "truss": _truss,
}


def told(n: Node, found: Result, place: Span | None) -> list[Diagnostic]:
    """What a task tells of what it found, as diagnostics at the place that asks for it: a note, and warnings."""
    if n.op not in TELL:
        return []
    of = TELL[n.op](n, found)
    notes = [Diagnostic("", f"{n.op}: {of.note}", place, severity="note")] if of.note else []
    return notes + [Diagnostic(d.code, d.message, place, d.label, hint=d.hint, severity="warning") for d in of.doubts]
