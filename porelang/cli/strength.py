"""`pore fea`: a study of the program in elements, to a file, with a report."""

from __future__ import annotations

import time
from argparse import Namespace

from porelang.atomic import destination
from porelang.checks import broken_checks
from porelang.cli import report
from porelang.cli.loading import bound
from porelang.diagnostics import PoreError, fail, to_lists
from porelang.strength import carry_out


def fea(options: Namespace) -> int:
    """Solve a study, write it and print a report. What can be refused is refused before anything is computed."""
    if options.output:
        if not options.output.lower().endswith(".vtu"):
            raise fail(
                "E112", f"{options.output}: results of a study are written as .vtu", hint="end the name with .vtu"
            )
        destination(options.output)
    design = bound(options)
    if options.output:
        destination(options.output, design.program.files)
    if broken := broken_checks(design):
        raise PoreError(broken)
    start = time.perf_counter()
    found = carry_out(design, options.study, options.refine, options.within, options.out)
    if options.output:
        found.write(options.output)
    seconds = round(time.perf_counter() - start, 3)
    report.say([] if options.quiet else found.told)
    if options.json:
        written = {"file": options.output} if options.output else {}
        report.put(written | found.report | {"seconds": seconds} | to_lists(list(found.told)))
    elif not (options.quiet and options.output):  # without a file the report is the result
        name = options.output or design.program.source.name
        print("\n".join([name, *found.lines({"time": f"{seconds:.2f} s"})]))
    return 0
