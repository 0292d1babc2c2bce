"""The `check` statements of a design, and its contracts on fields: what does not hold, with what shows it."""

from __future__ import annotations

from porelang.analysis.enclose import enclose
from porelang.contracts import doubtful_contracts
from porelang.data import Reduced
from porelang.diagnostics import Diagnostic
from porelang.formula import Formula
from porelang.interval import interval
from porelang.ir import NUMBERS, TASKS, UNKNOWN, Node, order, within
from porelang.ops import TASK_TABLE
from porelang.program import Design, Program


def _slow(root: Node) -> bool:
    """Whether a root reads, directly or not, what takes seconds to find."""
    return any(TASK_TABLE[n.op].cost != "instant" for n in order([root]) if n.op in TASKS)


def unmeasured_checks(program: Program) -> int:
    """How many `check` statements are about whole fields, and so are only decided by measuring."""
    return sum(map(_slow, program.graph.checks))


def read_by(program: Program) -> list[Node]:
    """The roots that a program is read for: its outputs and checks, and not what a text asks for that nothing reads."""
    return [*(root for roots in program.graph.outputs.values() for root in roots), *program.graph.checks]


def find_searches(design: Design) -> None:
    """Find what each `solve` looks for in a program that asks for nothing slower: formulas take no time, and what is
    wrong with one is said at once. Errors: theirs."""
    asked = [n for n in order(design.program.graph.roots) if n.op in TASKS]
    if any(n.op == "solve" for n in asked) and not any(n.op != "solve" and _slow(n) for n in asked):
        for n in design.reads(*read_by(design.program)):
            if n.op == "solve" and n.depends < UNKNOWN:
                design.number(n)


def failed_checks(design: Design, measure: bool = True) -> list[int]:
    """The `check` statements that do not hold, by their index; those about whole fields only if `measure`."""
    return [
        i
        for i, root in enumerate(design.program.graph.checks)
        if (measure or not _slow(root)) and not design.holds(root)
    ]


def broken_checks(design: Design, measure: bool = False) -> list[Diagnostic]:
    """An error for each `check` that does not hold, with the numbers that it found.

    Checks about whole fields (a porosity) are looked at only if `measure` says so: they take a second or more.
    Errors: E064 where a contract about what a check reads is broken.
    """
    program, found = design.program, []
    for i in failed_checks(design, measure):
        check, root = program.elaborated.checks[i], program.graph.checks[i]
        params = sorted({str(n.value) for n in order([root], within) if n.op == "param"})
        numbers = _own(design, root)
        label = ", ".join(sorted(_told(program.numbers[n], design.number(n)) for n in numbers)) or "does not hold"
        with_these = ", ".join(f"{name} = {program.params[name].shown(design.settings[name])}" for name in params)
        label += f" with {with_these}" if params else ""
        found.append(Diagnostic("E068", check.message, check.span, label, check.others))
    return found


def undecided_checks(design: Design) -> list[Diagnostic]:
    """A warning for each `check` that holds, but would not for other numbers within the errors of those it found."""
    program, found = design.program, []
    failed = set(failed_checks(design))
    for i, root in enumerate(program.graph.checks):
        numbers = {n: design.number(n) for n in _own(design, root)}
        if not numbers or i in failed:
            continue
        ranges = {n: interval(r.value - r.error, r.value + r.error) for n, r in numbers.items()}
        if bool((enclose(design.formula(root).bind(ranges))[0].range.lo < 1).any()):
            check = program.elaborated.checks[i]
            label = ", ".join(
                sorted(f"{program.numbers[n]} is {r.value:.6g} +- {r.error:.1g}" for n, r in numbers.items())
            )
            hint = "leave a margin larger than the error"
            said = f"this check holds, but within the error of its numbers it might not: {check.message}"
            found.append(Diagnostic("W203", said, check.span, label, check.others, hint, severity="warning"))
    return found


def doubtful_numbers(design: Design, *roots: Node) -> list[Diagnostic]:
    """A warning for each number, of those that roots read, beside which there may be another."""
    found: list[Diagnostic] = []
    for n in design.reads(*roots):
        if n.op == "solve" and n.depends < UNKNOWN and not (number := design.number(n)).sole:
            said = f"this function rises and falls: {number.value:.6g} is one answer, and there may be others"
            hint = "narrow the range to where it rises or falls throughout"
            place = design.program.places.get(n)
            found.append(
                Diagnostic("W206", said, place, "looked at in some places only", hint=hint, severity="warning")
            )
    return found


def late_doubts(design: Design) -> list[Diagnostic]:
    """Warnings about contracts on fields that need what tasks find; all others are among the program's warnings."""
    program = design.program
    # one about what a `solve` looks for is not about what is there
    late = [
        (which, n)
        for which, n in program.graph.contracts
        if n.depends < UNKNOWN and any(m.op in TASKS for m in order([n]))
    ]
    solids = [root for roots in program.graph.outputs.values() for root in roots]
    read = set(design.reads(*solids))
    late = [(which, n) for which, n in late if all(m in read for m in order([n]) if m.op in TASKS)]
    if not late:
        return []
    formula: Formula = design.formula(*(n for _, n in late))
    return doubtful_contracts(late, program.elaborated.contracts, solids, formula.bindings)


def _own(design: Design, root: Node) -> list[Node]:
    """The numbers that stand in a check itself, of the branches that are taken."""
    read = set(design.reads(root))
    return [n for n in order([root], within) if n in read and n.op in NUMBERS]


def _told(text: str, found: Reduced) -> str:
    """A number found from fields, with its error where that shows in four figures."""
    error = f" +- {found.error:.1g}" if found.error > 5e-5 * abs(found.value) else ""
    return f"{text} is {found.value:.4g}{error}"
