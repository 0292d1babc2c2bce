"""The `check` statements of a design, and its contracts on fields: what does not hold, with what shows it."""

from __future__ import annotations

from porelang.contracts import doubtful_contracts
from porelang.data import Reduced, coordinates, figures
from porelang.diagnostics import Diagnostic
from porelang.formula import Formula
from porelang.ir import NUMBERS, TASKS, UNKNOWN, Node, order, within
from porelang.ops import TASK_TABLE
from porelang.program import Design, Program
from porelang.rewrites import flatten


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
    """The `check` statements that do not hold for any value that their numbers may have, by their index; those about
    whole fields only if `measure`."""
    return [
        i
        for i, root in enumerate(design.program.graph.checks)
        if (measure or not _slow(root)) and design.decided(root) is False
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
        label = ", ".join(_numbers_of(design, i)) or "does not hold"
        with_these = ", ".join(f"{name} = {program.params[name].shown(design.settings[name])}" for name in params)
        label += f" with {with_these}" if params else ""
        found.append(Diagnostic("E068", check.message, check.span, label, check.others))
    return found


def undecided_checks(design: Design, measure: bool = True) -> list[Diagnostic]:
    """A warning for each `check` that the errors of its numbers leave open: it may hold or not.

    Those about whole fields are looked at only if `measure`.
    """
    program, found = design.program, []
    for i, root in enumerate(program.graph.checks):
        if (not measure and _slow(root)) or design.decided(root) is not None:
            continue
        check = program.elaborated.checks[i]
        label = ", ".join(_numbers_of(design, i, least=0.0))
        hint = "leave a margin larger than the error"
        holds = (
            "holds for what was found, but might not"
            if design.holds(root)
            else "does not hold for what was found, but might"
        )
        said = f"not certain: this check {holds} within the error: {check.message}"
        found.append(Diagnostic("W203", said, check.span, label, check.others, hint, severity="warning"))
    return found


def _numbers_of(design: Design, i: int, least: float = 5e-5) -> list[str]:
    """What the sides of a check's comparisons are, and the numbers found from fields in them, each with its error if
    that is more than `least` of it."""
    program = design.program
    out = [f"`{text}` is {_with_error(found, least)}" for text, found in _sides(design, i)]
    numbers = design.own_numbers(program.graph.checks[i])
    found = {n: f"{_with_error(r, least)} {program.units.get(n, '')}".rstrip() + _place(design, n)
             for n, r in numbers.items()}  # fmt: skip
    return out + sorted(f"{program.numbers[n]} is {text}" for n, text in found.items())


def _place(design: Design, n: Node) -> str:
    """Where a wall is that a number tells the thickness of."""
    if n.op != "min_wall":
        return ""
    from porelang.tasks.numbers.thickness import thinnest_wall

    return f" at ({coordinates(thinnest_wall(design.formula(n.args[0])).at, 3)}) mm"


def _sides(design: Design, i: int) -> list[tuple[str, Reduced]]:
    """The sides of a check's comparisons that are made of numbers found from fields, each as it is written."""
    elaborated, out = design.program.elaborated, dict[str, Reduced]()
    todo = [elaborated.checks[i].condition]
    while todo:
        n = todo.pop()
        chain = elaborated.conditions.get(n)
        compared = n.args[0] if n.op == "not" and n.args[0].op == "eq" else n
        if chain is None or compared.op not in ("lt", "le", "eq"):
            todo += reversed(n.args if n.op in ("and", "or", "not") else ())
            continue
        spans = (chain.first.span, chain.rest[0][1].span)
        for span, side in zip(spans[::-1] if chain.rest[0][0].startswith(">") else spans, compared.args, strict=True):
            (flat,) = flatten(side)
            if flat.op not in NUMBERS and design.own_numbers(flat):
                out[" ".join(span.text.split())] = design.valued(flat)
    return list(out.items())


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


def _with_error(found: Reduced, least: float) -> str:
    """A number found from fields, with its error where that is more than `least` of it."""
    return figures(found.value, found.error) if found.error > least * abs(found.value) else f"{found.value:.4g}"
