"""`pore optimize`: the loop of a program, into a folder, with its history."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from porelang.checks import broken_checks
from porelang.cli import report
from porelang.cli.loading import bound
from porelang.diagnostics import PoreError, to_lists
from porelang.optimize.record import Step


def optimize(options: Namespace) -> int:
    """Iterate, and print the history."""
    from porelang.optimize.run import PICTURE, TABLE
    from porelang.optimize.run import optimize as run

    design = bound(options)
    if broken := broken_checks(design):
        raise PoreError(broken)
    folder = Path(
        options.output or ("part.loop" if options.file == "-" else Path(options.file).with_suffix(".loop").name)
    )
    found = run(
        design, options.iterate, options.until, options.most, options.rule, options.limits, options.porosity,
        options.adapt, options.study, options.within, options.cell, options.damping, folder, options.resume,
        options.early, None if options.quiet else _tell,
    )  # fmt: skip
    report.say([] if options.quiet else found.told)
    if options.json:
        report.put({"folder": str(folder), **found.report, **to_lists(found.told)})
    elif not options.quiet:
        print(found.table)
        if found.promise:
            print(found.promise)
        print(f"ended: {found.reason}; step {found.best} has {found.gain:.3f} of the uniform compliance")
        print(f"{folder}: {found.param}.npz, {TABLE}, {PICTURE}, and the record")
        name = f"{found.param}={folder / found.param}.npz:{found.param}"
        print(f"the part: pore mesh {options.file} --out {found.output} --bind {name} -o {found.output}.stl")
    return 0


def _tell(step: Step) -> None:
    """A line to standard error for each step, as it is found."""
    change = "" if step.change is None else f", {100 * step.change:+.2f} %"
    report.note(f"step {step.number}: {step.compliance:.5g} N mm{change}")
