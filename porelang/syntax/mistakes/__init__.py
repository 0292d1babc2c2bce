"""What to say of a statement that cannot be parsed: what was found, what would fit, and the edit that mends it."""

from __future__ import annotations

from collections.abc import Callable

from porelang.diagnostics import Diagnostic
from porelang.syntax.failure import Failure, describe
from porelang.syntax.mistakes import expressions, openscad, statements

#: Rules, each for one kind of mistake; the first that knows an answer gives it.
RULES: tuple[Callable[[Failure], Diagnostic | None], ...] = (
    openscad.before_its_solid,
    openscad.module,
    statements.mesh,
    statements.other_word,
    statements.use,
    statements.preset,
    statements.name_missing,
    statements.equal_missing,
    statements.assignment,
    statements.kind_and_range,
    expressions.comparison,
    statements.check,
    statements.parameters,
    expressions.within,
    expressions.value_missing,
    expressions.comprehension,
    expressions.condition_last,
    expressions.conditional,
    statements.param_range,
    expressions.misplaced,
    expressions.two_values,
)


def explain(failure: Failure) -> Diagnostic:
    """The diagnostic of a statement that cannot be parsed."""
    for rule in RULES:
        diagnostic = rule(failure)
        if diagnostic is not None:
            return diagnostic
    return failure.error(
        "E029", f"{describe(failure.found)} does not fit here", hint=f"it stands after {describe(failure.before)}"
    )
