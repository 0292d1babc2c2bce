"""`pore check`: everything that is wrong or doubtful in a program."""

from __future__ import annotations

from argparse import Namespace

from porelang.checks import (
    broken_checks,
    find_searches,
    late_doubts,
    read_by,
    undecided_checks,
    unmeasured_checks,
)
from porelang.cli import report
from porelang.cli.loading import data_of, source_of
from porelang.compiler import try_compile
from porelang.diagnostics import MOST_DIAGNOSTICS, PoreError
from porelang.doubts import idle_cuts
from porelang.program import Design
from porelang.refusals import endless, refusals, structural_faults
from porelang.settings import off_step
from porelang.syntax.parse import MOST


def check(options: Namespace) -> int:
    """`pore check`: all diagnostics, the `check` statements included."""
    source = source_of(options)
    program, found = try_compile(source, bound=data_of(options))
    design: Design | None = None
    report.say([d for d in found if d.severity == "error" or not options.quiet])
    if program is not None:  # what was found so far is said first: a check may have to measure the whole part
        try:
            design = program.design(dict(options.settings), preset=options.preset)
            design.read_data(options.measure)
            find_searches(design)
            if options.measure:
                design.keep_contracts()
            broken = off_step(program.params, design.settings)
            broken += structural_faults(program, options.measure)
            broken += refusals(design, options.measure)
            broken += [*broken_checks(design, options.measure), *undecided_checks(design, options.measure)]
            if options.measure:
                broken += late_doubts(design)
                broken += idle_cuts(program.elaborated, design.settings)
            broken += design.told(*read_by(program), measure=options.measure)
        except PoreError as error:
            broken = list(error.diagnostics)
        report.say([d for d in broken if d.severity == "error" or not options.quiet])
        found = [*found, *broken]
    if options.json:
        report.put([d.to_json() for d in found])
    if program is not None and not options.measure:
        waiting = unmeasured_checks(program)
        if waiting and not options.quiet:
            them = "it" if waiting == 1 else "them"
            report.note(f"{report.plural(waiting, 'check')} about whole fields left out: --measure looks at {them}")
    doubts = [d for d in found if d.severity != "note"]
    if design is not None and not options.quiet and not doubts:
        try:
            axes = endless(design)
        except PoreError:
            axes = ""
        if axes:
            report.note(f"a field without an end along {axes}: drawing and meshing it takes --bounds")
    if not options.quiet:
        errors = sum(d.severity == "error" for d in doubts)
        warnings = report.plural(len(doubts) - errors, "warning")
        first = "the first " if len(doubts) in (MOST, MOST_DIAGNOSTICS) else ""
        report.note(f"{source.name}: {first}{report.plural(errors, 'error')}, {warnings}")
    return report.status(found)
