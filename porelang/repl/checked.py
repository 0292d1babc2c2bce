"""What becomes of a check as soon as it is written."""

from __future__ import annotations

from porelang.checks import broken_checks, undecided_checks
from porelang.diagnostics import Diagnostic
from porelang.repl.state import State
from porelang.repl.typed import as_typed, pieces


def checked(state: State, names: list[str]) -> list[Diagnostic]:
    """An error for each of some checks that does not hold, a warning where errors of numbers leave it open, a note
    where it does. Errors: those of what they read."""
    if not names or state.program is None:
        return []
    found = [*broken_checks(state.design, measure=True), *undecided_checks(state.design)]
    out = []
    for name, piece in zip(state.statements, pieces(state.statements.values()), strict=True):
        if name in names:
            ends = piece.begins + len(piece.text)
            here = [d for d in found if d.span is not None and piece.begins <= d.span.in_file.start < ends]
            out += [as_typed(d, [piece], state.name) for d in here] or [_holds(piece.text.strip())]
    return out


def refused(state: State, measure: bool = True) -> list[Diagnostic]:
    """Errors for the checks that do not hold; those about whole fields only if `measure`."""
    if state.program is None:
        return []
    typed = pieces(state.statements.values())
    return [as_typed(d, typed, state.name) for d in broken_checks(state.design, measure)]


def fallen(before: State, after: State) -> list[Diagnostic]:
    """Errors for the checks that held before and do not any more, of those that take no time."""
    if (before.statements, before.settings) == (after.statements, after.settings):
        return []
    known = {d.message for d in refused(before, False)}
    return [d for d in refused(after, False) if d.message not in known]


def _holds(text: str) -> Diagnostic:
    return Diagnostic("", f"it holds: {text}", severity="note")
