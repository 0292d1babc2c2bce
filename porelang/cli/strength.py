"""`pore fea`: a study of the program in elements, to a file, with a report."""

from __future__ import annotations

import time
from argparse import Namespace
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from porelang.atomic import destination
from porelang.checks import broken_checks
from porelang.cli import report
from porelang.cli.loading import bound
from porelang.data import Reduced, coordinates, figures
from porelang.diagnostics import PoreError, fail, to_lists
from porelang.fea import Resultant
from porelang.strength import Strength, carry_out
from porelang.tasks.study.missed import Missed
from porelang.tasks.study.sized import Sized, duration, many

_UNITS = {
    "compliance": "N mm",
    "max_von_mises": "MPa",
    "von_mises_99": "MPa",
    "max_displacement": "mm",
    "mean_displacement": "mm",
    "volume": "mm3",
    "mass": "g",
}

#: Seconds from which on it is said how long a study takes.
_A_WHILE = 5.0
#: What would not be understood by its name in the language.
_CALLED = {"max_von_mises": "max von Mises", "von_mises_99": "von Mises, 99 %"}
#: A moment that is less than this of forces times the distances between them is none; a number, beside the largest.
_TURNS, _NOTHING = 1e-4, 1e-7


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
    begun = None if options.quiet else _begun
    found = carry_out(design, options.study, options.refine, options.within, options.out, begun)
    if options.output:
        found.write(options.output)
    seconds = round(time.perf_counter() - start, 3)
    report.say([] if options.quiet else found.told)
    if options.json:
        written = {"file": options.output} if options.output else {}
        report.put(written | found.report | {"seconds": seconds} | to_lists([*options.doubts, *found.told]))
    elif not (options.quiet and options.output):  # without a file the report is the result
        print(_text(options.output or design.program.source.name, found, seconds))
    return 0


def _begun(found: Sized) -> None:
    """Say what is to be solved and about how long that takes, where it takes a while."""
    if found.seconds < _A_WHILE:
        return
    rims = f", up to {found.rims:g} times that with smaller ones at rims" if found.rims else ""
    report.note(f"some {many(found.elements)} elements of {found.size:.3g} mm, {many(found.unknowns)} unknowns: about "
                f"{duration(found.seconds)}{rims} (Ctrl-C ends it)")  # fmt: skip


def _text(path: str, found: Strength, seconds: float) -> str:
    solved = found.solved
    turns = solved.asked.whole is not None and solved.asked.whole.name == "twist_load"
    fine = solved.sized
    halved = f", {report.halved(fine.halved, fine.least)}" if fine.halved else ""
    lines = {
        "study": found.name,
        "elements": f"{len(solved.mesh.tets):,} of {solved.sized.span} mm{halved}, {solved.unknowns:,} unknowns",
        "solver": f"{solved.iterations} iterations to a residual of {solved.residual:.1g}",
    }
    for name, number in found.numbers.items():
        if name in found.report and name != "error":
            unit = _UNITS.get(name, "N mm/rad" if turns else "N/mm")
            lines[_CALLED.get(name, name.replace("_", " "))] = f"{_shown(number)} {unit}"
    if found.effective_modulus is not None:
        lines["modulus"] = f"{_shown(found.effective_modulus)} MPa, of {found.envelope}"
    acting = [*solved.loads, *solved.supports]
    lines |= {of.name: _acting(of, acting, of.area > 0) for of in solved.loads}
    lines |= {of.name: _acting(of, acting, True) for of in solved.supports}
    if solved.sized.wall is not None:
        lines["thinnest walls"] = f"{solved.sized.wall.wall:.3g} mm, as at ({coordinates(solved.sized.wall.at)})"
    lines["elements miss"] = _missed(solved.missed)
    lines["stresses err"] = f"{found.numbers['error'].value:.2%} in energy (Zienkiewicz and Zhu)"
    lines["time"] = f"{seconds:.2f} s"
    return "\n".join([path, *(f"  {name:<18} {value}" for name, value in lines.items())])


def _missed(found: Missed) -> str:
    """What elements lack of the part, and hold beyond it."""
    said = f"{found.lacking:.3g} mm3 of the part, and hold {found.beyond:.3g} mm3 beyond it"
    if found.handles:
        holes = "1 hole" if found.handles == 1 else f"{found.handles} holes"
        said += f"; they have {holes} " + (f"more or fewer than its {found.of}" if found.of else "more")
    return said


def _acting(of: Resultant, among: Sequence[Resultant], on_surface: bool) -> str:
    """The force of a load or a support, on which area if on one; and the moment about its middle, if it turns the
    part."""
    arm = max(float(np.ptp([r.centre for r in among], axis=0).max()), of.area**0.5)
    most = max(max(float(np.abs(r.force).max()), float(np.abs(r.couple).max()) / arm) for r in among)
    said = f"{_vector(of.force, most)} N"
    if np.abs(of.couple).max() > _TURNS * most * arm:
        said += f" and {_vector(of.couple, most * arm)} N mm"
    return said + (f" on {of.area:.5g} mm2" if on_surface else "")


def _vector(values: NDArray[np.float64], largest: float) -> str:
    """Three numbers; what is nothing beside the largest is 0."""
    return "(" + ", ".join(f"{v if abs(v) > _NOTHING * largest else 0.0:.5g}" for v in values) + ")"


def _shown(number: Reduced) -> str:
    return figures(number.value, number.error)
