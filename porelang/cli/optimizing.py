"""`pore optimize`: the loop of a program, into a folder, with its history."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from porelang.checks import broken_checks
from porelang.cli import report
from porelang.cli.loading import bound
from porelang.diagnostics import PoreError, to_lists
from porelang.optimize.record import Step
from porelang.tasks.study.sized import Sized, duration, many

#: Seconds from which on it is said how long all takes.
A_WHILE = 5.0


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
    steps: list[Step] = []

    def seen(step: Step) -> None:
        steps.append(step)
        if not options.quiet:
            _tell(step)

    try:
        found = run(
            design, options.iterate, options.until, options.most, options.rule, options.limits, options.porosity,
            options.adapt, options.study, options.within, options.cell, options.damping, folder, options.resume,
            options.early, seen, options.force, None if options.quiet else _begun,
        )  # fmt: skip
    except KeyboardInterrupt:
        if steps and not options.quiet:
            report.note(f"\nstopped after step {steps[-1].number}: {folder} has the best so far; --resume goes on")
        raise
    report.say(found.failed if options.quiet else [*found.failed, *found.told])
    if options.json:
        report.put({"folder": str(folder), **found.report, **to_lists([*options.doubts, *found.told])})
    else:
        print(found.table)
        if found.promise:
            print(found.promise)
        print(found.ended)
        print(f"{folder}: {found.param}.npz, {TABLE}, {PICTURE}, and the record")
        name = f"{found.param}={folder / found.param}.npz:{found.param}"
        print(f"the part: pore mesh {options.file} --out {found.output} --bind {name} -o {found.output}.stl")
    return report.status(found.failed)


def _begun(found: Sized, solves: int) -> None:
    """Say what is to be solved, how often, and about how long that takes, where it takes a while."""
    seconds = found.seconds * solves
    if seconds < A_WHILE:
        return
    often = f"{solves} times at most" if solves > 1 else "once"
    rims = f", up to {found.rims:g} times that with smaller elements at rims" if found.rims else ""
    report.note(f"some {many(found.elements)} elements of {found.size:.3g} mm, {many(found.unknowns)} unknowns, to be "
                f"solved {often}: about {duration(seconds)}{rims} (Ctrl-C ends it; --resume goes on)")  # fmt: skip


def _tell(step: Step) -> None:
    """A line to standard error for each step, as it is found."""
    change = "" if step.change is None else f", {100 * step.change:+.2f} %"
    work = " of work" if step.under == "displacements" else ""
    report.note(f"step {step.number}: {step.compliance:.5g} N mm{work}{change}")
