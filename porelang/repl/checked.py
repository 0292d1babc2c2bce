"""What becomes of a check as soon as it is written."""

from __future__ import annotations

from porelang.checks import broken_checks, undecided_checks
from porelang.diagnostics import Diagnostic
from porelang.repl.state import NAME, State
from porelang.repl.typed import as_typed, pieces


def new_checks(before: State, after: State) -> list[str]:
    """The checks that were written since, by the names of their statements."""
    return [k for k, v in after.statements.items() if k.startswith("check ") and before.statements.get(k) != v]


def checked(state: State, names: list[str]) -> list[Diagnostic]:
    """An error for each of some checks that does not hold, a warning where errors of numbers leave it open, a note
    where it does. Errors: those of what they read."""
    if not names or state.program is None:
        return []
    found = [*broken_checks(state.design, measure=True), *undecided_checks(state.design)]
    out = []
    for name, (begins, text) in zip(state.statements, pieces(list(state.statements.values())), strict=True):
        if name in names:
            here = [d for d in found if d.span is not None and begins <= d.span.in_file.start < begins + len(text)]
            out += [as_typed(d, [(begins, text)], NAME) for d in here] or [_holds(text)]
    return out


def _holds(text: str) -> Diagnostic:
    return Diagnostic("", f"it holds: {text}", severity="note")
